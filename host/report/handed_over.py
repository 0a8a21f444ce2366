"""Lines and places of a flight plan, in the terrain's frame, for pictures and pages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.flight_plan import WAYPOINT, Circling, FlightPlan
from pathgene.host.terrain import Terrain


__all__ = ["HandedOver", "handed_over"]

Floats = NDArray[np.float64]

# Points of an arc, and the turn below which it is a straight line.
_ARC_POINTS, _STRAIGHT_RAD = 7, 0.01


@dataclass(frozen=True)
class HandedOver:
    """A mission as an autopilot gets it; lines are (n, 3) metres.

    Parameters
    ----------
    items : ndarray
        Its waypoints.
    legs : ndarray
        The legs between the waypoints, with the arcs of turns that begin at the acceptance radii.
    way : ndarray
        From the goal to the circle at the end, or to the touch-down; to home for a return. Fewer
        than two points if the goal is the end.
    go_around : ndarray
        The climb after a missed approach, possibly empty.
    circles : tuple of Circling
        Circles to wait on, each with its clear disc.
    rally : ndarray
        Places to return to.
    """

    items: Floats
    legs: Floats
    way: Floats
    go_around: Floats
    circles: tuple[Circling, ...]
    rally: Floats


def handed_over(plan: FlightPlan, terrain: Terrain) -> HandedOver:
    """Return the lines and places of a flight plan for a terrain with a place on Earth."""
    end = plan.end
    # Changes of speed and returns have no place.
    placed = [item for item in plan.items if (item.lat, item.lon) != (0.0, 0.0)]
    items = _local([(item.lat, item.lon, item.alt_m) for item in placed], terrain)
    waypoints = [item.command == WAYPOINT for item in placed]
    radii = [item.params[1] or 0.0 for item in placed if item.command == WAYPOINT]
    way: Floats = np.empty((0, 3))
    around: Floats = np.empty((0, 3))
    circles: tuple[Circling, ...] = ()
    if end is not None:
        way, around = _points(end.way), _points(end.go_around)
        circles = tuple(each for each in (end.circle, end.go_around_circle) if each is not None)
    rally = [(lat, lon, plan.home[2] + above_m) for lat, lon, above_m in plan.rally]
    legs = _with_arcs(items[waypoints], radii)
    return HandedOver(items, legs, way, around, circles, _local(rally, terrain))


def _with_arcs(points: Floats, radii: Sequence[float]) -> Floats:
    """Return legs whose corners are arcs that begin at these distances, or at half of a leg."""
    if len(points) < 3:
        return points
    line = [points[:1]]
    corners = zip(points, points[1:], points[2:], radii[1:], strict=False)
    for before, corner, after, radius_m in corners:
        into, away = corner - before, after - corner
        lengths = np.hypot(*into[:2]), np.hypot(*away[:2])
        reach_m = min(radius_m, *(0.5 * length for length in lengths))
        if reach_m <= 0:
            line.append(corner[None])
            continue
        into, away = into / lengths[0], away / lengths[1]
        turn = math.atan2(into[0] * away[1] - into[1] * away[0], into[:2] @ away[:2])
        share = np.linspace(0.0, 1.0, _ARC_POINTS)
        first, last = corner - reach_m * into, corner + reach_m * away
        arc = first + share[:, None] * (last - first)
        if abs(turn) > _STRAIGHT_RAD:
            # Negative to the right.
            side = reach_m / math.tan(0.5 * turn)
            ahead, aside = side * np.sin(share * turn), side * (1 - np.cos(share * turn))
            arc[:, 0] = first[0] + ahead * into[0] - aside * into[1]
            arc[:, 1] = first[1] + ahead * into[1] + aside * into[0]
        line.append(arc)
    return np.concatenate([*line, points[-1:]])


def _points(points: tuple[tuple[float, float, float], ...]) -> Floats:
    return np.array(points, dtype=np.float64).reshape(-1, 3)


def _local(places: list[tuple[float, float, float]], terrain: Terrain) -> Floats:
    """Return (n, 3) metres of latitudes, longitudes and altitudes."""
    if not places:
        return np.empty((0, 3))
    lat, lon, z = np.array(places).T
    x, y = terrain.to_local(lat, lon)
    return np.stack((x, y, z), axis=1)
