"""The evaluation of a path in plain Python: slow, readable, and the model of the kernels.

Source: Roberge and Tarbouchi, sections 3.1 and 3.2, equations (1) to (3).
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation.constants import SLOPE_TOLERANCE_RAD
from pathgene.host.evaluation.fuel import air_distance, fuel_burned, thrust_needed
from pathgene.host.evaluation.geometry import Piece, Straight, smooth
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem


__all__ = [
    "Terms",
    "Utopia",
    "evaluate",
    "line_utopia",
    "problem_utopia",
    "too_steep",
    "utopia",
]

Direction = tuple[float, float, float]

_FUEL_WEIGHT = _ALTITUDE_WEIGHT = 0.5
# A line is a glide if it needs less than this share of the thrust of level flight.
_GLIDE = 0.25


@dataclass(frozen=True)
class Terms:
    """Every term of one path; names, units and meanings of ``Evaluation``."""

    fitness: float
    penalty: float
    cost: float
    length_m: float
    mean_altitude_m: float
    fuel_N: float
    distance_under_terrain_m: float
    distance_in_nofly_m: float
    distance_too_steep_m: float
    impossible_arcs: int
    void_crossed_m: float


@dataclass(frozen=True)
class Utopia:
    """Altitude over the base, length and fuel of the line from start to goal.

    Costs are relative to these values.
    """

    altitude_m: float
    length_m: float
    fuel_N: float


def evaluate(problem: Problem, path: NDArray[np.float64], *, ds_m: float | None = None) -> Terms:
    """Evaluate ``path``, (n, 3) float64 metres with start and goal, by the definition."""
    aircraft, wind = problem.aircraft, problem.frame_wind
    ds_m = problem.ds_m if ds_m is None else ds_m
    smoothed = smooth(path, problem.limits.turn_radius_m, problem.headings)
    track = SmoothedTrack(smoothed.pieces, problem.surface)

    length = sum(piece.length_m for piece in smoothed.pieces)
    altitude = sum(_mean_altitude(piece) * piece.length_m for piece in smoothed.pieces) / length
    steep = sum(
        piece.length_m
        for piece in smoothed.pieces
        if _is_too_steep(piece, problem) or _air_distance(piece, aircraft, wind) is None
    )
    fuel = _fuel(smoothed.pieces, aircraft, wind)
    beyond = _beyond_limits(smoothed.pieces, problem)

    at, part = track.midpoints(ds_m)
    rows, columns = problem.terrain.elevation.shape
    outside = ~(
        (at.x >= 0)
        & (at.x <= (columns - 1) * problem.terrain.dx_m)
        & (at.y >= 0)
        & (at.y <= (rows - 1) * problem.terrain.dy_m)
    )
    void = np.isnan(at.ground)
    high = np.zeros_like(outside)
    if problem.roof is not None:
        high = at.z > problem.roof[problem.terrain.nearest_nodes(at.x, at.y)]
    under = float(part[outside | void | (at.z < at.ground)].sum() + part[high].sum())
    in_zone = problem.nofly_raster[problem.terrain.nearest_nodes(at.x, at.y)]
    nofly = float(part[in_zone].sum())

    penalty = under + nofly + steep + beyond
    if smoothed.arcs:
        penalty += smoothed.impossible_arcs / smoothed.arcs * length
    best = problem_utopia(problem)
    cost = (
        _ALTITUDE_WEIGHT
        * ((altitude - problem.cost_base_m) * length)
        / (best.altitude_m * best.length_m)
        + _FUEL_WEIGHT * fuel / best.fuel_N
    )
    fitness = 1 / (1 + penalty) if penalty > 0 else 1 + 1 / (1 + cost)
    return Terms(
        fitness,
        penalty,
        cost,
        length,
        altitude,
        fuel,
        under,
        nofly,
        steep,
        smoothed.impossible_arcs,
        float(part[void].sum()),
    )


def _is_too_steep(piece: Piece, problem: Problem) -> bool:
    """Return whether a piece is too steep; in wind under the rules, by its vertical speed."""
    aircraft = problem.aircraft
    if problem.rules is None or problem.frame_wind == (0.0, 0.0) or piece.run_m == 0:
        return too_steep(piece, aircraft)
    speed = aircraft.cruise_speed_m_s
    fastest = 0.0
    for direction in (*piece.directions(), *_fastest_directions(piece, problem.frame_wind)):
        distance = air_distance(
            piece.length_m, piece.run_m, [direction], problem.frame_wind, aircraft.cruise_speed_m_s
        )
        if distance is None:
            continue
        fastest = max(fastest, direction[2] / (distance / speed))
    vertical = fastest * piece.rise_m / piece.run_m
    climb, descent = (
        speed * math.sin(math.radians(degrees) + SLOPE_TOLERANCE_RAD)
        for degrees in (aircraft.max_climb_deg, aircraft.max_descent_deg)
    )
    return not -descent <= vertical <= climb


def _fastest_directions(piece: Piece, wind: tuple[float, float]) -> Iterator[Direction]:
    """Yield the directions of an arc in which the wind may help most: its ends, and the wind's."""
    if isinstance(piece, Straight):
        return
    east, north = piece.heading
    downwind = math.atan2(wind[1], wind[0]) - math.atan2(north, east)
    side = math.copysign(1.0, piece.turn_rad)
    downwind = side * ((side * downwind) % (2 * math.pi))
    for turned in (0.0, piece.turn_rad, downwind):
        if abs(turned) <= abs(piece.turn_rad):
            cos, sin = math.cos(turned), math.sin(turned)
            yield east * cos - north * sin, east * sin + north * cos, piece.run_m


