"""The testing trajectory of *allaire two-tier* (section 4), on a canyon of our own.

The paper's map and waypoints are not published, but what it says of them holds here: segments of 55
and 100 cells, the map's first 2,500 m, then one that leads by a mountain. It is free in every cell
of the detailed map, and not in the sixth cell of the coarse one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from host.terrain.synthetic import large_canyon


__all__ = ["CANYON_SEED", "TESTING_TRAJECTORY", "canyon_map"]

#: Of :func:`host.terrain.synthetic.large_canyon`.
CANYON_SEED = 0

#: Aircraft, two waypoints and goal: cells and altitude steps. Found by a random search for paths
#: with the paper's cells, at least 20 steps from where any verdict would change.
TESTING_TRAJECTORY = ((390, 328, 115), (336, 297, 158), (237, 254, 172), (167, 161, 343))


def canyon_map() -> NDArray[np.uint16]:
    """Return the canyon's (500, 500) altitudes [y, x]: a cell a node, a step a metre, rounded up.

    The paper scales its canyon of 80 km to 8 km, cells of 16 m, and keeps its 3,500 m of height.
    """
    return np.ceil(large_canyon(CANYON_SEED).elevation).astype(np.uint16)
