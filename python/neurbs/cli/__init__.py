"""The command line: `neurbs reconstruct POINTS -o OUT` and the other commands.

Exit codes: 0 done; 1 the job failed; 2 the command line is wrong; 3 too many points lie outside the
tolerance (compare); 4 the tolerance is missed or the surface is not valid (reconstruct --strict);
130 interrupted; 143 terminated. A failure prints one message on stderr and no traceback.
"""

from neurbs.cli.command import app, main
from neurbs.cli.compare import compare
from neurbs.cli.convert import convert
from neurbs.cli.info import info
from neurbs.cli.reconstruct import reconstruct, reconstruct_paper
from neurbs.cli.tessellate import tessellate
from neurbs.cli.train import train
from neurbs.cli.view import view

__all__ = [
    "app",
    "compare",
    "convert",
    "info",
    "main",
    "reconstruct",
    "reconstruct_paper",
    "tessellate",
    "train",
    "view",
]
