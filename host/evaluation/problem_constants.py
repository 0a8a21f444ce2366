"""The constants of a problem for the kernels."""

from __future__ import annotations

import math

from pathgene.host.evaluation.constants import SLOPE_TOLERANCE_RAD, Constants
from pathgene.host.evaluation.reference import Utopia, problem_utopia
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem


__all__ = ["constants_of"]


def constants_of(problem: Problem, ds_m: float, *, best: Utopia | None = None) -> Constants:
    """Return the kernels' constants of a problem; ``roofed`` is 0.

    Costs are relative to ``best``, by default to :func:`problem_utopia`, which may raise.
    """
    terrain, aircraft, limits = problem.terrain, problem.aircraft, problem.limits
    start, goal = (heading or (0.0, 0.0) for heading in problem.headings)
    rows, columns = terrain.elevation.shape
    best = best or problem_utopia(problem)
    return Constants(
        dx_m=float(terrain.dx_m),
        dy_m=float(terrain.dy_m),
        rows=rows,
        columns=columns,
        ds_m=ds_m,
        sampled=1,
        turn_radius_m=limits.turn_radius_m,
        max_climb_rad=math.radians(aircraft.max_climb_deg),
        max_descent_rad=math.radians(aircraft.max_descent_deg),
        weight=aircraft.weight_N,
        airspeed_m_s=aircraft.cruise_speed_m_s,
        # The kernels have one airspeed, the true one, and the density at sea level.
        wing_area_m2=aircraft.wing_area_m2
        * (aircraft.aerodynamic_speed_m_s / aircraft.cruise_speed_m_s) ** 2,
        drag_coefficient=aircraft.zero_lift_drag_coefficient,
        induced_drag_factor=aircraft.induced_drag_factor,
        burn_per_m=aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency,
        wind_x_m_s=float(problem.frame_wind[0]),
        wind_y_m_s=float(problem.frame_wind[1]),
        base_m=problem.cost_base_m,
        utopia_area_m2=best.altitude_m * best.length_m,
        utopia_fuel=best.fuel_N,
        in_air=int(problem.rules is not None and problem.wind != (0.0, 0.0)),
        roofed=0,
        headings=sum(heading is not None for heading in problem.headings),
        climb_m_s=_vertical_m_s(aircraft, aircraft.max_climb_deg),
        descent_m_s=_vertical_m_s(aircraft, aircraft.max_descent_deg),
        thrust=limits.thrust_N,
        fuel=limits.fuel_N,
        ceiling_m=limits.ceiling_m,
        start_east=start[0],
        start_north=start[1],
        goal_east=goal[0],
        goal_north=goal[1],
    )


def _vertical_m_s(aircraft: Aircraft, slope_deg: float) -> float:
    """Return the vertical speed of a slope flown in still air, and the tolerance of slopes."""
    slope = math.radians(slope_deg) + SLOPE_TOLERANCE_RAD
    return aircraft.cruise_speed_m_s * math.sin(min(slope, 0.5 * math.pi))