def _beyond_limits(pieces: tuple[Piece, ...], problem: Problem) -> float:
    """Return the metres beyond the engine's power, the ceiling and fuel; 0 with ``as_paper``."""
    limits, aircraft = problem.limits, problem.aircraft
    beyond = burned = 0.0
    for piece in pieces:
        weight = aircraft.weight_N - burned
        if thrust_needed(aircraft, weight, piece.run_m, piece.rise_m) > limits.thrust_N:
            beyond += piece.length_m
        low = piece.start[2]
        high = piece.stop[2] if isinstance(piece, Straight) else low + piece.rise_m
        low, high = min(low, high), max(low, high)
        if high > limits.ceiling_m:
            share = 1.0 if low >= limits.ceiling_m else (high - limits.ceiling_m) / (high - low)
            beyond += share * piece.length_m
        burned += _fuel((piece,), aircraft, problem.frame_wind, burned)
    if burned > limits.fuel_N:
        beyond += sum(piece.length_m for piece in pieces) * (1 - limits.fuel_N / burned)
    return beyond


def too_steep(piece: Piece, aircraft: Aircraft) -> bool:
    """Return whether a piece climbs or descends more steeply than the aircraft can."""
    slope = math.atan2(piece.rise_m, piece.run_m)
    return (
        slope > math.radians(aircraft.max_climb_deg) + SLOPE_TOLERANCE_RAD
        or slope < -math.radians(aircraft.max_descent_deg) - SLOPE_TOLERANCE_RAD
    )


def utopia(
    start: Sequence[float],
    goal: Sequence[float],
    aircraft: Aircraft,
    wind: tuple[float, float],
    base_m: float = 0.0,
) -> Utopia:
    """Return altitude, length and fuel of the straight line from ``start`` to ``goal``.

    Raises
    ------
    InputError
        If its mean altitude or its fuel is not positive, or the wind makes it impossible: costs are
        relative to these values.
    """
    (line,) = smooth(np.array([start, goal], dtype=np.float64), aircraft.turn_radius_m).pieces
    altitude = _mean_altitude(line) - base_m
    if not altitude > 0:
        above = f" above the lowest ground, {base_m:g} m" if base_m else ""
        raise InputError(
            f"The straight line from start to goal has a mean altitude of "
            f"{altitude:g} m{above}, and costs are relative to it; shift the datum so that "
            f"it is positive."
        )
    if _air_distance(line, aircraft, wind) is None:
        raise InputError(
            "The straight line from start to goal cannot be flown in this wind, and "
            "costs are relative to it; reduce the wind or move start or goal."
        )
    fuel = _fuel((line,), aircraft, wind)
    if not fuel > 0:
        raise InputError(
            "The straight line from start to goal is so steep a glide that it burns "
            "no fuel, and costs are relative to it; raise the goal or lower the "
            "start."
        )
    return Utopia(altitude, line.length_m, fuel)


def line_utopia(problem: Problem, start: Point, stop: Point) -> Utopia:
    """Return altitude, length and fuel that the costs between two points are relative to.

    They are the values of the straight line. A glide burns little fuel or none: a level line at its
    mean altitude and of its horizontal length takes its place, or of its height if it is vertical.
    The evaluation of the papers uses the straight line alone.

    Raises
    ------
    InputError
        As :func:`utopia` does.
    """
    (x0, y0, z0), (x1, y1, z1) = start, stop
    aircraft = problem.aircraft
    run_m = math.hypot(x1 - x0, y1 - y0)
    if problem.rules is not None and z1 < z0:
        thrust = thrust_needed(aircraft, aircraft.weight_N, run_m, z1 - z0)
        level_thrust = thrust_needed(aircraft, aircraft.weight_N, 1.0, 0.0)
        if thrust < _GLIDE * level_thrust:
            z0 = z1 = 0.5 * (z0 + z1)
            if run_m == 0.0:
                x1 += start[2] - stop[2]
    return utopia((x0, y0, z0), (x1, y1, z1), aircraft, problem.frame_wind, problem.cost_base_m)


@functools.lru_cache(maxsize=1)
def problem_utopia(problem: Problem) -> Utopia:
    """Return altitude, length and fuel that the costs of a problem are relative to.

    Every line between two points of its way starts with the full weight.

    Raises
    ------
    InputError
        As :func:`utopia` does, for any of the lines.
    """
    lines = [line_utopia(problem, start, stop) for start, stop in itertools.pairwise(problem.way)]
    if len(lines) == 1:
        return lines[0]
    length_m = sum(line.length_m for line in lines)
    area_m2 = sum(line.altitude_m * line.length_m for line in lines)
    return Utopia(area_m2 / length_m, length_m, sum(line.fuel_N for line in lines))


def _mean_altitude(piece: Piece) -> float:
    if isinstance(piece, Straight):
        return 0.5 * (piece.start[2] + piece.stop[2])
    return piece.start[2] + 0.5 * piece.rise_m


def _air_distance(piece: Piece, aircraft: Aircraft, wind: tuple[float, float]) -> float | None:
    return air_distance(
        piece.length_m, piece.run_m, piece.directions(), wind, aircraft.cruise_speed_m_s
    )


def _fuel(
    pieces: tuple[Piece, ...], aircraft: Aircraft, wind: tuple[float, float], before: float = 0.0
) -> float:
    """Return the fuel of all pieces; the wind is left out of a piece that it makes impossible.

    ``before`` was burned before the first piece.
    """
    burned = before
    for piece in pieces:
        distance = _air_distance(piece, aircraft, wind)
        burned += fuel_burned(
            aircraft,
            aircraft.weight_N - burned,
            piece.run_m,
            piece.rise_m,
            piece.length_m if distance is None else distance,
        )
    return burned - before
