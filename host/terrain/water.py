"""The water over a terrain: heights below its level are the bottom of the sea."""

from __future__ import annotations

import numpy as np

from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.stated import NO_WATER


__all__ = ["under_water"]

#: Level of the sea above the datum, metres.
_SEA_M = 0.0
# Share of a map under water above which a plan should be examined.
_LARGE_SHARE = 0.05


def under_water(terrain: Terrain, level: float | str | None) -> Terrain:
    """Return the terrain with all heights at or above the level of the water.

    Parameters
    ----------
    terrain : Terrain
        The land and the sea floor.
    level : float or str or None
        Height of the water above the datum, metres; ``none`` for land below the sea. None is 0 m on
        Earth, and no water elsewhere.
    """
    if level is None:
        level = NO_WATER if terrain.crs is None else _SEA_M
    if isinstance(level, str):
        return _without_water(terrain)
    level_m = float(level)
    facts = {**terrain.reading.facts, "water_level_m": level_m}
    if not terrain.lowest < level_m:
        return terrain.having(reading=Reading(facts, terrain.reading.remarks))
    below, land = terrain.elevation < level_m, np.count_nonzero(~terrain.voids)
    share, count = np.count_nonzero(below) / land, np.count_nonzero(below)
    facts["share_below_0"] = np.count_nonzero(terrain.elevation < 0) / land
    facts["lowest_in_file_m"] = terrain.lowest
    heights = np.where(below, level_m, terrain.elevation)
    heights.setflags(write=False)
    heights_lie, are = ("heights lie", "are") if count != 1 else ("height lies", "is")
    remark = Remark(
        Grade.WARNING if share >= _LARGE_SHARE else Grade.NOTE,
        f"{count:,} {heights_lie} below {level_m:g} m, down to {terrain.lowest:g} m, on "
        f"{share:.2%} of the map, and {are} taken for water of that level; give --water-level none "
        "for land.",
    )
    reading = Reading(facts, terrain.reading.remarks).adding([remark])
    return terrain.having(elevation=heights, reading=reading, paper=terrain.paper or terrain)


def _without_water(terrain: Terrain) -> Terrain:
    facts = {**terrain.reading.facts, "water_level_m": None}
    return terrain.having(reading=Reading(facts, terrain.reading.remarks))
