"""Clouds beyond one process: reconstruction and training on the workers of Dask.

Points are arrays of Dask, files, or chunks from an iterator. Workers sum what a surface or a map
needs; sums are small and merge, and points are never gathered. It needs
``pip install 'neurbs[dask]'``.
"""

from neurbs.distributed.engine import Progress
from neurbs.distributed.map_training import fit_map
from neurbs.distributed.reconstruction import reconstruct
from neurbs.distributed.refinement import RoundReport
from neurbs.distributed.report import DistributedReport
from neurbs.distributed.result import DistributedReconstruction

__all__ = [
    "DistributedReconstruction",
    "DistributedReport",
    "Progress",
    "RoundReport",
    "fit_map",
    "reconstruct",
]
