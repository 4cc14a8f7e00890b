"""Make ``jacksboro.xyz``: scattered samples of real terrain, in meters.

The terrain is the SRTM raster around the Jacksboro fault, Tennessee (public domain), that comes
with matplotlib's sample data. The samples are chosen at random, without order.

    python examples/make_jacksboro.py [OUT]
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import cbook

POINTS = 4000
SEED = 1998

# Of latitude; a degree of longitude is shorter by the cosine of the latitude.
METERS_PER_DEGREE = 111_200.0


def main() -> None:
    """Write the samples to the file named on the command line, or beside this script."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("jacksboro.xyz")
    with np.load(cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)) as dem:
        heights = dem["elevation"]
        dx = METERS_PER_DEGREE * float(dem["dx"]) * np.cos(np.radians(float(dem["ymin"])))
        dy = METERS_PER_DEGREE * float(dem["dy"])
    chosen = np.random.default_rng(SEED).choice(heights.size, POINTS, replace=False)
    row, col = np.unravel_index(chosen, heights.shape)
    points = np.column_stack([col * dx, (len(heights) - 1 - row) * dy, heights[row, col]])
    header = "Jacksboro fault, SRTM (public domain): x east, y north, z up\nx[m] y[m] z[m]"
    np.savetxt(out, points, fmt=("%.1f", "%.1f", "%d"), header=header)


if __name__ == "__main__":
    main()
