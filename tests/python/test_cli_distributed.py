"""`neurbs reconstruct --distributed`: one surface from all files, in processes of Dask."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import laspy
import numpy as np
import psutil
import pyproj
import pytest
from distributed import LocalCluster

import neurbs


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "neurbs", "reconstruct", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


@pytest.fixture
def tiles(tmp_path: Path) -> list[Path]:
    x, y = np.random.default_rng(0).random((2, 9000))
    points = np.column_stack([x, y, np.sin(3 * x) * y])
    paths = [tmp_path / f"tile{number}.npy" for number in range(3)]
    for path, tile in zip(paths, np.array_split(points[np.argsort(x)], 3), strict=True):
        np.save(path, tile)
    return paths


def test_all_files_give_one_surface(tiles: list[Path], tmp_path: Path) -> None:
    target = tmp_path / "surface.json"
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as cluster:
        address = cluster.scheduler_address
        pattern = tmp_path / "tile*.npy"
        options = ("--distributed", "--scheduler", address, "--grid", "8", "9", "--json")
        done = run(pattern, "-o", target, *options)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)["report"]
    assert report["points"] == 9000
    assert (report["parts"], report["workers"]) == (3, 1)
    whole = neurbs.reconstruct(np.concatenate(list(map(np.load, tiles))), grid=(8, 9))
    surface = neurbs.load_surface(target)
    assert np.abs(surface.control_points - whole.surface.control_points).max() < 1e-9


def test_workers_start_by_themselves(tiles: list[Path], tmp_path: Path) -> None:
    target = tmp_path / "surface.step"
    done = run(*tiles, "-o", target, "--distributed", "--grid", "8", "9")
    assert done.returncode == 0, done.stderr
    assert target.stat().st_size > 1000
    assert "3 on " in done.stdout
    assert done.stderr == ""


def ignores_ctrl_c(process: psutil.Process) -> bool:
    """Whether a process ignores SIGINT, as it does while its workers start."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    ignored = next(line for line in status.splitlines() if line.startswith("SigIgn:"))
    return bool(int(ignored.split()[1], 16) >> (signal.SIGINT - 1) & 1)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells which signals are ignored")
def test_ctrl_c_in_a_terminal_ends_all_processes_in_silence(tmp_path: Path) -> None:
    points = tmp_path / "points.npy"
    np.save(points, np.random.default_rng(0).random((3_000_000, 3)))
    options = ("-o", tmp_path / "surface.step", "--distributed")
    with subprocess.Popen(
        [sys.executable, "-m", "neurbs", "reconstruct", points, *options],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
        text=True,
    ) as job:
        root, deadline = psutil.Process(job.pid), time.monotonic() + 60
        # Workers, and the process that their library starts besides.
        while len(root.children(recursive=True)) < 2 or ignores_ctrl_c(root):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        started = root.children(recursive=True)
        os.killpg(job.pid, signal.SIGINT)
        _, errors = job.communicate(timeout=60)
    assert job.returncode == 130
    assert errors == "interrupted\n"
    assert psutil.wait_procs(started, timeout=20)[1] == []


def test_filters_choose_the_points_of_one_file(tiles: list[Path], tmp_path: Path) -> None:
    target, options = tmp_path / "surface.json", ("--grid", "8", "--json")
    every = np.load(tiles[0])
    done = run(tiles[0], "-o", target, "--bounds", "0,0,0.25,1", *options)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["report"]["points"] == np.sum(every[:, 0] <= 0.25)
    done = run(tiles[0], "-o", target, "--cell", "0.05", *options)
    assert done.returncode == 0, done.stderr
    cells = len(np.unique(np.floor(every / 0.05), axis=0))
    assert json.loads(done.stdout)["report"]["points"] == cells < len(every)


def test_classes_and_boxes_choose_the_points_of_all_files(tmp_path: Path) -> None:
    every = np.random.default_rng(0).random((12_000, 3))
    every[:, 2] = np.sin(3 * every[:, 0]) * every[:, 1]
    every[::4, 2] += 0.5  # Of class 0: it must not count.
    for number, tile in enumerate(np.split(every, 3)):
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales = np.full(3, 1e-5)
        header.add_crs(pyproj.CRS.from_epsg(32633))
        file = laspy.LasData(header)
        file.x, file.y, file.z = tile.T
        file.classification = np.arange(len(tile)) % 4
        file.write(tmp_path / f"tile{number}.laz")
    target = tmp_path / "surface.json"
    done = run(
        *(tmp_path / "tile*.laz", "-o", target, "--distributed", "--grid", "8", "--json"),
        *("--las-classes", "1,2", "--bounds", "-1,0,0.5,1"),
    )
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    wanted = np.isin(np.arange(12_000) % 4, [1, 2]) & (every[:, 0] <= 0.5)
    assert document["report"]["points"] == pytest.approx(wanted.sum(), abs=3)  # Rounded to 1e-5.
    assert document["report"]["max"] < 0.01
    assert document["unit"] == "m"
    assert neurbs.load_shell(target).unit == "m"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--scheduler", "tcp://127.0.0.1:1"], "must come with --distributed"),
        (["--distributed", "--suffix", "step"], "must be files"),
        (["--bounds", "1,2,3"], "'--bounds': must be the lowest and the highest"),
        (["--cell", "big"], "'--cell': must be a number above 0"),
        (["--las-classes", "ground"], "'--las-classes': must be integers"),
    ],
)
def test_wrong_options_are_refused(
    tiles: list[Path], tmp_path: Path, options: list[str], message: str
) -> None:
    done = run(*tiles, "-o", tmp_path, *options)
    assert done.returncode == 2
    assert message in done.stderr


def test_classes_of_other_files_are_refused(tiles: list[Path], tmp_path: Path) -> None:
    done = run(tiles[0], "-o", tmp_path / "a.step", "--las-classes", "2")
    assert done.returncode == 1
    assert "tile0.npy: las_classes must be left out" in done.stderr
