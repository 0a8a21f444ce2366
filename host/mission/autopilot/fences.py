"""Fences: zones as an autopilot gets them, with as many corners as it has room for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.track import Samples, SmoothedTrack
from pathgene.host.formats.flight_plan import Fence, FenceCircle, FencePolygon
from pathgene.host.formats.places import degrees
from pathgene.host.formats.shapes import Ring, wound
from pathgene.host.mission.autopilot.fence_outline import KeptFree, Outline
from pathgene.host.mission.autopilot.fence_room import Room
from pathgene.host.problem.footprints import Area, Footprint
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.terrain import Terrain


__all__ = ["fences", "without_holes"]

Floats = NDArray[np.float64]

# The track is compared with zones at points this far apart.
_STEP_M = 1.0
# Distances that are only reported are taken from every one of these points.
_COARSE = 20
# Share of the margin of zones that a fence may take: the circle and the rally points keep more.
_SHARE_OF_MARGIN = 0.95
# Shares of the corridor that a fence leaves free, the first if that is enough.
_SHARES_OF_CORRIDOR = (1.0, 0.75)
# A zone is beyond reach if its box is farther than this from the box of the mission, metres and
# turn radii.
_BEYOND_M, _BEYOND_TURNS = 1000.0, 8.0


@dataclass(eq=False)
class _Zone:
    """A zone on its way to a fence."""

    name: str
    footprint: Footprint
    outline: Outline | None = None

    @property
    def corners(self) -> int:
        """Corners of the polygon without holes, 0 for a circle."""
        rings = self.footprint.rings
        left = sum(map(len, rings)) if self.outline is None else self.outline.corners
        return left + 2 * max(len(rings) - 1, 0)


def fences(
    problem: Problem,
    track: SmoothedTrack,
    room: Room,
    beyond: tuple[Floats, Floats] = (np.zeros(0), np.zeros(0)),
) -> tuple[tuple[Fence, ...], tuple[str, ...]]:
    """Return the fences of a problem's zones, and sentences on the differences.

    A fence forbids the whole column for the whole flight. So a zone whose height or time limits let
    the mission pass above, below, before or after it has no fence: the autopilot would abort its
    own mission.

    Fences without room are simplified: each contains its zone, stays within the zone's margin, and
    leaves the track's corridor free, or three quarters of it. Next, holes that the mission does not
    enter are closed; last, zones beyond its reach have no fence, the farthest first. If that is not
    enough, the fences are the zones as they are.

    Parameters
    ----------
    room : Room
        The room that the autopilot has.
    beyond : (ndarray, ndarray)
        x and y of places of the mission that are not on the track.
    """
    samples = track.sample(_STEP_M)
    x, y = (np.concatenate(pair) for pair in zip((samples.x, samples.y), beyond, strict=True))
    made: list[_Zone] = []
    notes: list[str] = []
    for number, zone in enumerate(wholes(problem.zones), start=1):
        name = zone.name or f"zone {number}"
        if zone.limits.keys() - {"name"} and zone.footprint.contains(x, y).any():
            notes.append(
                f"No fence for {name}: the path crosses it above, below, before or after its "
                "limits, which a fence cannot express."
            )
        else:
            made.append(_Zone(name, zone.footprint))
    if not _fit(made, room):
        made, said = _fitted(problem, samples, made, room, beyond)
        notes += said
    fence = tuple(_fence(zone.footprint, problem.terrain) for zone in made)
    # Parts of one zone have one name.
    return fence, tuple(dict.fromkeys(notes))


def without_holes(ring: Ring, holes: tuple[Ring, ...]) -> Ring:
    """Return one ring that covers ``ring`` less its ``holes``.

    Each hole is joined to the ring by a cut of zero width, traversed in both directions, so that
    the cut covers nothing. Holes wind opposite to the ring, so that the even-odd rule and the
    winding-number rule agree.
    """
    if holes:
        ring = wound(ring, left=True)
    for hole in (wound(hole, left=False) for hole in holes):
        pairs = (
            (math.dist(corner, other), i, j)
            for i, corner in enumerate(ring)
            for j, other in enumerate(hole)
        )
        _, i, j = min(pairs)
        ring = (*ring[: i + 1], *hole[j:], *hole[: j + 1], *ring[i:])
    return ring


def _fence(footprint: Footprint, terrain: Terrain) -> Fence:
    if footprint.disc is not None:
        x_m, y_m, radius_m = footprint.disc
        ((lat, lon),) = degrees(terrain, np.array([x_m]), np.array([y_m]))
        return FenceCircle(lat, lon, radius_m)
    ring, *holes = footprint.rings
    x, y = np.array(without_holes(ring, tuple(holes))).T
    return FencePolygon(degrees(terrain, x, y))


def _fit(zones: Sequence[_Zone], room: Room) -> bool:
    circles = sum(zone.footprint.disc is not None for zone in zones)
    return room.has(sum(zone.corners for zone in zones), len(zones) - circles, circles)


def _fitted(
    problem: Problem,
    samples: Samples,
    zones: Sequence[_Zone],
    room: Room,
    beyond: tuple[Floats, Floats],
) -> tuple[list[_Zone], list[str]]:
    """Return zones with outlines that have room, and sentences about them.

    Zones that cannot have room are returned as they are.
    """
    x, y = np.append(samples.x, beyond[0]), np.append(samples.y, beyond[1])
    made, notes = list(zones), []
    if is_within := _simplify(problem, samples, made, room):
        holes = 0
    else:
        made = [_closed(zone, x, y) for zone in zones]
        holes = sum(
            len(a.footprint.rings) - len(b.footprint.rings)
            for a, b in zip(zones, made, strict=True)
        )
        is_within = bool(holes) and _simplify(problem, samples, made, room)
    far = [] if is_within else _far(problem, x, y, made)
    limits = f"room for {room.items} corners and circles (--fence-corners)"
    while not is_within and far:
        # The simplified zones show how many must go; the remaining zones are then simplified again.
        while far and not _fit(made, room):
            away_m, zone = far.pop()
            made.remove(zone)
            notes.append(
                f"No fence for {zone.name}, {away_m / 1000:.1f} km from the path: there is "
                f"{limits}."
            )
        is_within = _simplify(problem, samples, made, room)
    if not is_within:
        return list(zones), []
    corners = sum(zone.corners for zone in made)
    given = sum(_Zone(zone.name, zone.footprint).corners for zone in made)
    if corners < given or holes:
        moved_m = max(zone.outline.moved_m for zone in made if zone.outline is not None)
        closed = f" {holes} holes that the path does not enter are closed." if holes else ""
        notes.append(
            f"The fences have {corners} corners instead of {given}, because there is {limits}; "
            f"they contain the zones and reach at most {moved_m:.1f} m beyond them.{closed}"
        )
    return [
        zone if zone.outline is None else _Zone(zone.name, Area(zone.outline.rings()))
        for zone in made
    ], notes


def _simplify(problem: Problem, samples: Samples, zones: Sequence[_Zone], room: Room) -> bool:
    """Give zones outlines with fewer corners, the cheapest first; return whether they have room."""
    rules = problem.rules
    margin_m = 0.0 if rules is None else rules.zone_margin_m
    corridor_m = 0.0 if rules is None else rules.corridor_m
    track = KeptFree(samples.x, samples.y, _STEP_M)
    with_rings = [zone for zone in zones if zone.footprint.rings]
    for share in _SHARES_OF_CORRIDOR:
        outlines = []
        for zone in with_rings:
            zone.outline = Outline(
                zone.footprint.rings,
                track,
                most_m=_SHARE_OF_MARGIN * margin_m,
                free_m=share * corridor_m,
            )
            outlines.append(zone.outline)
        while outlines and not _fit(zones, room):
            cheapest = min(outlines, key=lambda outline: outline.next_m)
            if cheapest.next_m == math.inf:
                break
            cheapest.step()
        if _fit(zones, room):
            return True
    return False


def _closed(zone: _Zone, x: Floats, y: Floats) -> _Zone:
    """Return a zone without the holes in which the mission has no place."""
    if len(zone.footprint.rings) < 2:
        return zone
    outer, *holes = zone.footprint.rings
    kept = (hole for hole in holes if (Area((hole,)).distance_m(x, y) <= 0).any())
    return _Zone(zone.name, Area((outer, *kept)))


def _far(
    problem: Problem, x: Floats, y: Floats, zones: Sequence[_Zone]
) -> list[tuple[float, _Zone]]:
    """Return the zones beyond the reach of the mission with their distances, the farthest last."""
    reach_m = max(_BEYOND_M, _BEYOND_TURNS * problem.aircraft.turn_radius_m)
    found = []
    for zone in zones:
        west, south, east, north = zone.footprint.box
        east_m = max(west - x.max(), x.min() - east, 0.0)
        north_m = max(south - y.max(), y.min() - north, 0.0)
        if math.hypot(east_m, north_m) > reach_m:
            away_m = float(zone.footprint.distance_m(x[::_COARSE], y[::_COARSE]).min())
            found.append((away_m, zone))
    return sorted(found, key=lambda pair: pair[0])
