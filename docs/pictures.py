"""Make the pictures of the documentation.

    python docs/pictures.py [NAME ...]

Without names, all of them. The one of the report needs playwright and a Chromium.
"""

import shutil
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import stage_pictures
from matplotlib.figure import Figure
from matplotlib.image import imread, imsave
from numpy.typing import NDArray

import neurbs
from neurbs.plot import plot_shell

HERE = Path(__file__).parent
IMAGES = HERE / "images"
TERRAIN = HERE.parent / "examples" / "jacksboro.xyz"


def deviation(path: Path) -> None:
    """Draw the terrain with its deviation."""
    result = neurbs.reconstruct(neurbs.read_points(TERRAIN))
    result.plot(color="deviation", unit="m").savefig(path, dpi=80)


def bending(path: Path) -> None:
    """Draw the mean curvature of a hilly sheet, and its stripes."""
    u = v = np.linspace(0, 3, 12)
    x, y = np.meshgrid(u, v, indexing="ij")
    z = 0.25 * np.sin(2 * x) * np.cos(1.5 * y)
    surface = neurbs.NurbsSurface.interpolate(np.stack([x, y, z], axis=-1))
    beside(path, [surface.plot(color=color, isolines=0) for color in ("mean", "zebra")])


def grids(path: Path) -> None:
    """Draw the terrain on three grids."""
    points = neurbs.read_points(TERRAIN)
    results = [neurbs.reconstruct(points, grid=(side, side)) for side in (8, 16, 32)]
    beside(path, [result.surface.plot(isolines=0) for result in results])


def unfolding(path: Path) -> None:
    """Film a lattice that spreads over a folded sheet, from a start along the surface."""
    angle, y = np.random.default_rng(0).random((2, 3000)) * [[3 * np.pi], [3.0]]
    x = np.where(angle < 1.5 * np.pi, np.sin(angle), -2 - np.sin(angle))
    points = np.column_stack([x, y, -np.cos(angle)])
    neurbs.SelfOrganizingMap(24, 8, init="geodesic").animate(points, path, seconds=4)


def shells(path: Path) -> None:
    """Draw a tube closed by two caps, and a plate with holes."""

    def circle(u: float, v: float, radius: float) -> list[neurbs.NurbsCurve]:
        return [neurbs.NurbsCurve.arc([u, v, 0], [radius, 0, 0], [0, radius, 0])]

    def cap(z: float) -> neurbs.Face:
        plane = neurbs.NurbsSurface.plane([-2, -2, z], [4, 0, 0], [0, 4, 0])
        return neurbs.Face(plane, [circle(0.5, 0.5, 0.25)])

    tube = neurbs.NurbsSurface.cylinder([0, 0, 0], [0, 0, 2], 1)
    can = neurbs.Shell([tube, cap(0).reversed(), cap(2)])
    x, y = np.meshgrid(np.linspace(0, 5, 9), np.linspace(0, 4, 9), indexing="ij")
    hills = neurbs.NurbsSurface.interpolate(np.stack([x, y, 0.3 * np.sin(x) * y], axis=-1))
    corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    outer = [neurbs.NurbsCurve(corners[k : k + 2], degree=1) for k in range(4)]
    holes = [circle(0.1 + 0.2 * i, 0.125 + 0.25 * j, 0.06) for i in range(5) for j in range(4)]
    plate = neurbs.Shell(neurbs.Face(hills, [outer, *holes]))
    beside(path, [plot_shell(can), plot_shell(plate)])


def trim(path: Path) -> None:
    """Draw the surface through points of a disc with two holes, untrimmed and trimmed."""
    u, v = np.random.default_rng(0).uniform(-1, 1, (2, 4000))
    away = [np.hypot(u - x, v - y) for x, y in ((0, 0), (0.35, 0.1), (-0.4, -0.25))]
    kept = (away[0] < 1) & (away[1] > 0.27) & (away[2] > 0.16)
    x, y = 50 * u[kept], 50 * v[kept]
    points = np.column_stack([x, y, 10 * np.sin(x / 25) * np.cos(y / 30)])
    results = [neurbs.reconstruct(points, trim=trim) for trim in (False, True)]
    drawn = [plot_shell(result.shell, result.points, isolines=12) for result in results]
    beside(path, drawn)


def trimmed(path: Path) -> None:
    """Draw terrain with a ragged outline and a lake, as points and as a face."""
    points = neurbs.read_points(TERRAIN)
    x, y = points[:, 0] - 15_000, points[:, 1] - 16_000
    angle = np.arctan2(y, x)
    outline = 13_500 * (1 + 0.08 * np.sin(3 * angle + 1) + 0.03 * np.sin(8 * angle))
    lake = np.hypot((x - 4_000) / 1.5, y + 3_000) < 2_500
    land = (np.hypot(x, y) < outline) & ~lake
    result = neurbs.reconstruct(points[land], kind="height")
    result.plot().savefig(path, dpi=100)


def report(path: Path) -> None:
    """Photograph the report in a browser."""
    from playwright.sync_api import sync_playwright

    result = neurbs.reconstruct(neurbs.read_points(TERRAIN))
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        page_file = Path(folder, "report.html")
        result.write_report(page_file, unit="m", source="jacksboro.xyz")
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
        )
        page = browser.new_page(viewport={"width": 1000, "height": 1240})
        page.set_default_timeout(300_000)
        page.goto(page_file.as_uri())
        page.wait_for_function("document.getElementById('chart').data !== undefined")
        page.wait_for_timeout(3000)
        page.screenshot(path=path)
        browser.close()


def beside(path: Path, figures: list[Figure]) -> None:
    """Put figures side by side, drawn twice as fine and then halved."""
    with TemporaryDirectory() as folder:
        images: list[NDArray[np.float32]] = []
        for figure in figures:
            part = Path(folder, "part.png")
            figure.savefig(part, dpi=120)
            images.append(imread(part)[..., :3])
    height = max(len(image) for image in images)
    padding = [((0, height - len(image)), (0, 0), (0, 0)) for image in images]
    padded = map(partial(np.pad, constant_values=1), images, padding)
    whole = np.concatenate(list(padded), axis=1)
    rows, cols = (side // 2 for side in whole.shape[:2])
    fine = whole[: 2 * rows, : 2 * cols].reshape(rows, 2, cols, 2, 3)
    imsave(path, np.ascontiguousarray(fine.mean(axis=(1, 3))))


PICTURES: dict[str, Callable[[Path], None]] = {
    "deviation.png": deviation,
    "bending.png": bending,
    "grids.png": grids,
    "unfolding.gif": unfolding,
    "shells.png": shells,
    "trim.png": trim,
    "trimmed.png": trimmed,
    "report.png": report,
    "flow.svg": stage_pictures.flow,
    "prepare.png": stage_pictures.prepare,
    "observe.png": stage_pictures.observe,
    "propose.png": stage_pictures.propose,
    "coarse_fit.png": stage_pictures.coarse_fit,
    "select.png": stage_pictures.select,
    "refine.png": stage_pictures.refine,
    "validate.png": stage_pictures.validate,
    "measure.png": stage_pictures.measure,
}


def main() -> None:
    """Make what is named on the command line."""
    for name in sys.argv[1:] or PICTURES:
        PICTURES[name](IMAGES / name)


if __name__ == "__main__":
    main()
