"""The command line: `neurbs reconstruct POINTS -o OUT` and its fellows.

Exit codes: 0 done; 1 the job failed; 2 the command line is wrong; 3 too many points lie outside the
tolerance (compare); 4 the tolerance is missed or the surface is not valid (reconstruct --strict);
130 interrupted. A failure is one message on stderr, never a traceback.
"""

from neurbs.cli.command import app, main
from neurbs.cli.compare import compare
from neurbs.cli.inspection import info, view
from neurbs.cli.reconstruct import reconstruct, reconstruct_paper
from neurbs.cli.surfaces import convert, tessellate
from neurbs.cli.train import train

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
