"""The testing trajectory of *allaire two-tier* (section 4) on a synthetic canyon.

The paper does not publish its map and waypoints. This trajectory has the properties that the paper
states: segments of 55 and 100 cells, which span the first 2,500 m of the map, then a segment past a
mountain. Every cell of the trajectory is clear in the detailed map; the sixth cell on the coarse
map is not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.terrain.synthetic import large_canyon


__all__ = ["CANYON_SEED", "TESTING_TRAJECTORY", "canyon_map"]

#: Seed of :func:`pathgene.host.terrain.synthetic.large_canyon`.
CANYON_SEED = 0

#: Aircraft, two waypoints and goal in cells and altitude steps. A random search found this path
#: with the paper's cell counts; every verdict has a margin of at least 20 steps.
TESTING_TRAJECTORY = ((390, 328, 115), (336, 297, 158), (237, 254, 172), (167, 161, 343))


def canyon_map() -> NDArray[np.uint16]:
    """Return the canyon's (500, 500) uint16 altitudes [y, x] in metres, one cell per node.

    Altitudes are rounded up. The paper scales its canyon from 80 km to 8 km, with cells of 16 m,
    and keeps its height of 3,500 m.
    """
    return np.ceil(large_canyon(CANYON_SEED).elevation).astype(np.uint16)
