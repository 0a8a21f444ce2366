"""The two seabed landscapes of *cheng*, section II.A, equations (1) and (2)."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError


__all__ = ["HALF_SIDE", "LANDSCAPES", "height", "raw_height", "scale"]

#: The base is a square of side 1 around the origin.
HALF_SIDE = 0.5
#: Table I: a, b, c, d and e of each landscape.
LANDSCAPES = {
    1: (0.5, 1.3, -0.3, 3.0, -2.0),
    2: (1.2, 0.8, -1.7, 1.0, -1.0),
}
_GRID = 2001  # Nodes per side of the grid whose maximum becomes 1.

Floats = NDArray[np.float64]


def raw_height(landscape: int, x: Floats, y: Floats) -> Floats:
    """Equation (1) or (2) without its factor sigma; ``x`` and ``y`` broadcast."""
    a, b, c, d, e = LANDSCAPES[landscape]
    u, v = 4 * np.pi * x, 4 * np.pi * y
    ripples = c * np.sin(d * np.sqrt(v * v + u * u))
    if landscape == 1:
        waves = np.sin(v + a) + b * np.cos(u) + e * np.sin(v)
    else:
        waves = np.cos(v + a) + b * np.sin(u) + e * np.cos(v)
    squared: Floats = (waves + ripples) ** 2
    return squared


@cache
def scale(landscape: int) -> float:
    """The factor sigma, which scales the maximum height on a grid of 2001 x 2001 nodes to 1.

    Raises
    ------
    InputError
        If there is no such landscape.
    """
    if landscape not in LANDSCAPES:
        raise InputError(
            f"The landscape must be one of {', '.join(map(str, LANDSCAPES))}, not {landscape}."
        )
    side = np.linspace(-HALF_SIDE, HALF_SIDE, _GRID)
    return 1.0 / float(raw_height(landscape, side[None, :], side[:, None]).max())


def height(landscape: int, x: Floats, y: Floats) -> Floats:
    """Height of the seabed, 0 to 1; ``x`` and ``y`` broadcast."""
    return scale(landscape) * raw_height(landscape, x, y)
