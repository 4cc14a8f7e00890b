"""Damages files of every format that neurbs reads, and reads them.

    python benches/break_files.py --minutes 5
    python benches/break_files.py --minutes 1 --seed 7 --formats .step,.vtk,zlib.vtu
    python benches/break_files.py --case ascii.ply:12 --seed 7 --keep .

Small valid files are damaged one at a time: flipped bits, cuts, other numbers, blocks that are
repeated, deleted or swapped, foreign bytes, the suffix of another format. A worker process reads
each file and compares the result with that of the undamaged file. Case K of a format with a seed
is always the same file, so that ``--case`` makes it again and reads it (a ``.3dm`` file differs in
the identifiers that Rhino's library draws).

Prints a table, a row for each format, then examples of the bad classes:

cut        A file cut before its end mark, or shorter than its counts, is read without an error.
exception  Something other than NeurbsError, OSError or MemoryError is raised.
crash      The worker dies.
hang       The worker gives no answer within 10 seconds, twice.
memory     The worker's peak exceeds 2 GB.

The exit status is 1 if there is a case of a bad class. ``--formats`` takes suffixes, or names as
they stand in the table; ``--keep`` names a folder for the bad files. The extra `test` installs
what writes and reads the formats.
"""

import argparse
import contextlib
import faulthandler
import hashlib
import json
import os
import re
import select
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from break_files_cases import FORMATS, content_of, damaged_file, is_cut, suffix_of

import neurbs
from neurbs.io import LOADABLE

HANG = 10.0
"""Seconds without an answer that count as a hang."""
FIRST_READ = 120.0
"""Seconds for a format's first read in a worker, which imports libraries."""
MEMORY = 2 << 30
"""Bytes of peak memory that count."""
KILL = 4 << 30
"""Bytes at which the worker is ended, for the machine's sake."""
COLUMNS = ("files", "refused", "same", "otherwise", "cut", "exception", "crash", "hang", "memory")
BAD = COLUMNS[4:]
EXAMPLES = 4
"""Examples printed of each bad class of a format, all with different reasons."""


# The worker


def read(path: Path, attributes: bool) -> tuple[int, str]:
    """Return how many points or surfaces are in a file, and a digest of all their numbers."""
    arrays: list[Any] = []
    if path.suffix.lower() in LOADABLE:
        surfaces = neurbs.load_surfaces(path)
        for found in surfaces:
            arrays += [found.control_points, found.weights, *found.knots]
        count = len(surfaces)
    elif attributes:
        cloud = neurbs.read_point_cloud(path)
        arrays, count = [cloud.points, cloud.normals, cloud.colors], len(cloud)
    else:
        arrays = [neurbs.read_points(path)]
        count = len(arrays[0])
    return count, hashlib.sha256(
        b"|".join(b"" if a is None else a.tobytes() for a in arrays)
    ).hexdigest()


def work() -> None:
    """Read the files whose names come from standard input; answer a line of JSON for each."""
    # Libraries print to standard output, too.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    faulthandler.enable()
    for line in sys.stdin:
        path, attributes = json.loads(line)
        faulthandler.dump_traceback_later(0.9 * HANG)
        # Where this fails, the peak is that of the worker's life, which ends with a high one.
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")
        answer: dict[str, Any] = {"outcome": "read"}
        try:
            answer["count"], answer["digest"] = read(Path(path), attributes)
        except (neurbs.NeurbsError, OSError, MemoryError) as error:
            answer = {"outcome": "refused", "why": f"{type(error).__name__}: {error}"}
        except BaseException as error:
            last = traceback.extract_tb(error.__traceback__)
            ours = [frame for frame in last if "neurbs" in Path(frame.filename).parts] or last
            place = f"{Path(ours[-1].filename).name}:{ours[-1].lineno}"
            answer = {"outcome": "exception", "why": f"{type(error).__name__} at {place}: {error}"}
        faulthandler.cancel_dump_traceback_later()
        peak = re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())
        answers.write(
            json.dumps({**answer, "peak": 1024 * int(peak.group(1)) if peak else 0}) + "\n"
        )
        answers.flush()


