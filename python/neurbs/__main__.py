"""The command `neurbs`, and `python -m neurbs`.

Ctrl-C is answered before NumPy and Typer are loaded, which takes a quarter of a second.
"""

import os
import signal
import sys


def main() -> None:
    """Run the command line and leave Python with its exit code."""
    # Who starts a program with Ctrl-C ignored, as `nohup` does, means it.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, _leave)
    from neurbs.cli import main as run

    run()


def _leave(_number: int, _frame: object) -> None:
    """Leave at once: while libraries are loaded, nothing is begun that would have to be undone."""
    if "--json" in sys.argv:
        document = b'{"error": {"type": "KeyboardInterrupt", "message": "interrupted"}}\n'
        os.write(1, document)
    os.write(2, b"interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()
