"""Zones with limits above the ground, divided into tiles with limits above the datum.

Search and judgement know only altitudes, so they have the tiles. Reports, pictures and files show
the zones as a user gave them: :func:`wholes`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from pathgene.host.formats.features import Feature, Limit, Reference
from pathgene.host.problem.heights import Heights, tiles, tiles_each
from pathgene.host.problem.placing import Placed
from pathgene.host.problem.zone_report import Record, powerless
from pathgene.host.problem.zones import Polygon, Zone, ZoneOptions
from pathgene.host.remarks import Remark
from pathgene.host.terrain import Terrain


__all__ = ["numbers_of", "outermost", "over_ground", "remarks_on", "tiles_of", "wholes"]


def over_ground(zones: Sequence[Zone], terrain: Terrain, sharing: int = 0) -> tuple[Zone, ...]:
    """Return zones with limits above the datum: those that follow the ground as tiles.

    The upper limit of a tile counts over the highest ground below it, the lower over the lowest.

    Parameters
    ----------
    sharing : int
        Number of zones that share the tiles, if there are more than these.
    """
    following = sum(zone.follows_ground for zone in zones)
    if not following:
        return tuple(zones)
    most = tiles_each(max(following, sharing))
    return tuple(
        tile
        for zone in zones
        for tile in (_divided(zone, terrain, most) if zone.follows_ground else (zone,))
    )


def _divided(zone: Zone, terrain: Terrain, most: int) -> Iterator[Zone]:
    """Yield the tiles of a zone; a tile with nothing between its limits is left out."""
    part = _part(zone)
    for tile, lowest_m, highest_m in tiles(part, terrain, most):
        lower_m = zone.lower_m if zone.lower_agl_m is None else lowest_m + zone.lower_agl_m
        upper_m = zone.upper_m if zone.upper_agl_m is None else highest_m + zone.upper_agl_m
        if lower_m is not None and upper_m is not None and lower_m >= upper_m:
            continue
        shape = zone
        if tile is not part:
            ring, *holes = tile.rings
            shape = Polygon(ring, tuple(holes), name=zone.name, t0_s=zone.t0_s, t1_s=zone.t1_s)
        yield replace(
            shape,
            lower_m=lower_m,
            upper_m=upper_m,
            lower_agl_m=None,
            upper_agl_m=None,
            part_of=zone,
        )


def remarks_on(
    zones: Sequence[tuple[int, Zone]], terrain: Terrain, options: ZoneOptions
) -> tuple[Remark, ...]:
    """Return warnings about zones, each with its number, that forbid nothing.

    These are zones that were not read from a file, whose report has such warnings.
    """
    heights = Heights(terrain, zones=sum(zone.follows_ground for _, zone in zones))
    records = []
    for number, zone in zones:
        part, feature = _part(zone), _feature(number, zone)
        bands = heights.bands(feature, part)
        is_active = (zone.t0_s or 0.0) <= options.longest_s
        records.append(Record(feature, (part,), tuple(bands), is_active))
    return tuple(powerless(records, terrain, options.ceiling_m))


def _part(zone: Zone) -> Placed:
    """Return the shape of a zone."""
    x, y, radius_m = zone.footprint.disc or (0.0, 0.0, None)
    return Placed(zone.footprint.rings or (((x, y),),), radius_m)


def _feature(number: int, zone: Zone) -> Feature:
    """Return a zone as if it had been read from a file."""
    lower, upper = (
        Limit(metres, Reference.AMSL)
        if metres is not None
        else Limit(above_m, Reference.AGL)
        if above_m is not None
        else None
        for metres, above_m in (
            (zone.lower_m, zone.lower_agl_m),
            (zone.upper_m, zone.upper_agl_m),
        )
    )
    rings = _part(zone).rings
    return Feature(number, zone.name, rings, lower=lower, upper=upper, kind="zone", is_local=True)


def wholes(zones: Iterable[Zone]) -> tuple[Zone, ...]:
    """Return zones as a user gave them: the tiles of a zone are one."""
    return tuple(next(tiles).whole for _, tiles in groupby(zones, key=_group))


def tiles_of(zones: Iterable[Zone]) -> tuple[tuple[Zone, ...], ...]:
    """Return for each of the :func:`wholes` of some zones its tiles, or the zone itself."""
    return tuple(tuple(tiles) for _, tiles in groupby(zones, key=_group))


def numbers_of(zones: Iterable[Zone]) -> tuple[int, ...]:
    """Return for each of some zones its number, from 1, among their :func:`wholes`."""
    groups = enumerate(tiles_of(zones), start=1)
    return tuple(number for number, tiles in groups for _ in tiles)


def outermost(tiles: Sequence[Zone]) -> tuple[float | None, float | None]:
    """Return the lowest and the highest altitude of tiles; None where one has no limit."""
    lows = [tile.lower_m for tile in tiles]
    highs = [tile.upper_m for tile in tiles]
    return (
        None if None in lows else min(low for low in lows if low is not None),
        None if None in highs else max(high for high in highs if high is not None),
    )


def _group(zone: Zone) -> object:
    """Return a key that the tiles of a zone share, and no other zone."""
    return object() if zone.part_of is None else id(zone.part_of)
