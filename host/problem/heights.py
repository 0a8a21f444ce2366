"""Limits of height as files state them, in metres of the terrain's datum, on the safe side."""

from __future__ import annotations

import math

import numpy as np

from pathgene.host.formats.features import Limit, Reference
from pathgene.host.problem.placing import Placed
from pathgene.host.terrain import Terrain


__all__ = ["metres"]


def metres(
    lower: Limit | None, upper: Limit | None, part: Placed, terrain: Terrain
) -> tuple[float | None, float | None]:
    """Return the lower and the upper limit of a zone in metres of the terrain's datum.

    A limit above the ground counts above the lowest ground under the zone if it is the lower one,
    above the highest if it is the upper one.
    """
    if not any(each and each.reference is Reference.AGL for each in (lower, upper)):
        return _plain(lower), _plain(upper)
    lowest, highest = _ground(part, terrain)
    return _plain(lower, lowest), _plain(upper, highest)


def _plain(limit: Limit | None, ground_m: float = 0.0) -> float | None:
    if limit is None:
        return None
    return limit.height_m + (ground_m if limit.reference is Reference.AGL else 0.0)


def _ground(part: Placed, terrain: Terrain) -> tuple[float, float]:
    """Return the lowest and the highest ground under the box of a zone; voids may be anything."""
    x, y = np.array(part.rings[0]).T
    reach = part.radius_m or 0.0
    rows, columns = (
        slice(
            min(max(math.floor((low - reach) / side), 0), count - 1),
            min(max(math.ceil((high + reach) / side), 0), count - 1) + 1,
        )
        for low, high, side, count in (
            (y.min(), y.max(), terrain.dy_m, terrain.shape[0]),
            (x.min(), x.max(), terrain.dx_m, terrain.shape[1]),
        )
    )
    ground = terrain.elevation[rows, columns]
    if np.isnan(ground).any():
        return terrain.lowest, terrain.highest
    return float(ground.min()), float(ground.max())
