"""A problem in the integers of the planner on the chip."""

from __future__ import annotations

import math

import numpy as np

from hdl.config import Config
from hdl.protocol.planner import (
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
from host.errors import InputError
from host.evaluation.fuel import SEA_LEVEL_DENSITY_KG_M3, thrust_needed
from host.evaluation.reference import problem_utopia
from host.problem.corner_map import CornerMap
from host.problem.problem import Problem


__all__ = ["problem_record"]

#: The greatest value of a key is at least so many times that of the straight line.
_VALUE_SPAN = 8
#: Directions of which the least slopes in wind are taken.
_DIRECTIONS = 64


def problem_record(config: Config, problem: Problem, grid: CornerMap) -> ProblemRecord:
    """Return the record of ``problem`` on the map ``grid``.

    Whatever a limit loses by rounding makes it stricter: slopes are rounded down, the radius up. In
    wind the slopes are those over ground in the direction where they are least.
    The cost weighs altitude times length against fuel as eq. (2) does, with the fuel of a weight
    that stays that of the start, and no induced drag saved in climbs.

    Raises
    ------
    InputError
        If the turning radius, or the altitude step against the cell, is too great for the record.
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
    # Altitudes of both ends of a piece are added, not averaged: the area counts twice.
    area = 2 * best.altitude_m * best.length_m / (part_m * unit_m)
    burn_per_m = (
        aircraft.weight_N
        * aircraft.specific_fuel_consumption_N_per_Ws
        / aircraft.propeller_efficiency
    )
    fuel = burn_per_m * unit_m / best.fuel_N * area / (1 << DRAG_FRACTION)
    fuel_shift = max(FUEL_BITS - math.frexp(fuel)[1], 0)
    level_thrust = thrust_needed(aircraft, aircraft.weight_N, 1.0, 0.0, SEA_LEVEL_DENSITY_KG_M3)
    start, goal = (grid.place(point) for point in (problem.start, problem.goal))
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
        base=round(2 * grid.base_m / part_m),
        drag=min(
            round(level_thrust / aircraft.weight_N * (1 << DRAG_FRACTION)),
            (1 << DRAG_FRACTION) - 1,
        ),
        fuel=min(round(math.ldexp(fuel, fuel_shift)), (1 << FUEL_BITS) - 1),
        fuel_shift=min(fuel_shift, 31),
        key_shift=max(math.ceil(math.log2(2 * area * _VALUE_SPAN)) - VALUE_BITS, 0),
        block_shift=_block_shift(max(x_limit, y_limit) + 1),
    )


def _slope(tangent: float, parts_per_unit: float) -> int:
    """Return a slope rounded down; the steepest that the record holds is taken for all steeper."""
    return math.floor(min(tangent * parts_per_unit * (1 << SLOPE_FRACTION), (1 << SLOPE_BITS) - 1))


def _block_shift(corners: int) -> int:
    """Return the shift of the smallest blocks of which 32 cover so many corners."""
    return max((corners - 1).bit_length() - (BLOCKS.bit_length() - 1), 0)
