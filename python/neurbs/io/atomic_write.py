"""Atomic writing: a file is complete or does not exist."""

from __future__ import annotations

import os
import re
import secrets
import socket
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def atomic_write(path: Path) -> Iterator[str]:
    """Yield a temporary path in the same folder; its file replaces `path` at the end.

    After an error or Ctrl-C the temporary file is removed and `path` is unchanged. If `path` is a
    link, its target is replaced. The temporary files that killed processes of this host have left
    in the folder are removed.

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
    _remove_abandoned(target.parent)
    new = target.with_name(f".neurbs-{_host()}-{os.getpid()}-{secrets.token_hex(8)}.tmp")
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


def _host() -> str:
    """Return a name of the host, and of the space of its process ids where containers have one."""
    with suppress(OSError, AttributeError):
        space = Path("/proc/self/ns/pid").readlink().name
        return re.sub("[^A-Za-z0-9]+", "_", f"{socket.gethostname()[:60]}_{space}").strip("_")
    return re.sub("[^A-Za-z0-9]+", "_", socket.gethostname()[:60]).strip("_")


def _remove_abandoned(folder: Path) -> None:
    """Remove the temporary files of processes of this host that have ended."""
    if os.name == "nt":
        return  # There, a signal to ask for a process would end it.
    name = re.compile(rf"\.neurbs-{_host()}-(\d+)-[0-9a-f]{{16}}\.tmp")
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            match = name.fullmatch(entry.name)
            if match and not _is_running(int(match[1])):
                with suppress(OSError):
                    os.unlink(entry.path)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        pass  # It belongs to another user, or its number is none.
    return True
