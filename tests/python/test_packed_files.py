"""Points from compressed files and from standard input."""

import gzip
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pytest
import pyvista
import rasterio
import trimesh
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

POINTS = np.random.default_rng(0).integers(1, 10**6, (50, 3)) / 1000


def table(points: NDArray[np.float64] = POINTS) -> str:
    return "".join(f"{x} {y} {z}\n" for x, y, z in points.tolist())


PTX = "5\n10\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n" + table()

PCD = (
    "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50\nHEIGHT 1\n"
    "POINTS 50\nDATA ascii\n"
)


def write_las(path: Path) -> None:
    header = laspy.LasHeader(point_format=0, version="1.2")
    header.scales = np.full(3, 0.001)
    data = laspy.LasData(header)
    data.x, data.y, data.z = POINTS.T
    data.write(path)


def write_tif(path: Path) -> None:
    shape = {"height": 5, "width": 10, "count": 1, "dtype": "float64"}
    transform = rasterio.transform.from_origin(5, 8, 2, 2)
    with rasterio.open(path, "w", driver="GTiff", transform=transform, **shape) as file:
        file.write(POINTS[:, 2].reshape(5, 10), 1)


PACKERS: dict[str, Callable[[bytes], bytes]] = {".gz": gzip.compress, ".zst": zstd.compress}


@pytest.mark.parametrize("packed", PACKERS)
@pytest.mark.parametrize(
    "suffix", [".xyz", ".csv", ".ply", ".npy", ".las", ".pcd", ".vtp", ".tif", ""]
)
def test_files_are_unpacked(tmp_path: Path, suffix: str, packed: str) -> None:
    inner = tmp_path / f"a{suffix or '.xyz'}"
    match suffix:
        case ".npy":
            np.save(inner, POINTS)
        case ".las":
            write_las(inner)
        case ".pcd":
            inner.write_text(PCD + table())
        case ".vtp":
            pyvista.PolyData(POINTS).save(inner)
        case ".tif":
            write_tif(inner)
        case ".ply":
            neurbs.save(neurbs.PointCloud(POINTS), inner)
        case _:
            inner.write_text(table())
    path = tmp_path / f"b{suffix}{packed.upper()}"
    path.write_bytes(PACKERS[packed](inner.read_bytes()))
    expected = neurbs.read_points(inner)
    np.testing.assert_array_equal(neurbs.read_points(path), expected)
    np.testing.assert_array_equal(np.vstack(list(neurbs.read_points(path, chunks=7))), expected)


@pytest.mark.parametrize("packed", PACKERS)
def test_a_packed_file_is_named_in_messages(tmp_path: Path, packed: str) -> None:
    path = tmp_path / f"a.csv{packed}"
    path.write_bytes(PACKERS[packed](b"x,y,z\n1,2,3\n4,q,6\n"))
    with pytest.raises(NeurbsError, match=rf"a\.csv\{packed}: line 3, column 2 must"):
        neurbs.read_points(path)
    path.write_bytes(PACKERS[packed](b"a,b,c\n1,2,3\n"))
    assert neurbs.read_points(path, columns=("c", "b", "a")).tolist() == [[3, 2, 1]]
    whole = PACKERS[packed](table().encode())
    for end in range(0, len(whole), 7):
        path.write_bytes(whole[:end])
        with pytest.raises(NeurbsError, match=rf"{path}: must "):
            neurbs.read_points(path)


@pytest.mark.parametrize("packed", PACKERS)
def test_a_bomb_is_refused_early(tmp_path: Path, packed: str) -> None:
    path = tmp_path / f"a.xyz{packed}"
    path.write_bytes(PACKERS[packed](b"0 0 0\n" * 50_000_000))
    start = time.process_time()
    with pytest.raises(NeurbsError, match=r"must not grow beyond .* bytes when it is unpacked"):
        neurbs.read_points(path)
    assert time.process_time() - start < 5


def test_an_archive_in_an_archive_is_refused(tmp_path: Path) -> None:
    inner = gzip.compress(table().encode())
    for name in ("a.xyz.gz.gz", "a.gz", "a.npz.gz"):
        (tmp_path / name).write_bytes(gzip.compress(inner))
        with pytest.raises(NeurbsError, match="must be packed once only"):
            neurbs.read_points(tmp_path / name)
    (tmp_path / "a.dwg.gz").write_bytes(inner)
    with pytest.raises(NeurbsError, match=r"with a suffix of .*, got the suffix '\.dwg'"):
        neurbs.read_points(tmp_path / "a.dwg.gz")


