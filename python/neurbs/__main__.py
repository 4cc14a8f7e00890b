"""The command `neurbs`, and `python -m neurbs`.

Ctrl-C is answered before NumPy and Typer are loaded, which takes a quarter of a second.
"""

import os
import signal
import sys

_INTERRUPTED = 130
"""The exit code after Ctrl-C."""


def main() -> None:
    """Run the command line and leave Python with its exit code."""
    # Who starts a program with Ctrl-C ignored, as `nohup` does, means it.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _leave)
    from neurbs.cli import main as run

    try:
        run()
    except SystemExit as leaving:
        if leaving.code != _INTERRUPTED:
            raise
        # Python takes a Ctrl-C that came while it evaluated a text, as dataclasses and annotations
        # are, for one that nobody has handled, and would end by the signal instead of the code.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_INTERRUPTED)


def _leave(_number: int, _frame: object) -> None:
    """Leave at once: while libraries are loaded, nothing is begun that would have to be undone."""
    if "--json" in sys.argv:
        document = b'{"error": {"type": "KeyboardInterrupt", "message": "interrupted"}}\n'
        os.write(1, document)
    os.write(2, b"interrupted\n")
    os._exit(_INTERRUPTED)


if __name__ == "__main__":
    main()
