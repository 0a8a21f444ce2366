"""Circuits at the start: turns flown to gain height before a climb that is too steep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.problem import Problem


__all__ = ["Circuit", "circuits"]

Floats = NDArray[np.float64]

# Corners of a circuit, and its radii in turn radii: two turns of 60 degrees fit on each side.
_CORNERS = 6
_RADII = (1.3, 1.8, 2.5)
_DIRECTIONS = 16
_COUNTS = (1, 2, 3, 5, 8)
# Share of the climb limit that a circuit gains.
_SHARE = 0.9
# Distance between places whose ground is compared with the altitude of the start, in turn radii.
_SAMPLES = 48


@dataclass(frozen=True)
class Circuit:
    """Waypoints of some circuits after the start.

    Parameters
    ----------
    places : (k, 2) float64, metres
        Waypoints, the start not included.
    gain_m : float
        Altitude gained at the last one.
    """

    places: Floats
    gain_m: float


def circuits(problem: Problem) -> Iterator[Circuit]:
    """Yield circuits from one to eight turns over the lowest ground around the start.

    There are none with ``as_paper``, from a start with a heading, or where no circle has room.
    """
    if problem.rules is None or problem.headings[0] is not None:
        return
    radius_m = problem.limits.turn_radius_m
    start = np.array(problem.start[:2])
    found: list[tuple[float, float, Floats]] = []
    for radii in _RADII:
        for number in range(_DIRECTIONS):
            angle = 2 * math.pi * number / _DIRECTIONS
            outwards = np.array((math.cos(angle), math.sin(angle)))
            middle = start - radii * radius_m * outwards
            turns = angle + np.arange(_SAMPLES + 1) * 2 * math.pi / _SAMPLES
            circle = middle + radii * radius_m * np.column_stack((np.cos(turns), np.sin(turns)))
            highest = _highest(problem, circle)
            if highest is not None:
                found.append((highest, radii, middle))
    if not found:
        return
    _, radii, middle = min(found, key=lambda each: each[:2])
    away = start - middle
    first = math.atan2(away[1], away[0])
    side_m = float(np.hypot(*away))
    climb = math.tan(problem.limits.climb_rad)
    for count in _COUNTS:
        for corners in (0, 2, 4):
            numbers = np.arange(1, count * _CORNERS + corners + 1)
            angles = first + numbers * 2 * math.pi / _CORNERS
            places = middle + side_m * np.column_stack((np.cos(angles), np.sin(angles)))
            yield Circuit(places, _SHARE * climb * side_m * len(numbers))


def _highest(problem: Problem, places: Floats) -> float | None:
    """Return the highest ground at places, metres; None if one is blocked or off the map."""
    terrain = problem.terrain
    if (places < 0).any() or (places > (terrain.width_m, terrain.height_m)).any():
        return None
    rows, columns = terrain.nearest_nodes(*places.T)
    if problem.blocked_raster[rows, columns].any():
        return None
    return float(problem.surface.elevation[rows, columns].max())
