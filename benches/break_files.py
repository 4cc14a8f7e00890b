"""Damages files of every format that neurbs reads, and reads them.

    python benches/break_files.py --minutes 5
    python benches/break_files.py --minutes 1 --seed 7 --formats .step,.vtk,zlib.vtu
    python benches/break_files.py --case ascii.ply:12 --seed 7 --keep .

Small valid files are damaged one at a time: flipped bits, cuts, other numbers, blocks that are
repeated, deleted or swapped, foreign bytes, the suffix of another format. A worker process reads
each file and compares the result with that of the undamaged file. Case K of a format with a seed
is always the same file, so that ``--case`` makes it again and reads it.

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
import hashlib
import json
import os
import re
import select
import struct
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from break_files_formats import FORMATS, content_of, end_of, sealed, suffix_of

import neurbs
from neurbs.io import LOADABLE, READABLE

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
NUMBERS = ("0", "-1", "1000000000", "2147483647", "9223372036854775808", "nan")

Rng = np.random.Generator
Damage = tuple[bytes, str, int | None]
"""The damaged content, how it was damaged, and where it was cut."""


# Damages


def flip_bits(content: bytes, rng: Rng) -> Damage:
    damaged, places = bytearray(content), rng.integers(0, 8 * len(content), rng.integers(1, 9))
    for place in places:
        damaged[place // 8] ^= 1 << (place % 8)
    return bytes(damaged), f"bits {sorted(places.tolist())} flipped", None


def cut(content: bytes, rng: Rng) -> Damage:
    end = int(rng.integers(0, len(content)))
    return content[:end], f"cut at {end} of {len(content)}", end


def cut_at_structure(content: bytes, rng: Rng) -> Damage:
    """Cut before or after a line, a tag or a section, at a round number, or near the end."""
    lines = [m.end() for m in re.finditer(rb"[\n;>}\]]", content)]
    steps = range(0, len(content), int(2 ** rng.integers(2, 8)))
    near_end = range(max(len(content) - 64, 0), len(content))
    places = [place for place in (lines, steps, near_end)[rng.integers(3)] if place < len(content)]
    end = int(rng.choice(places or [0])) - int(rng.integers(2))
    return content[: max(end, 0)], f"cut at {max(end, 0)} of {len(content)}", max(end, 0)


def replace_text_number(content: bytes, rng: Rng) -> Damage:
    numbers = list(re.finditer(rb"-?\d+(\.\d*)?([eE][-+]?\d+)?", content))
    if not numbers:
        return flip_bits(content, rng)
    # Half of the time a number of the header.
    number = numbers[rng.integers(min(len(numbers), 30) if rng.random() < 0.5 else len(numbers))]
    new = NUMBERS[rng.integers(len(NUMBERS))]
    damaged = content[: number.start()] + new.encode() + content[number.end() :]
    return damaged, f"{number.group()!r} at {number.start()} replaced by {new}", None


def replace_binary_number(content: bytes, rng: Rng) -> Damage:
    values: tuple[tuple[str, float], ...] = (
        *(("<i", value) for value in (0, -1, 10**9, 2**31 - 1)),
        *((">i", value) for value in (-1, 10**9, 2**31 - 1)),
        *(("<Q", value) for value in (0, 2**63, 2**64 - 1, 10**9)),
        ("<H", 0xFFFF), ("<d", float("nan")), ("<f", float("nan")), (">d", float("nan")),
    )  # fmt: skip
    kind, value = values[rng.integers(len(values))]
    new = struct.pack(kind, value)
    limit = min(len(content), 400) if rng.random() < 0.5 else len(content)
    place = int(rng.integers(max(limit - len(new), 1)))
    damaged = content[:place] + new + content[place + len(new) :]
    return damaged, f"{value} written as {kind} at {place}", None


def block(content: bytes, rng: Rng) -> tuple[int, int]:
    """Choose a line, some lines, or some bytes."""
    if rng.random() < 0.5 and content.count(b"\n") > 3:
        ends = [0, *(m.end() for m in re.finditer(rb"\n", content))]
        first = int(rng.integers(len(ends) - 1))
        return ends[first], ends[min(first + int(rng.integers(1, 5)), len(ends) - 1)]
    start = int(rng.integers(len(content)))
    return start, min(start + int(2 ** rng.integers(0, 10)), len(content))


def repeat(content: bytes, rng: Rng) -> Damage:
    start, end = block(content, rng)
    times = int(rng.choice([1, 2, 50]))
    damaged = content[:end] + content[start:end] * times + content[end:]
    return damaged, f"{start} to {end} repeated {times} times", None


def delete(content: bytes, rng: Rng) -> Damage:
    start, end = block(content, rng)
    return content[:start] + content[end:], f"{start} to {end} deleted", None


def swap(content: bytes, rng: Rng) -> Damage:
    (a, b), (c, d) = sorted([block(content, rng), block(content, rng)])
    b = min(b, c)
    damaged = content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]
    return damaged, f"{a} to {b} and {c} to {d} swapped", None


def insert(content: bytes, rng: Rng) -> Damage:
    foreign = (
        b"\0",
        b"\0" * 16,
        b"\0" * 512,
        b"\xff\xfe",
        b"\xc3\x28",
        b"\x80\x81\x82",
        b"\xed\xa0\x80",
    )
    new = foreign[rng.integers(len(foreign))]
    place = int(rng.integers(len(content) + 1))
    shown = f"{new[:4]!r} × {len(new) // len(new[:4])}"
    return content[:place] + new + content[place:], f"{shown} inserted at {place}", None


DAMAGES: tuple[Callable[[bytes, Rng], Damage], ...] = (
    flip_bits, cut, cut_at_structure, cut_at_structure, replace_text_number, replace_text_number,
    replace_binary_number, replace_binary_number, repeat, delete, swap, insert,
)  # fmt: skip


def damaged_file(
    folder: Path, name: str, number: int, seed: int, content: bytes
) -> tuple[Path, str, int | None, bool]:
    """Write a case; return the file, its damage, its cut, and whether attributes are read."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode()), number])
    suffix, attributes = suffix_of(name), bool(rng.integers(2))
    if rng.random() < 0.03:
        other = [s for s in (*READABLE, *LOADABLE) if s != suffix]
        suffix = other[rng.integers(len(other))]
        how, end = f"suffix {suffix}", None
    else:
        content, how, end = DAMAGES[rng.integers(len(DAMAGES))](content, rng)
        if suffix == ".e57" and rng.random() < 0.7:
            # Or else nothing but the checksums is tested.
            content, how, end = sealed(content), f"{how}, checksums renewed", None
    path = folder / f"{name.replace('.', '-').strip('-')}-{seed}-{number}{suffix}"
    path.write_bytes(content)
    return path, how, end, attributes


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
    for line in sys.stdin:
        path, attributes = json.loads(line)
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
        peak = re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())
        answers.write(
            json.dumps({**answer, "peak": 1024 * int(peak.group(1)) if peak else 0}) + "\n"
        )
        answers.flush()


class Worker:
    """A process that reads files, replaced when it dies, hangs or takes too much memory."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
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
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            )  # fmt: skip
        process = self.process
        assert process.stdin is not None
        assert process.stdout is not None
        answer: dict[str, Any] = {"outcome": "hang", "why": f"no answer within {limit:.0f} s"}
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
        if end is not None and end < end_of(name, content):
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