class Worker:
    """A process that reads files, replaced when it dies, hangs or takes too much memory."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self.log = tempfile.TemporaryFile()  # noqa: SIM115
        self.warm: set[str] = set()

    def stop(self) -> None:
        """End the process, if there is one."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
        self.process, self.warm = None, set()

    def ask(self, path: Path, attributes: bool, limit: float = HANG) -> dict[str, Any]:
        """Read a file; the answer's outcome is read, refused, or the name of a bad class."""
        if self.process is None:
            self.process = subprocess.Popen(
                [sys.executable, __file__, "--worker"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log,
            )  # fmt: skip
        process = self.process
        assert process.stdin is not None
        assert process.stdout is not None
        answer: dict[str, Any] = {"outcome": "hang", "why": f"no answer within {limit:.0f} s"}
        before = self.log.seek(0, os.SEEK_END)
        # A worker that died after its last answer shows below.
        with contextlib.suppress(BrokenPipeError):
            process.stdin.write(json.dumps([str(path), attributes]).encode() + b"\n")
            process.stdin.flush()
        end = time.monotonic() + limit
        while time.monotonic() < end:
            if select.select([process.stdout], [], [], 0.05)[0]:
                line = process.stdout.readline()
                answer = (
                    json.loads(line)
                    if line
                    else {"outcome": "crash", "why": f"exit status {process.wait()}"}
                )
                break
            status = Path(f"/proc/{process.pid}/status").read_text()
            resident = re.search(r"VmRSS:\s*(\d+)", status)
            if resident and 1024 * int(resident.group(1)) > KILL:
                answer = {"outcome": "memory", "why": "over 4 GB, ended"}
                break
        if answer.get("peak", 0) > MEMORY:
            answer = {"outcome": "memory", "why": f"{answer['peak'] / 1e9:.1f} GB"}
        if answer["outcome"] in ("crash", "hang", "memory"):
            self.stop()
            # The innermost line of ours, as faulthandler writes it.
            self.log.seek(before)
            place = re.search(rb'/neurbs/(?:io/)?(\w+\.py)", line (\d+)', self.log.read())
            answer["why"] += f" at {b':'.join(place.groups()).decode()}" if place else ""
        return answer


# The harness


class Harness:
    """Makes the cases of formats, and judges how they are read."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.seed, self.worker = folder, seed, Worker()
        self.contents: dict[str, bytes] = {}
        self.whole: dict[tuple[str, bool], dict[str, Any]] = {}

    def prepare(self, name: str) -> None:
        """Write the undamaged file of a format, and read it where the worker has not yet."""
        path = self.folder / f"whole-{name.replace('.', '-').strip('-')}{suffix_of(name)}"
        if name not in self.contents:
            self.contents[name] = content_of(name, self.folder)
            path.write_bytes(self.contents[name])
        if name in self.worker.warm:
            return
        for attributes in (False, True):
            answer = self.worker.ask(path, attributes, FIRST_READ)
            if answer["outcome"] != "read":
                raise SystemExit(f"{path.name}, which is not damaged, is not read: {answer}")
            self.whole[name, attributes] = answer
        self.worker.warm.add(name)

    def judge(self, name: str, number: int) -> tuple[str, str, Path]:
        """Make a case and read it; return the column it counts in, why, and the file."""
        self.prepare(name)
        content = self.contents[name]
        path, how, end, attributes = damaged_file(self.folder, name, number, self.seed, content)
        answer = self.worker.ask(path, attributes)
        if answer["outcome"] in ("crash", "hang"):
            # Once more in a fresh worker: an earlier file or a busy machine may be to blame.
            self.prepare(name)
            again = self.worker.ask(path, attributes)
            if answer["outcome"] == "hang":
                answer = again
            elif again["outcome"] != "crash":
                answer["why"] += ", not in a fresh process"
        if answer["outcome"] != "read":
            return answer["outcome"], f"{how}: {answer['why']}", path
        whole = self.whole[name, attributes]
        if end is not None and is_cut(name, content, end):
            count = "all" if answer["count"] == whole["count"] else "part"
            same = "the same" if answer["digest"] == whole["digest"] else "other"
            return "cut", f"{how}: {count} of {whole['count']} are read, {same} numbers", path
        return "same" if answer["digest"] == whole["digest"] else "otherwise", how, path


def main() -> int:
    """Break files until the time is over; print the table and examples."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--formats", default="", help="suffixes or names, with commas between")
    parser.add_argument("--keep", type=Path, help="folder for the bad files, or for that of --case")
    parser.add_argument("--case", metavar="FORMAT:NUMBER", help="make and read this file only")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.worker:
        work()
        return 0
    chosen = {word for word in arguments.formats.split(",") if word}
    names = [name for name in FORMATS if not chosen or chosen & {name, suffix_of(name)}]
    if unknown := chosen - {*FORMATS, *map(suffix_of, FORMATS)}:
        parser.error(f"unknown formats {' '.join(sorted(unknown))}; known are {' '.join(FORMATS)}")
    counts: defaultdict[str, Counter[str]] = defaultdict(Counter)
    examples: defaultdict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    with tempfile.TemporaryDirectory() as folder:
        harness = Harness(Path(folder), arguments.seed)
        if arguments.case:
            name, _, number = arguments.case.partition(":")
            outcome, why, path = harness.judge(name, int(number))
            if arguments.keep:
                (arguments.keep / path.name).write_bytes(path.read_bytes())
            harness.worker.stop()
            print(f"{path.name}: {outcome}: {why}")
            return int(outcome in BAD)
        end, number = time.monotonic() + 60 * arguments.minutes, 0
        while time.monotonic() < end:
            for name in names:
                outcome, why, path = harness.judge(name, number)
                counts[name].update(["files", outcome])
                reasons = examples[outcome, name]
                # Numbers apart, reasons that differ: one example of each.
                reason = re.sub(r"\d+", "#", why.partition(": ")[2])
                if outcome in BAD and reason not in reasons and len(reasons) < EXAMPLES:
                    reasons[reason] = f"{name}:{number}  {why}"
                    if arguments.keep:
                        (arguments.keep / path.name).write_bytes(path.read_bytes())
                path.unlink()
            number += 1
        harness.worker.stop()
    print("| format | " + " | ".join(COLUMNS) + " |\n|---|" + "---|" * len(COLUMNS))
    total: Counter[str] = sum(counts.values(), Counter())
    for name, row in [*counts.items(), ("all", total)]:
        print(f"| {name} | " + " | ".join(str(row[column] or "") for column in COLUMNS) + " |")
    for bad in BAD:
        lines = [
            line
            for (outcome, _), reasons in examples.items()
            if outcome == bad
            for line in reasons.values()
        ]
        if lines:
            print(f"\n{bad}, make again with --case FORMAT:NUMBER --seed {arguments.seed} --keep .")
            print("\n".join(f"  {line[:300]}" for line in lines))
    return int(any(total[bad] for bad in BAD))


if __name__ == "__main__":
    sys.exit(main())
