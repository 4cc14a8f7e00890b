"""Rules for every reader: a path is a file, and a damaged file is a `NeurbsError`."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from neurbs._core import NeurbsError
from neurbs.errors import printable
from neurbs.io.point_cloud import Block, Doubt

_MAX_CAUSE = 200
"""Most characters of a library's message in an error."""

_OF_DATA = (None, errno.EINVAL, errno.EOVERFLOW, errno.EFBIG)
"""Codes of an OSError that numbers in a file cause: a place before its start, for instance."""


def check_file(path: Path, content: str) -> None:
    """Check that a path is a file that can be opened.

    Parameters
    ----------
    path : Path
        The path.
    content : str
        What is read, as a plural: "points".

    Raises
    ------
    NeurbsError
        If the path is a device or a pipe, or no path can be so.
    OSError
        If there is no such file, or it is a folder.
    """
    try:
        path.stat()
    except ValueError as error:
        raise NeurbsError(f"{printable(str(path))}: must be a path, but has an {error}") from None
    if path.is_dir():
        raise IsADirectoryError(
            errno.EISDIR, f"{content} are read from a file, not a folder", str(path)
        )
    if not path.is_file():
        raise NeurbsError(
            f"{printable(str(path))}: {content} are read from a file, "
            "but this is a device or a pipe"
        )


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn the errors that a library raises for a damaged file into `NeurbsError`.

    An OSError about the file itself, a lack of memory, a missing library, a warning that is an
    error and Ctrl-C stay as they are.

    Examples
    --------
    >>> with reading(Path("a.csv")):
    ...     raise IndexError("no column 3")
    Traceback (most recent call last):
    ...
    neurbs.NeurbsError: a.csv: must be a whole .csv file, but is damaged: no column 3
    """
    try:
        yield
    except NeurbsError as error:
        message = str(error)
        if printable(message) != message:
            error.args = (printable(message),)
        raise
    except (MemoryError, ImportError, Warning):
        raise
    except OSError as error:
        if error.filename is None and error.errno in _OF_DATA:
            raise damaged(path, cause(error)) from error
        if error.filename is None:
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    except Exception as error:
        if isinstance(error, (TypeError, UnicodeEncodeError)) and not _is_text(path):
            raise NeurbsError(
                f"{printable(str(path))}: must have a path in UTF-8, as {path.suffix.lower()} "
                "files are read by a library that takes no other: rename it"
            ) from error
        raise damaged(path, cause(error)) from error
    except BaseException as error:
        if is_panic(error):
            raise damaged(path, cause(error)) from None
        raise


def blocks_of_file(path: Path, blocks: Iterator[Block]) -> Iterator[Block]:
    """Yield the blocks of a file, with the errors of `reading`."""
    with reading(path):
        yield from blocks


def damaged(path: Path, reason: str) -> NeurbsError:
    """Return the error for a damaged file."""
    return NeurbsError(
        printable(f"{path}: must be a whole {path.suffix.lower()} file, but is damaged: {reason}")
    )


def check_size(path: Path, count: int, size: float, content: str, start: int = 0) -> None:
    """Compare a number in a header with the size of the file.

    Parameters
    ----------
    path : Path
        The file.
    count : int
        The number.
    size : float
        The fewest bytes that each takes.
    content : str
        What is counted, as a plural: "points".
    start : int
        Bytes of the file before them.

    Raises
    ------
    NeurbsError
        If the file is too small.
    """
    there = path.stat().st_size
    if start + count * size > there:
        raise NeurbsError(
            printable(
                f"{path}: must have {count} {content}, as in its header, but is cut short or "
                f"damaged: {there} bytes are too few"
            )
        )


def read_whole(path: Path, most: int) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    NeurbsError
        If there are more than `most`.
    """
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise NeurbsError(
            printable(f"{path}: must be a file of at most {most:,} bytes, but is larger")
        )
    return content


def cause(error: BaseException) -> str:
    r"""Return an error as one short line.

    Examples
    --------
    >>> cause(ValueError("bad page\n\nsource.cpp(9) : occurred on\n"))
    'bad page'
    >>> cause(RecursionError())
    'RecursionError'
    """
    lines = (line.strip() for line in str(error).splitlines())
    line = next(filter(None, lines), type(error).__name__)
    return printable(line if len(line) <= _MAX_CAUSE else f"{line[: _MAX_CAUSE - 1]}…")


def crs_doubt(error: Exception) -> Doubt:
    """Return the doubt about a reference system that a library refuses."""
    return Doubt(
        "crs-unknown",
        f"its reference system cannot be read and is left out, as well as the unit: {cause(error)}",
    )


def _is_text(path: Path) -> bool:
    """Whether a path is Unicode: on POSIX systems it may be any bytes."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def is_panic(error: BaseException) -> bool:
    """Whether an error is a panic of a library in Rust, which is no `Exception`."""
    return type(error).__name__ == "PanicException"
