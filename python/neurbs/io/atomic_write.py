"""Atomic writing: a file is complete or does not exist."""

from __future__ import annotations

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_write(path: Path) -> Iterator[str]:
    """Yield a temporary path in the same folder; its file replaces `path` at the end.

    After an error or Ctrl-C the temporary file is removed and `path` is unchanged. If `path` is a
    link, its target is replaced.

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
    # Not by `tempfile`, whose files only their owner may read. The name does not contain that of
    # `path`, which may have the greatest possible length.
    target = Path(os.path.realpath(path))
    new = target.with_name(f".neurbs-{secrets.token_hex(8)}.tmp")
    try:
        yield str(new)
        with suppress(OSError):
            before = target.stat()
            # Keep the owner where that is allowed. This may change the mode, which is set below.
            with suppress(OSError, AttributeError):
                os.chown(new, before.st_uid, before.st_gid)
            # Keep the permissions.
            new.chmod(stat.S_IMODE(before.st_mode))
        os.replace(new, target)
    except BaseException as error:
        new.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:
            # The error names the file of the user, not the temporary one.
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
