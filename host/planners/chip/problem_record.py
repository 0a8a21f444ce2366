"""A problem as integers of the planner core."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BLOCKS,
    DRAG_FRACTION,
    FUEL_BITS,
    POSITION_FRACTION,
    RADIUS_BITS,
    RISE_BITS,
    RISE_FRACTION,
    SCALE_FRACTION,
    SLOPE_BITS,
    SLOPE_FRACTION,
    VALUE_BITS,
    ProblemRecord,
)
from pathgene.host.errors import InputError
from pathgene.host.evaluation.fuel import thrust_needed
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.problem.compiled.surfaces import nodes_around, surfaces_below
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem


__all__ = ["block_shift", "chip_ends", "committed_points", "problem_record", "whole_path"]

#: Distance of a committed point from its end, in turning radii: room for more than a right angle.
_AHEAD_RADII = 1.1
#: Maximum share of a slope limit on the way to a committed point, and number of places checked.
_SHARE_OF_SLOPE = 0.98
_PLACES = 64
#: Minimum ratio of the greatest value of a key to the value of the straight line.
_VALUE_SPAN = 8
#: Number of directions over which the minimum slope in wind is taken.
_DIRECTIONS = 64


def problem_record(
    config: Config, problem: Problem, grid: CornerMap, blocks: int = BLOCKS
) -> ProblemRecord:
    """Return the record of ``problem`` on the map ``grid``.

    Rounding always makes a limit stricter: slopes are rounded down, the radius up. In wind the
    slopes are relative to the ground, in the direction in which they are lowest. The cost weighs
    altitude times length against fuel as eq. (2) does, for an aircraft that keeps its initial
    weight and saves no induced drag in climbs.

    If a heading is given, the path on the chip begins at the committed point, and the start is its
    entry; the same holds for the goal and the exit. See :func:`committed_points`.

    Parameters
    ----------
    blocks : int
        Maximum blocks along each edge of the map, :data:`~pathgene.hdl.protocol.planner.BLOCKS` or
        :data:`~pathgene.hdl.protocol.planner.COARSE_BLOCKS`.

    Raises
    ------
    InputError
        If the turning radius, or the ratio of the altitude step to the cell, is too large for the
        record.
    """
    dx_m, dy_m = grid.scale_m
    unit_m = max(dx_m, dy_m) / (1 << POSITION_FRACTION)
    part_m = grid.step_m / (1 << ALTITUDE_FRACTION)
    aircraft, best = problem.aircraft, problem_utopia(problem)

    radius = math.ceil(problem.limits.turn_radius_m / unit_m)
    if radius >> RADIUS_BITS:
        raise InputError(
            f"The turning radius of {problem.limits.turn_radius_m:g} m is more than 1,024 cells of "
            "the chip's map; take a coarser terrain."
        )
    rise = round(part_m / unit_m * (1 << RISE_FRACTION))
    if rise >> RISE_BITS:
        raise InputError(
            f"The chip's altitude step of {grid.step_m:g} m is a cell or more; take a coarser "
            "terrain."
        )
    # The altitudes of both ends of a piece are added, not averaged, so the area counts twice.
    area = 2 * best.altitude_m * best.length_m / (part_m * unit_m)
    burn_per_m = (
        aircraft.weight_N
        * aircraft.specific_fuel_consumption_N_per_Ws
        / aircraft.propeller_efficiency
    )
    fuel = burn_per_m * unit_m / best.fuel_N * area / (1 << DRAG_FRACTION)
    fuel_shift = max(FUEL_BITS - math.frexp(fuel)[1], 0)
    level_thrust = thrust_needed(aircraft, aircraft.weight_N, 1.0, 0.0)
    first, last = committed_points(problem)
    start, goal = (grid.place(point) for point in chip_ends(problem))
    entry, leave = grid.place(problem.start), grid.place(problem.goal)
    x_limit, y_limit, altitude_limit = grid.corner_limits
    directions = np.linspace(0, 2 * math.pi, _DIRECTIONS, endpoint=False)
    climbs, descents = problem.slope_limits(np.cos(directions), np.sin(directions))
    return ProblemRecord(
        start_x=start[0],
        start_y=start[1],
        start_altitude=start[2],
        goal_x=goal[0],
        goal_y=goal[1],
        goal_altitude=goal[2],
        x_limit=x_limit,
        y_limit=y_limit,
        altitude_limit=altitude_limit,
        x_scale=round(dx_m / max(dx_m, dy_m) * (1 << SCALE_FRACTION)),
        y_scale=round(dy_m / max(dx_m, dy_m) * (1 << SCALE_FRACTION)),
        rise=rise,
        climb=_slope(float(climbs.min()), unit_m / part_m),
        descent=_slope(float(descents.min()), unit_m / part_m),
        radius=radius,
        base=round(2 * (grid.base_m - problem.cost_base_m) / part_m),
        drag=min(
            round(level_thrust / aircraft.weight_N * (1 << DRAG_FRACTION)),
            (1 << DRAG_FRACTION) - 1,
        ),
        fuel=min(round(math.ldexp(fuel, fuel_shift)), (1 << FUEL_BITS) - 1),
        fuel_shift=min(fuel_shift, 31),
        key_shift=max(math.ceil(math.log2(2 * area * _VALUE_SPAN)) - VALUE_BITS, 0),
        block_shift=block_shift(max(x_limit, y_limit) + 1, blocks),
        **({} if first is None else _end("entry", entry)),
        **({} if last is None else _end("exit", leave)),
    )


@functools.lru_cache(maxsize=1)
def committed_points(problem: Problem) -> tuple[Point | None, Point | None]:
    """Return the first and last waypoints of every path, x, y and altitude; None if free.

    A heading at the start commits the aircraft to a point about a turning radius ahead; a heading
    at the goal, to a point the same distance before it. As the point lies straight ahead, there is
    no turn at the end itself, which the evaluation would put before the start or beyond the goal.
    The point is as high as its end, or higher if the ground on the way requires it, within the
    slope limit. If the map ends before that, the point is the corridor away from its edge, or at
    the edge if the end itself is nearer.
    """
    after, before = problem.headings
    first = last = None
    if after is not None:
        first = _ahead(problem, problem.start, after, problem.limits.climb_rad)
    if before is not None:
        back = -before[0], -before[1]
        last = _ahead(problem, problem.goal, back, problem.limits.descent_rad)
    return first, last


def chip_ends(problem: Problem) -> tuple[Point, Point]:
    """Return the points between which the chip plans: ends, or their committed points."""
    first, last = committed_points(problem)
    return first or problem.start, last or problem.goal


def whole_path(problem: Problem, waypoints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a path with its ends, (n, 3) metres, from the chip's waypoints, (m, 3) metres."""
    first, last = committed_points(problem)
    before = [problem.start, *([] if first is None else [first])]
    behind = [*([] if last is None else [last]), problem.goal]
    return np.vstack((before, waypoints.reshape(-1, 3), behind))


