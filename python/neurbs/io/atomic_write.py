"""Files that are either whole or not there."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_write(path: Path) -> Iterator[str]:
    """Give a path beside `path`; the file written there takes its place at the end.

    If anything fails, Ctrl-C included, the new file is removed and what stood at `path` before
    still stands there. A link stays a link: the file it leads to is replaced.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "a.txt")
    ...     with atomic_write(file) as new:
    ...         _ = Path(new).write_text("whole")
    ...     file.read_text()
    'whole'
    """
    # Not made by `tempfile`, whose files only their owner may read; and named independently of
    # `path`, whose name may be as long as names can be.
    target = Path(os.path.realpath(path))
    new = target.with_name(f".neurbs-{secrets.token_hex(8)}.tmp")
    try:
        yield str(new)
        with suppress(OSError):
            before = target.stat()
            # Whose it was it stays, where that is allowed; a change of owner may change the mode.
            with suppress(OSError, AttributeError):
                os.chown(new, before.st_uid, before.st_gid)
            # Who could read the file before can read it after, and nobody else.
            new.chmod(stat.S_IMODE(before.st_mode))
        os.replace(new, target)
    except BaseException as error:
        new.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:
            # The user knows the file by its own name.
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
