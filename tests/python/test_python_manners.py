"""Pickles, reprs, names, type hints and notebooks: what Python programs expect of results."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import neurbs
from neurbs import NurbsSurface, Reconstruction, SelfOrganizingMap


@pytest.fixture(scope="module")
def result() -> Reconstruction:
    x, y = np.random.default_rng(0).random((2, 400))
    return neurbs.reconstruct(np.column_stack([x, y, x * y]), grid=(9, 7))


def test_a_used_result_can_be_pickled(result: Reconstruction, tmp_path: Path) -> None:
    assert len(result.mesh.vertices)
    assert result._repr_html_()
    assert result.surface._repr_html_()
    assert result.z(0.5, 0.5) == pytest.approx(0.25, abs=1e-3)
    result.save(tmp_path / "out.obj")
    result.save(tmp_path / "out.step")
    again = pickle.loads(pickle.dumps(result))
    assert again.surface == result.surface
    assert again.report == result.report
    np.testing.assert_array_equal(again.mesh.vertices, result.mesh.vertices)
    np.testing.assert_array_equal(again.uv, result.uv)
    np.testing.assert_array_equal(again.som.codebook_, result.som.codebook_)
    np.testing.assert_array_equal(again.som.get_params()["init"], result.som.get_params()["init"])


def test_meshes_can_be_pickled() -> None:
    sphere = NurbsSurface.sphere([0, 0, 0], 1)
    shell = neurbs.Shell([sphere])
    for mesh in (sphere.tessellate(), sphere.tessellate(shape=(5, 9)), shell.tessellate()):
        again = pickle.loads(pickle.dumps(mesh))
        assert repr(again) == repr(mesh)
        assert (again.shape, again.max_deviation) == (mesh.shape, mesh.max_deviation)
        for name in ("vertices", "triangles", "normals", "uv", "face_index"):
            np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
        assert not again.vertices.flags.writeable
        assert again.area() == mesh.area()
    state: Any = sphere.tessellate().__reduce__()
    maker, (*parts, triangles, faces, deviation, shape) = state
    with pytest.raises(neurbs.NeurbsError, match="triangles must have indices of vertices"):
        maker(*parts, triangles + np.uint32(10_000_000), faces, deviation, shape)


def held(result: Reconstruction) -> dict[str, Any]:
    """Make an object of each other class that programs keep."""
    points, surface = result.points, result.surface
    curve = surface.isocurve(u=0.5)
    progress: list[neurbs.Progress] = []
    epochs: list[neurbs.Epoch] = []
    som = SelfOrganizingMap(4, 3, epochs=2)
    som.fit(points, progress=progress.append, observer=epochs.append)
    objects = [
        surface.closest_points(points),
        curve.closest_points(points),
        result.face.closest_points(points),
        surface.curvatures([[0.2, 0.3], [0.5, 0.5]]),
        neurbs.fit_heights(points, (6, 5)),
        neurbs.clean(points),
        neurbs.components(points),
        result.shell.edges[0],
        progress[0],
        epochs[0],
    ]
    return {type(each).__name__: each for each in objects}


def same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, other)) and one.dtype == other.dtype
    return bool(one == other)


def test_each_object_that_programs_keep_can_be_pickled_and_copied(result: Reconstruction) -> None:
    import copy

    objects = held(result)
    assert len(objects) == 10
    for name, thing in objects.items():
        attributes = [each for each in dir(thing) if not each.startswith("_")]
        assert attributes
        for again in (pickle.loads(pickle.dumps(thing)), copy.copy(thing), copy.deepcopy(thing)):
            assert type(again) is type(thing)
            assert repr(again) == repr(thing), name
            assert repr(thing).startswith(f"{name}(")
            for attribute in attributes:
                old, new = getattr(thing, attribute), getattr(again, attribute)
                assert same(old, new), (name, attribute)
                if isinstance(old, np.ndarray):
                    assert new.flags.writeable == old.flags.writeable, (name, attribute)


def test_unpickled_results_can_be_overwritten(result: Reconstruction) -> None:
    found = pickle.loads(pickle.dumps(result.surface.closest_points(result.points)))
    moved = result.points + np.array([0, 0, 1])
    assert result.surface.closest_points(moved, out=found) is found
    np.testing.assert_array_equal(found.distances, result.surface.closest_points(moved).distances)


@pytest.mark.parametrize("first", [50, 2000])
def test_a_sample_of_a_stream_continues_after_a_pickle(first: int) -> None:
    points = np.random.default_rng(0).random((5000, 3))
    sample = neurbs.EvenSample(100)
    sample.extend(points[:first])
    again = pickle.loads(pickle.dumps(sample))
    for each in (sample, again):
        each.extend(points[first:])
        assert repr(each) == f"EvenSample({len(sample.points)} of 5000 points)"
    np.testing.assert_array_equal(again.points, sample.points)
    np.testing.assert_array_equal(again.indices, sample.indices)


def test_sums_of_a_map_say_what_they_are(result: Reconstruction) -> None:
    som = SelfOrganizingMap(4, 3).partial_fit(result.points, end_epoch=False)
    assert repr(som._pending).startswith("BatchSums(400 points, mean distance ")


def test_figures_can_be_pickled(result: Reconstruction) -> None:
    figure = result.plot(color="deviation")
    assert pickle.loads(pickle.dumps(figure))._repr_png_() == figure._repr_png_()


def test_reprs_fit_in_a_line(result: Reconstruction) -> None:
    assert repr(result.report).startswith("Report(height, valid, 400 points, net 9 × 7, rms ")
    assert "max deviation" in repr(result.mesh)
    assert repr(result.surface.tessellate(shape=(3, 4))) == (
        "TriangleMesh(12 vertices, 12 triangles, grid 3 × 4)"
    )
    assert repr(result.surface.isocurve(u=0.5)).startswith("NurbsCurve(7 control points, degree 3")
    for thing in (result, result.report, result.mesh, result.som):
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 300


def test_names_of_the_package_are_its_own() -> None:
    names = dir(neurbs)
    assert not {"sys", "os", "threading", "importlib", "TYPE_CHECKING"} & set(names)
    assert {"reconstruct", "NurbsSurface", "io", "__version__", "__doc__"} <= set(names)
    assert all(hasattr(neurbs, name) for name in names)
    for module in (neurbs.io, neurbs.plot, neurbs.report):
        assert not {"np", "sys", "os", "Any", "annotations"} & set(dir(module))
        assert set(module.__all__) <= set(dir(module))
    assert "figures" not in dir(neurbs.plot)


@pytest.mark.parametrize(
    "line",
    [
        'neurbs.reconstruct(points, kind="tub")',
        'neurbs.reconstruct(points, init="gedesic")',
        'neurbs.reconstruct(points, aspect="grid")',
        'neurbs.reconstruct(points, component="all")',
        'neurbs.candidates(points, "tub")',
        'neurbs.reconstruct_paper(points, surface="net")',
        'neurbs.SelfOrganizingMap(topology="tub")',
        'neurbs.SelfOrganizingMap(presentation="skip")',
        'neurbs.reconstruct(points).plot(color="heights")',
        'neurbs.NurbsSurface.sphere([0, 0, 0], 1).plot(backend="plotly")',
    ],
)
def test_misspelt_choices_fail_type_checks(line: str, mypy_errors: dict[str, bool]) -> None:
    assert mypy_errors[line]


RIGHT = (
    'neurbs.reconstruct(points, kind="tube", init="pca")',
    "neurbs.reconstruct(points, init=points.reshape(2, 2, 3))",
    'neurbs.SelfOrganizingMap(init=[[0, 0, 0], [1, 0, 0]], topology="torus")',
)


@pytest.mark.parametrize("line", RIGHT)
def test_right_choices_pass_type_checks(line: str, mypy_errors: dict[str, bool]) -> None:
    assert not mypy_errors[line]


@pytest.fixture(scope="module")
def mypy_errors(
    revealed: Callable[[Path], str], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, bool]:
    """Return for each line whether mypy finds an error in it; all are checked in one run."""
    marks = test_misspelt_choices_fail_type_checks.pytestmark  # type: ignore[attr-defined]
    lines = [*marks[0].args[1], *RIGHT]
    folder = tmp_path_factory.mktemp("mypy")
    start = ["import neurbs, numpy as np", "points = np.zeros((4, 3))"]
    (folder / "program.py").write_text("\n".join([*start, *lines]))
    answer = revealed(folder / "program.py")
    assert "checked 1 source file" in answer
    failed = {int(text.split(":")[1]) for text in answer.splitlines() if ": error:" in text}
    return {line: number in failed for number, line in enumerate(lines, len(start) + 1)}


def test_figures_show_themselves_in_notebooks(result: Reconstruction) -> None:
    figures: list[Any] = [result.plot(), result.surface.plot(), result.som.plot()]
    for figure in figures:
        png = figure._repr_png_()
        assert png.startswith(b"\x89PNG")
    display = pytest.importorskip("IPython.core.formatters").DisplayFormatter()
    formats, _ = display.format(result.plot())
    assert formats["image/png"].startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["tube", "sheet"])
def test_the_map_of_a_result_has_the_parameters_of_its_training(kind: str) -> None:
    turns, z = np.random.default_rng(0).random((2, 900))
    angle = 2 * np.pi * turns
    tube = np.column_stack([np.cos(angle), np.sin(angle), 3 * z])
    sheet = np.column_stack([turns, z, turns * z])
    points: NDArray[np.float64] = tube if kind == "tube" else sheet
    som = neurbs.reconstruct(points, kind="tube" if kind == "tube" else "sheet").som
    parameters = som.get_params()
    assert parameters["topology"] == kind
    assert parameters["training"] == "batch"
    assert parameters["kernel"] == "linear"
    assert parameters["radius"][0] == "exponential"
    assert (parameters["rows"], parameters["cols"]) == som.codebook_.shape[:2]
    again = SelfOrganizingMap(**parameters).fit(points)
    assert again.n_iter_ == som.n_iter_
    # The result was trained in another frame, so only rounding differs.
    np.testing.assert_allclose(again.codebook_, som.codebook_, atol=1e-6)


def test_the_map_of_the_paper_s_method_has_the_paper_s_parameters() -> None:
    points = np.random.default_rng(0).random((30, 3))
    found = neurbs.reconstruct_paper(points, max_steps=3000, seed=4)
    parameters = found.som.get_params()
    assert parameters["neighborhood"] == "bubble"
    assert (parameters["max_steps"], parameters["seed"]) == (3000, 4)
    again = SelfOrganizingMap(**parameters).fit(points)
    np.testing.assert_array_equal(again.codebook_, found.som.codebook_)