def _ahead(problem: Problem, end: Point, way: tuple[float, float], steepest_rad: float) -> Point:
    """Return the point ahead of an end, with the steepest slope from the end up to it."""
    terrain = problem.terrain
    run_m = _AHEAD_RADII * problem.limits.turn_radius_m
    corridor_m = 0.0 if problem.rules is None else problem.rules.corridor_m
    for at, along, far_m in zip(end[:2], way, (terrain.width_m, terrain.height_m), strict=True):
        if along:
            left_m = far_m - at if along > 0 else at
            run_m = min(
                run_m, (left_m - corridor_m if left_m > corridor_m else left_m) / abs(along)
            )
    share = np.arange(1, _PLACES + 1) / _PLACES
    points = np.array([at + share * run_m * along for at, along in zip(end[:2], way, strict=True)])
    part = nodes_around(terrain, points)
    # Blocked nodes need no height: no path passes there.
    surface = surfaces_below(
        terrain, points, -math.inf, problem.search_part(*part)[0], (part[0].start, part[1].start)
    )
    needed_m = float(((surface - end[2]) / share).max())
    rise_m = min(max(needed_m, 0.0), _SHARE_OF_SLOPE * math.tan(steepest_rad) * run_m)
    x, y = points[:, -1].tolist()
    return x, y, end[2] + rise_m


def _end(name: str, place: tuple[int, int, int]) -> dict[str, int]:
    """Return the fields of an entry or an exit."""
    x, y, altitude = place
    return {f"has_{name}": 1, f"{name}_x": x, f"{name}_y": y, f"{name}_altitude": altitude}


def _slope(tangent: float, parts_per_unit: float) -> int:
    """Return a slope rounded down and limited to the steepest that the record can hold."""
    return math.floor(min(tangent * parts_per_unit * (1 << SLOPE_FRACTION), (1 << SLOPE_BITS) - 1))


def block_shift(corners: int, blocks: int) -> int:
    """Return the shift of the smallest block size for which ``blocks`` cover ``corners`` corners.

    Parameters
    ----------
    corners : int
        Corners along each edge of the map.
    blocks : int
        Maximum blocks along each edge, a power of two.
    """
    return max((corners - 1).bit_length() - (blocks.bit_length() - 1), 0)