def test_no_temporary_file_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    path = tmp_path / "a.xyz.gz"
    path.write_bytes(gzip.compress(table().encode()))
    neurbs.read_points(path)
    chunks = neurbs.read_points(path, chunks=3)
    next(chunks)
    del chunks
    neurbs.read_points(path, chunks=3)  # Not begun.
    path.write_bytes(gzip.compress(b"q"))
    with pytest.raises(NeurbsError):
        neurbs.read_points(path)
    assert list(folder.iterdir()) == []


STDIN = "import sys, neurbs; print(len(neurbs.read_points('-')), file=sys.stderr)"


@pytest.mark.parametrize(
    ("content", "answer"),
    [
        (table().encode(), "50"),
        (gzip.compress(table().encode()), "50"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         b"property float z\nend_header\n1 2 3\n", "1"),
        (b"1 2 3\n4 q 6\n", "standard input: line 2, column 2 must be a finite number"),
        (b"", "standard input: must have at least one point"),
        (b"1" * (1 << 25), "standard input: must be points, but its first line does not end"),
        (bytes(1 << 25), "standard input: must be text, or start as a known format, but is binary"),
        ("x y z\n1 2 3\n".encode("utf-16"), "1"),
    ],
)  # fmt: skip
def test_standard_input_is_read(content: bytes, answer: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", STDIN], input=content, capture_output=True, timeout=60
    )
    assert answer in done.stderr.decode()


@pytest.mark.parametrize(
    "suffix", [".npy", ".las", ".vtp", ".vti", ".vtr", ".3mf", ".glb", ".pcd", ".ptx"]
)
def test_standard_input_has_any_format(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{suffix}"
    match suffix:
        case ".npy":
            np.save(path, POINTS)
        case ".las":
            write_las(path)
        case ".vtp":
            pyvista.PolyData(POINTS).save(path)
        case ".vti":
            pyvista.ImageData(dimensions=(5, 5, 2)).save(path)
        case ".vtr":
            pyvista.RectilinearGrid([0.0, 1], [2.0, 3], [4.0]).save(path)
        case ".pcd":
            path.write_text(PCD + table())
        case ".ptx":
            path.write_text(PTX)
        case _:
            path.write_bytes(
                trimesh.Scene(
                    trimesh.PointCloud(POINTS)
                    if suffix == ".glb"
                    else trimesh.creation.icosphere(1)
                ).export(file_type=suffix[1:])
            )
    expected = len(neurbs.read_points(path))
    done = subprocess.run(
        [sys.executable, "-m", "neurbs", "info", "-", "--json"],
        input=path.read_bytes(),
        capture_output=True,
        timeout=60,
    )
    assert json.loads(done.stdout)["points"] == expected


def test_an_endless_standard_input_does_not_fill_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    class Endless:
        buffer: "Endless"

        def read(self, size: int) -> bytes:
            return b"1 2 3\n" * (size // 6)

    endless = Endless()
    endless.buffer = endless
    monkeypatch.setattr("sys.stdin", endless)
    usage = shutil.disk_usage("/")._replace(free=20 << 20)
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage)
    with pytest.raises(NeurbsError, match=r"must have at most 1e\+07 bytes, half of the disk"):
        neurbs.read_points("-")


def test_commands_read_standard_input(tmp_path: Path) -> None:
    x, y = np.random.default_rng(0).random((2, 200))
    text = table(np.column_stack([x, y, x * y])).encode()
    for words in (
        ["reconstruct", "-", "-o", "a.step", "--grid", "5", "5"],
        ["convert", "-", "a.ply"],
    ):
        done = subprocess.run(
            [sys.executable, "-m", "neurbs", *words], input=text, capture_output=True, cwd=tmp_path
        )
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.step").stat().st_size > 1000
    words = [sys.executable, "-m", "neurbs", "convert", "-", "b.step"]
    done = subprocess.run(words, input=text, capture_output=True, cwd=tmp_path)
    assert b"`neurbs reconstruct - -o b.step`" in done.stderr
    assert len(neurbs.read_points(tmp_path / "a.ply")) == 200
