"""Room for circles and ways of an autopilot: clearance over the surface, and no zone."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.atmosphere import SEA_LEVEL_DENSITY_KG_M3, air_density
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.terrain.surface import is_beyond, surface_below


__all__ = [
    "CORNER_M",
    "circle_radius_m",
    "climb_slope",
    "disc_height_m",
    "disc_places",
    "disc_radius_m",
    "drift_of",
    "height_over",
    "is_clear",
    "is_under_ceiling",
    "keeps_clearance",
    "required_m",
]

Floats = NDArray[np.float64]

#: Distance beside a way, beyond the corridor, that is kept clear for the corners of its turns.
CORNER_M = 6.0
# Radius of the disc that is kept clear, in exported radii; ArduPlane flies the radius times the
# squared ratio of true and equivalent airspeed, and 1.35 times that at the entry.
_DISC, _ENTRY = 2.0, 1.35
# Share of the aircraft's steepest climb that the way to a circle uses.
_SHARE_OF_CLIMB = 0.7
# Maximum number of points across a disc that are compared with the surface.
_MOST_POINTS = 161
# Attempts at the altitude of a disc, which is larger in thinner air.
_GROWTHS = 4
# No circle lies higher.
_HIGHEST_M = 20_000.0


def drift_of(problem: Problem) -> float:
    """Return the ratio of ground speed and airspeed in a tail wind."""
    return 1 + math.hypot(*problem.wind) / problem.aircraft.cruise_speed_m_s


def climb_slope(problem: Problem) -> float:
    """Return the tangent of the slope that an aircraft climbs with a reserve, over the ground."""
    climb = max(problem.limits.climb_rad, 0.0)
    return _SHARE_OF_CLIMB * math.tan(climb) / drift_of(problem)


def circle_radius_m(problem: Problem) -> int:
    """Return the radius that the aircraft can fly in a tail wind, in whole metres."""
    return math.ceil(problem.aircraft.turn_radius_m * drift_of(problem) ** 2)


def disc_radius_m(radius_m: float, altitude_m: float) -> float:
    """Return the radius of the disc that a circle needs at an altitude."""
    widened = SEA_LEVEL_DENSITY_KG_M3 / air_density(altitude_m)
    return radius_m * max(_DISC, _ENTRY * widened)


def disc_places(problem: Problem, x: float, y: float, radius_m: float) -> tuple[Floats, Floats]:
    """Return points of a disc, at most a cell apart where that is not too many.

    An odd number of rows has the outermost points, which are the first off the map.
    """
    cell_m = min(problem.terrain.dx_m, problem.terrain.dy_m)
    count = min(2 * math.ceil(radius_m / cell_m) + 1, _MOST_POINTS)
    steps = np.linspace(-radius_m, radius_m, max(count, 9))
    dx, dy = np.meshgrid(steps, steps)
    inside = np.hypot(dx, dy) <= radius_m
    return x + dx[inside], y + dy[inside]


def required_m(problem: Problem, places: tuple[Floats, Floats]) -> Floats:
    """Return the clearance that the rules require at places, 0 or more."""
    if problem.rules is None:
        return np.zeros(len(places[0]))
    required: Floats = np.maximum(problem.demand.required_m(*places), 0.0)
    return required


def height_over(problem: Problem, places: tuple[Floats, Floats]) -> float:
    """Return the altitude that keeps the clearance over places, infinite off the map."""
    if is_beyond(problem.terrain, *places).any():
        return math.inf
    return float(np.max(surface_below(problem.terrain, *places) + required_m(problem, places)))


def disc_height_m(problem: Problem, x: float, y: float, lowest_m: float) -> float:
    """Return the altitude from ``lowest_m`` up at which a circle around a place has room.

    It is infinite if the circle has room at none.
    """
    radius_m = circle_radius_m(problem)
    height_m = lowest_m
    for _ in range(_GROWTHS):
        around = disc_places(problem, x, y, disc_radius_m(radius_m, height_m))
        needed_m = height_over(problem, around)
        if needed_m <= height_m:
            has_room = height_m <= problem.limits.ceiling_m and is_clear(problem, around, height_m)
            return height_m if has_room else math.inf
        if not needed_m <= min(problem.limits.ceiling_m, _HIGHEST_M):
            break
        height_m = needed_m
    return math.inf


def keeps_clearance(
    problem: Problem,
    places: tuple[Floats, Floats],
    altitude_m: Floats | float,
    clearance_m: Floats | None = None,
) -> bool:
    """Return whether places are on the map and keep a clearance at altitudes.

    Parameters
    ----------
    clearance_m : ndarray, optional
        The clearance to keep; by default the one that the rules require.
    """
    if is_beyond(problem.terrain, *places).any():
        return False
    clearance = required_m(problem, places) if clearance_m is None else clearance_m
    return bool(np.all(surface_below(problem.terrain, *places) + clearance <= altitude_m))


def is_clear(
    problem: Problem,
    places: tuple[Floats, Floats],
    altitude_m: Floats | float,
    clearance_m: Floats | None = None,
    *,
    up_to_m: float = -math.inf,
) -> bool:
    """Return whether places keep a clearance at altitudes, and no zone is at them.

    Parameters
    ----------
    clearance_m : ndarray, optional
        The clearance to keep; by default the one that the rules require.
    up_to_m : float
        Highest altitude that is flown there, for zones.
    """
    if not keeps_clearance(problem, places, altitude_m, clearance_m):
        return False
    x, y = places
    margin_m = 0.0 if problem.rules is None else problem.rules.zone_margin_m
    altitudes = np.broadcast_to(altitude_m, x.shape)
    for zone in wholes(problem.zones):
        near = altitudes[zone.footprint.distance_m(x, y) <= margin_m]
        if not near.size:
            continue
        highest = max(float(near.max()), up_to_m)
        is_over = zone.upper_m is not None and zone.upper_m < float(near.min()) - margin_m
        is_under = zone.lower_m is not None and zone.lower_m > highest + margin_m
        if not (is_over or is_under):
            return False
    return True


def is_under_ceiling(
    problem: Problem, places: tuple[Floats, Floats], altitude_m: Floats | float
) -> bool:
    """Return whether altitudes are below the ceilings of the rules."""
    if np.any(altitude_m > problem.limits.ceiling_m):
        return False
    if problem.rules is None or problem.rules.ceiling_agl_m is None:
        return True
    above = altitude_m - surface_below(problem.terrain, *places)
    return bool((above <= problem.rules.ceiling_agl_m).all())
