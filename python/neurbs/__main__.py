"""The command `neurbs`, and `python -m neurbs`.

Loading NumPy and Typer takes a quarter of a second; the handler of Ctrl-C is set before that.
"""

import os
import signal
import sys

_INTERRUPTED = 130
"""The exit code after Ctrl-C."""


def main() -> None:
    """Run the command line and leave Python with its exit code."""
    # Ctrl-C stays ignored if it is ignored at the start, as under `nohup`.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _leave)
    from neurbs.cli import main as run

    try:
        run()
    except SystemExit as leaving:
        if leaving.code != _INTERRUPTED:
            raise
        # After a Ctrl-C while Python compiled a string, as for dataclasses and annotations, Python
        # takes it for unhandled and would exit by the signal, not with this code.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_INTERRUPTED)


def _leave(_number: int, _frame: object) -> None:
    """Exit at once: while libraries are loaded there is nothing to clean up."""
    if "--json" in sys.argv:
        document = b'{"error": {"type": "KeyboardInterrupt", "message": "interrupted"}}\n'
        os.write(1, document)
    os.write(2, b"interrupted\n")
    os._exit(_INTERRUPTED)


if __name__ == "__main__":
    main()
