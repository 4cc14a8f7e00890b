"""The report: content of the page, and its display in a browser."""

import json
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import NeurbsError, Reconstruction, TrimReport
from neurbs.deviation import Deviation
from neurbs.diagnostics import Diagnostic
from neurbs.report.figures import convergence, scene
from neurbs.report.verdict import Verdict, verdict

pytest.importorskip("plotly", reason="plotly is not installed: pip install 'neurbs[report]'")

MEGABYTE = 2**20


@pytest.fixture(scope="module")
def report(result: Reconstruction, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the report of the small surface."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    result.write_report(path, tolerance=0.8, unit="m", source="a scan.xyz")
    return path


@pytest.fixture(scope="module")
def page(report: Path) -> str:
    return report.read_text(encoding="utf-8")


def figures(page: str) -> Any:
    (data,) = re.findall(r'<script id="figures" type="application/json">(.*?)</script>', page)
    return json.loads(data.replace("<\\/", "</"))


def test_the_page_has_the_measures(page: str, result: Reconstruction) -> None:
    distances = result.surface.closest_points(result.points).distances
    rms = np.sqrt(np.mean(distances**2))
    for words in (
        f"{rms:.4g} m",
        f"{distances.max():.4g} m",
        f"{np.percentile(distances, 99):.4g} m",
        f"{100 * np.mean(distances <= 0.8):.3f} % of the points, within 0.8 m",
        "Of 400 points all are shown.",
        f"neurbs {neurbs.__version__}",
    ):
        assert words in page


def test_the_page_has_the_command(page: str) -> None:
    assert "neurbs reconstruct &#x27;a scan.xyz&#x27; -o out.step --grid 9 7" in page
    assert "neurbs.reconstruct(points, grid=(9, 7))" in page


def test_outliers_are_left_out(result: Reconstruction, tmp_path: Path) -> None:
    far = replace(
        result,
        points=np.vstack([result.points, [[5e6, 7.5e6, 1e5]]]),
        uv=np.vstack([result.uv, [[0, 0]]]),
        deviations=np.append(result.deviations, 1e5),
        inliers=np.append(result.inliers, False),
    )
    far.write_report(tmp_path / "a.html", unit="m")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "Of 401 points all except 1 that were left out of the fit are shown." in page
    assert f"{result.deviations.max():.4g} m" in page
    assert figures(page)["view"]["layout"]["scene"]["zaxis"]["range"][1] < 200


@pytest.mark.parametrize(
    ("options", "command", "call"),
    [
        ({"rational": True, "clean": False}, "--no-clean --rational", "clean=False, rational=True"),
        (
            {"weights": np.ones(400)},
            "# There is no command for this call, because weights is an array.",
            "weights=weights",
        ),
        ({"trim": True}, "--trim yes", "trim=True"),
        ({"trim": False}, "--trim no", "trim=False"),
        ({"seed": 3, "init": "pca"}, "--init pca --seed 3", "init=&#x27;pca&#x27;, seed=3"),
    ],
)
def test_each_kind_of_setting_can_be_repeated(
    options: dict[str, Any], command: str, call: str, result: Reconstruction, tmp_path: Path
) -> None:
    settings = result.settings | options
    replace(result, settings=settings).write_report(tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert command in page
    assert f"neurbs.reconstruct(points, grid=(9, 7), {call})" in page


def test_the_histogram_has_all_points(page: str) -> None:
    (bars,) = figures(page)["histogram"]["data"]
    assert numbers(bars["y"]).sum() == pytest.approx(100, abs=1e-4)


def test_the_chart_belongs_to_the_method(page: str, result: Reconstruction, tmp_path: Path) -> None:
    # Least squares: the share of points within each distance.
    (curve,) = figures(page)["chart"]["data"]
    assert "<h2>Points within a distance</h2>" in page
    distances, percents = numbers(curve["x"]), numbers(curve["y"])
    np.testing.assert_allclose(distances[-1], result.deviations.max(), rtol=1e-6)
    middle = np.percentile(result.deviations, 50)
    assert np.interp(50, percents, distances) == pytest.approx(middle, rel=1e-5)
    # The paper's method: its training.
    paper = neurbs.reconstruct_paper(result.points)
    paper.write_report(tmp_path / "a.html")
    of_paper = (tmp_path / "a.html").read_text(encoding="utf-8")
    (curve,) = figures(of_paper)["chart"]["data"]
    assert "<h2>Convergence</h2>" in of_paper
    np.testing.assert_allclose(
        numbers(curve["y"]), [error for *_, error in paper.history], rtol=1e-6
    )


def test_the_axis_of_the_training_has_names_that_are_not_cut(result: Reconstruction) -> None:
    history = [("training", 1, 5.0), ("training", 2, 0.2)]
    axis = convergence(replace(result, history=history), "")["layout"]["yaxis"]
    assert axis["title"]["text"] == "mean distance to the map"
    ticks = dict(zip(axis["ticktext"], axis["tickvals"], strict=True))
    assert {"0.2", "0.5", "1", "2", "5"} <= set(ticks)
    assert all(float(text) == place for text, place in ticks.items())


def test_the_colors_of_noisy_points_have_their_scale(result: Reconstruction) -> None:
    noise = np.random.default_rng(0).normal(size=len(result.points))
    deviation = Deviation(result.uv, noise)
    data = scene(result, deviation, None, "")["data"]
    points = next(trace for trace in data if trace["meta"] == "points")["marker"]
    # Local means of the noise are smaller than it is.
    limit = np.median(np.abs(noise))
    assert (points["cmin"], points["cmax"]) == pytest.approx((-limit, limit))


def numbers(packed: dict[str, str]) -> NDArray[Any]:
    import base64

    assert packed["dtype"] in ("f4", "i4")
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype=f"<{packed['dtype']}")


# Verdict


def judged(result: Reconstruction, **options: Any) -> Verdict:
    return verdict(result, Deviation.of_result(result), options.get("tolerance"), "mm")


def test_a_good_result_is_called_good(disc: Reconstruction) -> None:
    found = judged(disc, tolerance=0.1)
    assert (found.level, found.title) == ("good", "Good to use")
    assert found.answers["Tolerance kept?"] == "Yes: all points lie within 0.1 mm."
    assert found.answers["Left out?"].startswith("Nothing: all")
    assert re.match(r"Yes: the face has 1 hole and an area of \d+ mm²", found.answers["Trimmed?"])
    assert found.answers["What to do?"] == "Nothing."


def test_a_tolerance_that_is_missed_comes_first(result: Reconstruction) -> None:
    middle = float(np.median(result.deviations))
    found = judged(result, tolerance=middle)
    assert (found.level, found.title) == ("bad", "The tolerance is not kept")
    assert (
        f"200 are farther away, by up to {result.deviations.max():.4g} mm."
        in (found.answers["Tolerance kept?"])
    )
    assert "Raise the tolerance" in found.answers["What to do?"]


def test_a_surface_with_defects_is_called_not_valid(result: Reconstruction) -> None:
    message = "The surface folds over. Use another `kind`."
    folded = Diagnostic("folded", message, {}, is_defect=True)
    report = replace(result.report, valid=False, diagnostics=(folded,))
    found = judged(replace(result, report=report))
    assert (found.level, found.title) == ("bad", "The surface is not valid")
    assert found.answers["Valid?"] == "No: folded."
    assert found.answers["What to do?"] == "Follow the advice in the warning below."


def test_a_face_that_could_not_be_trimmed_is_not_called_complete(result: Reconstruction) -> None:
    untrimmed = Diagnostic("untrimmed", "The surface was not trimmed.", {}, is_defect=False)
    area = TrimReport(16_987_654.0, 16_987_654.0, (), 0.0, 0.01, 0.01)
    report = replace(result.report, diagnostics=(untrimmed,), trim=area)
    answer = judged(replace(result, report=report)).answers["Trimmed?"]
    assert answer == (
        "No: the face is the whole surface, of area 16,990,000 mm². "
        "The warning below gives the reason."
    )


def test_points_that_were_left_out_are_counted(result: Reconstruction) -> None:
    inliers = result.inliers.copy()
    inliers[:4] = False
    for outliers, words in ((4, "all"), (1, "1 of them")):
        report = replace(result.report, outliers=outliers)
        answer = judged(replace(result, inliers=inliers, report=report)).answers["Left out?"]
        assert answer == f"4 of 400 points (1 %), {words} as outliers."


def test_verdict_and_warnings_are_above_the_numbers(result: Reconstruction, tmp_path: Path) -> None:
    found = Diagnostic("left-out", "3 of 403 points were left out.", {}, is_defect=False)
    report = replace(result.report, diagnostics=(found,))
    replace(result, report=report).write_report(tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    places = [
        page.index(words)
        for words in ("Usable, with warnings", "3 of 403 points were left out.", "class='card'")
    ]
    assert places == sorted(places)


def test_the_page_says_what_is_not_to_scale(result: Reconstruction, tmp_path: Path) -> None:
    result.write_report(tmp_path / "a.html")
    assert "All axes are to scale." in (tmp_path / "a.html").read_text(encoding="utf-8")
    flat = neurbs.reconstruct(result.points * [1, 1, 0.05], grid=(5, 5))
    flat.write_report(tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert re.search(r"Not to scale: axes are drawn longer \(.*z.* × [\d.]+\)", page)


def test_the_faces_of_the_page_have_the_hole(disc: Reconstruction, tmp_path: Path) -> None:
    disc.write_report(tmp_path / "a.html")
    data = figures((tmp_path / "a.html").read_text(encoding="utf-8"))["view"]["data"]
    faces = [trace for trace in data if trace["type"] == "mesh3d"]
    for trace in faces:
        places = np.stack([numbers(trace[axis]) for axis in "xyz"], axis=1)
        corners = np.stack([numbers(trace[corner]) for corner in "ijk"], axis=1)
        centers = places[corners].mean(axis=1)
        assert np.hypot(centers[:, 0] - 15, centers[:, 1]).min() > 16
        assert np.hypot(*centers[:, :2].T).max() < 52
    (lines,) = (trace for trace in data if trace["meta"] == "isolines")
    x, y = (numbers(lines[axis]) for axis in "xy")
    assert np.nanmin(np.hypot(x - 15, y)) > 16


def test_a_given_command_is_the_one_to_repeat(result: Reconstruction, tmp_path: Path) -> None:
    words = "neurbs reconstruct a.csv --columns 1,2,3 -o a.html"
    result.write_report(tmp_path / "a.html", source="a.csv", command=words)
    assert f"<pre>{words}</pre>" in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_digits_far_from_the_origin_are_kept(page: str, result: Reconstruction) -> None:
    points = next(t for t in figures(page)["view"]["data"] if t["meta"] == "points")
    shown = np.stack([numbers(points[axis]) for axis in "xyz"], axis=1)
    np.testing.assert_allclose(shown, result.points - [5e6, 7.5e6, 0], atol=1e-4)


def test_holes_are_gray(tmp_path: Path, rng: np.random.Generator) -> None:
    x, y = rng.random((2, 4000))
    cloud = np.column_stack([x, y, 0.1 * np.sin(5 * x)])
    ring = np.hypot(x - 0.5, y - 0.5) > 0.25
    whole = neurbs.reconstruct(cloud, grid=(8, 8))
    for inliers, has_gray in ((np.ones(4000, bool), False), (ring, True)):
        replace(whole, inliers=inliers).write_report(tmp_path / "a.html")
        data = figures((tmp_path / "a.html").read_text(encoding="utf-8"))["view"]["data"]
        (faces,) = (trace for trace in data if trace["type"] == "mesh3d")
        gray = np.array([text == "no points near" for text in faces["hovertext"]])
        assert gray.any() == has_gray
        colors = np.array(
            [[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in faces["vertexcolor"]]
        )
        # Gray is bluish, and pale places of the scale are yellowish.
        assert (colors[gray, 2] > colors[gray, 0]).all()
        if has_gray:
            x, y = numbers(faces["x"])[gray], numbers(faces["y"])[gray]
            assert np.hypot(x - 0.5, y - 0.5).max() < 0.3


def test_a_large_cloud_is_sampled_and_the_file_stays_small(
    result: Reconstruction, tmp_path: Path
) -> None:
    arrays = ("points", "uv", "deviations", "inliers")
    many: dict[str, Any] = {name: np.repeat(getattr(result, name), 1000, axis=0) for name in arrays}
    path = tmp_path / "large.html"
    replace(result, **many).write_report(path)
    assert path.stat().st_size < 8 * MEGABYTE
    page = path.read_text(encoding="utf-8")
    assert "A sample of 60,000 of 400,000 points is shown; all are measured." in page
    assert "no tolerance was given" in page


def test_names_are_no_markup(result: Reconstruction, tmp_path: Path) -> None:
    result.write_report(tmp_path / "a.html", source="<script>alert(1)</script>", unit="</script>")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert len(re.findall("</script>", page)) == len(re.findall(r"<script[ >]", page)) == 3


def test_a_unit_does_not_open_a_script(result: Reconstruction, tmp_path: Path) -> None:
    # An escaped "</script>" does not end the script.
    unit = "<!--<script>"
    result.write_report(tmp_path / "a.html", unit=unit)
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    held = re.search(r'<script id="figures" type="application/json">(.*?)</script>', page, re.S)
    assert held
    assert not set("<>&") & set(held[1])
    assert unit in str(json.loads(held[1]))


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.pdf", {}, "a report must have the suffix .html, got the suffix '.pdf'"),
        ("a", {}, "got no suffix"),
        ("a.html", {"tolerance": -1}, "tolerance must be positive and finite, got -1"),
    ],
)
def test_wrong_arguments_are_refused(
    name: str, options: dict[str, Any], message: str, result: Reconstruction, tmp_path: Path
) -> None:
    with pytest.raises(NeurbsError, match=message):
        result.write_report(tmp_path / name, **options)
    assert not any(tmp_path.iterdir())


def test_without_plotly_it_says_what_to_install(
    result: Reconstruction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "plotly", None)
    monkeypatch.delitem(sys.modules, "plotly.offline", raising=False)
    with pytest.raises(NeurbsError, match=re.escape("pip install 'neurbs[report]'")):
        result.write_report(tmp_path / "a.html")
    assert not any(tmp_path.iterdir())


# In a browser

PATIENCE = 300_000
"""Longest time to draw, in milliseconds; a busy machine without a graphics card is slow."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Start a headless Chromium, of playwright or of the system."""
    sync = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync.sync_playwright() as playwright:
        own = Path(playwright.chromium.executable_path)
        system = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
        if not own.exists() and system is None:
            pytest.skip("there is no browser: playwright install chromium")
        # A container has no graphics card and no sandbox.
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        chromium = playwright.chromium.launch(
            executable_path=None if own.exists() else system, args=flags
        )
        yield chromium
        chromium.close()


def pixels(element: Any) -> NDArray[np.int64]:
    from PIL import Image

    with Image.open(BytesIO(element.screenshot(timeout=PATIENCE))) as image:
        return np.asarray(image.convert("RGB"), dtype=np.int64)


def colored(image: NDArray[np.int64]) -> float:
    """Return the share of pixels that are clearly red or blue."""
    return float(np.mean(np.abs(image[..., 0] - image[..., 2]) > 40))


def test_a_browser_shows_and_rotates_the_surface(
    result: Reconstruction, tmp_path: Path, browser: Any
) -> None:
    report = tmp_path / "report.html"
    result.write_report(report)
    page = browser.new_page(viewport={"width": 700, "height": 800})
    page.set_default_timeout(PATIENCE)
    complaints: list[str] = []
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url))
    page.goto(report.as_uri())
    page.wait_for_function("document.getElementById('chart').data !== undefined")
    view = page.locator("#view")
    page.wait_for_selector("#view canvas")
    page.wait_for_timeout(1000)
    first = pixels(view)
    # Surface, points and legend are drawn on white.
    assert colored(first) > 0.03
    assert 0.3 < np.mean((first > 250).all(axis=2)) < 0.95
    for figure in ("#histogram", "#chart"):
        assert np.mean((pixels(page.locator(figure)) < 250).any(axis=2)) > 0.01

    view.scroll_into_view_if_needed()
    box = view.bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 150, middle[1] + 40, steps=4)
    page.mouse.up()
    page.wait_for_timeout(1000)
    turned = pixels(view)
    assert np.mean((turned != first).any(axis=2)) > 0.05
    assert colored(turned) > 0.03

    page.locator("[data-switches=points]").uncheck()
    page.wait_for_timeout(1000)
    without = pixels(view)
    assert np.mean((without != turned).any(axis=2)) > 0.002
    page.locator("[data-switches=surface]").uncheck()
    page.wait_for_timeout(1000)
    assert colored(pixels(view)) < 0.5 * colored(without)

    assert complaints == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
    page.close()


