"""Animations of training: formats, content, refusals."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError


@pytest.mark.parametrize(
    ("suffix", "start"), [(".gif", b"GIF89a"), (".html", b"\n<link"), (".mp4", b"\0\0\0")]
)
def test_an_animation_is_written(
    suffix: str, start: bytes, square: NDArray[np.float64], tmp_path: Path
) -> None:
    if suffix == ".mp4" and shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    animation = tmp_path / f"animation{suffix}"
    som = neurbs.SelfOrganizingMap(4, 3)
    assert som.animate(square, animation, seconds=1) is som
    assert animation.read_bytes().startswith(start)
    assert list(tmp_path.iterdir()) == [animation]
    np.testing.assert_array_equal(
        som.codebook_, neurbs.SelfOrganizingMap(4, 3).fit(square).codebook_
    )


def test_the_lattice_unfolds_in_the_animation(square: NDArray[np.float64], tmp_path: Path) -> None:
    from PIL import Image

    som = neurbs.SelfOrganizingMap(6, 6, init="centroid")
    som.animate(square, tmp_path / "a.gif", seconds=1)
    with Image.open(tmp_path / "a.gif") as animation:
        first = np.array(animation.convert("RGB"))
        animation.seek(14)
        last = np.array(animation.convert("RGB"))
        with pytest.raises(EOFError):
            animation.seek(15)  # The last frame is shown for longer instead.
        assert animation.size == (512, 512)

    def width(image: NDArray[np.uint8]) -> float:
        """Return the extent of the blue lattice."""
        red, _, blue = np.moveaxis(image.astype(int), 2, 0)
        return float(np.nonzero(blue - red > 60)[1].std())

    assert width(last) > 2 * width(first)


@pytest.mark.parametrize(
    ("name", "seconds", "message"),
    [
        (
            "a.avi",
            2,
            "an animation must have the suffix .gif, .* got the suffix '.avi'",
        ),
        ("a", 2, "got no suffix"),
        ("a.gif", 0, "seconds must be between 1 and 60, got 0"),
    ],
)
def test_animations_that_are_refused(
    name: str, seconds: float, message: str, square: NDArray[np.float64], tmp_path: Path
) -> None:
    with pytest.raises(NeurbsError, match=message):
        neurbs.SelfOrganizingMap(3, 3).animate(square, tmp_path / name, seconds=seconds)
    assert not any(tmp_path.iterdir())


def test_an_animation_without_ffmpeg(
    square: NDArray[np.float64], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(NeurbsError, match=r"\.mp4 needs the program ffmpeg"):
        neurbs.SelfOrganizingMap(3, 3).animate(square, tmp_path / "a.mp4")
