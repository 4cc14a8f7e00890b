"""The package as users import and install it."""

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import neurbs

PYTHON = Path(__file__).parents[2] / "python"


def python(program: str) -> str:
    """Run a program in another Python process, and return its output."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_public_name_is_there() -> None:
    for name in neurbs.__all__:
        assert getattr(neurbs, name) is getattr(neurbs, name)
        assert name in dir(neurbs)
    with pytest.raises(AttributeError, match="module 'neurbs' has no attribute 'recontruct'"):
        neurbs.recontruct  # type: ignore[attr-defined] # noqa: B018


def test_nothing_is_imported_before_it_is_used() -> None:
    loaded = json.loads(
        python(
            """
            import json, sys
            import neurbs
            first = sorted(sys.modules)
            neurbs.reconstruct, neurbs.NurbsSurface, neurbs.read_points, neurbs.SelfOrganizingMap
            print(json.dumps([first, sorted(sys.modules)]))
            """
        )
    )
    heavy = {"typer", "rich", "trimesh", "matplotlib", "scipy", "plotly", "pyvista", "OCP", "vtk"}
    for modules in loaded:
        assert heavy & {name.partition(".")[0] for name in modules} == set()
    assert "numpy" not in loaded[0]
    assert "numpy" in loaded[1]


def test_a_first_call_imports_only_what_it_uses() -> None:
    program = """
        import sys
        import numpy as np
        import neurbs
        print("neurbs.reconstruction" in sys.modules)
        x, y = np.linspace(0, 1, 200), np.linspace(0, 40, 200) % 1
        neurbs.reconstruct(np.column_stack([x, y, x * y]))
        print(sorted({"neurbs.io", "json", "secrets", "tempfile", "zipfile"} & set(sys.modules)))
    """
    assert python(program) == "True\n[]\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="only some systems fork")
def test_a_fork_of_a_process_that_has_reconstructed_does_so_too() -> None:
    program = """
        import os
        import numpy as np
        import neurbs
        x, y = np.random.default_rng(0).random((2, 1000))
        points = np.column_stack([x, y, x * y])
        here = neurbs.reconstruct(points).report.rms
        if child := os.fork():
            print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        else:
            os._exit(neurbs.reconstruct(points).report.rms != here)
    """
    assert python(program) == "0\n"


def test_a_module_does_not_hide_a_function() -> None:
    program = """
        import neurbs.cli, neurbs.io, neurbs.plot, neurbs.report, neurbs.reconstruction
        import neurbs
        print(callable(neurbs.reconstruct), callable(neurbs.save))
    """
    assert python(program) == "True True\n"


def test_versions_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    neurbs.show_versions()
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert lines["python"] == ".".join(map(str, sys.version_info[:3]))
    assert {"numpy", "neurbs", "system", "matplotlib"} <= lines.keys()


USER_PROGRAM = '''
"""A user's program."""

import numpy as np
from numpy.typing import NDArray

import neurbs


def surface_of(points: NDArray[np.float64]) -> neurbs.NurbsSurface:
    result: neurbs.Reconstruction = neurbs.reconstruct(points, grid=(8, 8), degree=3)
    rms: float = result.report.quantization_error
    if rms > 1.0:
        raise neurbs.NeurbsError("too far")
    result.save("a.step")
    result.write_report("a.html", tolerance=0.1)
    return result.surface


def main() -> None:
    points: NDArray[np.float64] = neurbs.read_points("scan.xyz")
    surface = surface_of(points)
    uv: NDArray[np.float64] = surface.closest_points(points).uv
    low, high = surface.bounding_box()
    som: neurbs.SelfOrganizingMap = neurbs.SelfOrganizingMap(8, 8).fit(points)
    nodes: NDArray[np.float64] = som.codebook_
    surface.plot(points, color="deviation")
    som.plot(points).savefig("map.png")
    mesh: neurbs.TriangleMesh = surface.tessellate(shape=(10, 10))
    neurbs.save(mesh, "a.ply")
    print(uv.shape, low, high, nodes.shape, mesh.triangles.shape)
'''


MISTAKES = """
import neurbs
neurbs.reconstruct([[0.0]], grid=3)
neurbs.NurbsSurface([[[0.0]]]).knot
"""


def test_types_are_complete_and_find_mistakes(tmp_path: Path) -> None:
    pytest.importorskip("mypy", reason="mypy is not installed")
    (tmp_path / "program.py").write_text(USER_PROGRAM, encoding="utf-8")
    (tmp_path / "mistakes.py").write_text(MISTAKES, encoding="utf-8")
    # Errors inside the package are not reported to users.
    flags = ["--strict", "--follow-imports=silent", "--no-error-summary"]
    command = [sys.executable, "-m", "mypy", *flags, "."]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        # For a package that is not installed.
        env=os.environ | {"MYPYPATH": str(PYTHON)},
        timeout=600,
    )
    lines = done.stdout.splitlines()
    places = [line.partition(": error:")[0] for line in lines if ": note:" not in line]
    assert places == ["mistakes.py:3", "mistakes.py:4"], done.stdout