@pytest.mark.parametrize("extent", [[1, 1, 1], [1, 1, 0.06], [0.3, 0.3, 1], [1, 0.1, 0.1]])
@pytest.mark.parametrize("width", [360, 700, 1280])
def test_the_view_is_full_and_nothing_is_cut_off(
    extent: list[float], width: int, result: Reconstruction, tmp_path: Path, browser: Any
) -> None:
    sphere = neurbs.NurbsSurface.sphere([0, 0, 0], 100)
    u, v = np.random.default_rng(0).random((2, 500))
    points = sphere(u, v) * extent
    squeezed = sphere.transformed(np.diag([*extent, 1.0]))
    # With a unit of parts, all axes are to scale.
    found = replace(
        result,
        points=points,
        surface=squeezed,
        shell=neurbs.Shell(squeezed),
        uv=np.column_stack([u, v]),
        inliers=np.ones(500, bool),
        deviations=np.zeros(500),
        unit="mm",
    )
    found.write_report(tmp_path / "a.html")
    page = browser.new_page(viewport={"width": width, "height": 900})
    page.set_default_timeout(PATIENCE)
    page.goto((tmp_path / "a.html").as_uri())
    page.wait_for_selector("#view canvas")
    page.wait_for_timeout(1000)
    image = pixels(page.locator("#view canvas"))
    page.close()
    drawn: NDArray[np.bool_] = np.any(image < 215, axis=2)
    # Nothing touches the sides.
    for side in (drawn[:, :2], drawn[:, -2:], drawn[-2:]):
        assert not side.any()
    height, across = (np.ptp(np.nonzero(drawn)[axis]) / drawn.shape[axis] for axis in (0, 1))
    assert max(height, across) > 0.6


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_a_telephone_and_follows_the_theme(
    scheme: str, report: Path, browser: Any
) -> None:
    page = browser.new_page(viewport={"width": 360, "height": 700}, color_scheme=scheme)
    page.set_default_timeout(PATIENCE)
    page.goto(report.as_uri())
    page.wait_for_function("document.getElementById('chart').data !== undefined")
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    background = page.evaluate("document.getElementById('chart').layout.paper_bgcolor")
    assert background == {"light": "#ffffff", "dark": "#1d242b"}[scheme]
    image = pixels(page.locator("section.verdict"))
    assert (np.median(image) > 128) == (scheme == "light")
    page.close()
