"""Lower bounds of the fuel and the power of any path from start to goal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pathgene.host.diagnosis.bounds import Bounds
from pathgene.host.diagnosis.reason import Figure, Reason, rounded_down, rounded_up


__all__ = ["fuel_reasons", "least_fuel", "least_power", "power_reasons"]


def least_fuel(bounds: Bounds) -> float:
    """Return the minimum fuel in newtons that any path within the limits burns.

    The thrust along a path is the drag plus the component of the weight along the slope. The drag
    is minimal at the minimum weight and the steepest slope; the weight does work against the rise
    from start to goal, less the saving of a lighter aircraft on climbs from the lowest ground. At
    best, wind shortens the distance through the air to V / (V + wind) of the distance over the
    ground.
    """
    problem, aircraft = bounds.problem, bounds.problem.aircraft
    if problem.rules is None:
        return 0.0
    burned_per_work = aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
    tank = problem.limits.fuel_N
    # Without a tank size, the whole weight might be fuel.
    lightest = max(aircraft.weight_N - tank, 0.0)
    steepest = math.radians(max(aircraft.max_climb_deg, aircraft.max_descent_deg))
    area = 0.5 * 1.225 * aircraft.cruise_speed_m_s**2 * aircraft.wing_area_m2
    lift = lightest * math.cos(min(steepest, 0.5 * math.pi))
    drag = (
        area * aircraft.zero_lift_drag_coefficient + aircraft.induced_drag_factor * lift**2 / area
    )
    rise = problem.goal[2] - problem.start[2]
    work = drag * math.dist(problem.start, problem.goal) + aircraft.weight_N * rise
    wind = math.hypot(*problem.wind)
    shortest = aircraft.cruise_speed_m_s / (aircraft.cruise_speed_m_s + wind)
    above = max(problem.goal[2] - problem.terrain.lowest, 0.0)
    return max(burned_per_work * shortest * work / (1 + burned_per_work * above), 0.0)


def least_power(bounds: Bounds, slope: float) -> float:
    """Return the shaft power that holds a slope (a tangent) at take-off weight."""
    aircraft = bounds.problem.aircraft
    thrust = bounds.thrust(math.atan(slope), aircraft.weight_N)
    return max(thrust, 0.0) * aircraft.cruise_speed_m_s / aircraft.propeller_efficiency


def power_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that the engine cannot hold level flight, if the path needs it."""
    problem, aircraft = bounds.problem, bounds.problem.aircraft
    slope = bounds.power_slope
    if problem.rules is None or aircraft.engine_power_W is None or not slope < 0:
        return
    z = problem.start[2]
    needed = rounded_up(least_power(bounds, 0.0), 1.0)
    figure = Figure("power", aircraft.engine_power_W, needed, "W")
    way = math.dist(problem.start[:2], problem.goal[:2])
    sinks = (
        f"The engine of {aircraft.name} gives {aircraft.engine_power_W:g} W and level flight "
        f"takes {needed:.0f} W"
    )
    if z + slope * way < problem.goal[2] - 1e-3:
        yield Reason(
            code="power",
            sentence=f"{sinks}: the aircraft sinks, and is {problem.goal[2] - z - slope * way:.0f}"
            " m too low at the goal.",
            proven=True,
            place=problem.goal[:2],
            figure=figure,
        )
        return
    barrier = bounds.barrier(z)
    if barrier.closed:
        yield Reason(
            code="power",
            sentence=f"{sinks}: the aircraft sinks, and no way to the goal stays below the altitude"
            " of the start.",
            proven=True,
            place=barrier.ring().place,
            figure=figure,
        )


def fuel_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that the fuel does not even last for the straight line."""
    problem, aircraft = bounds.problem, bounds.problem.aircraft
    if problem.rules is None or aircraft.fuel_weight_N is None:
        return
    least = least_fuel(bounds)
    if least <= problem.limits.fuel_N:
        return
    burnt, tank = (_up(fuel) for fuel in (least, least / (1.0 - problem.rules.reserve)))
    allowed = rounded_down(problem.limits.fuel_N, _step(problem.limits.fuel_N))
    yield Reason(
        code="fuel",
        sentence=f"The fuel does not last: even the straight line burns {burnt:g} N, and "
        f"{allowed:g} N may be burnt with a reserve of {100 * problem.rules.reserve:g} %; at least "
        f"{tank:g} N of fuel is needed.",
        proven=True,
        place=problem.goal[:2],
        figure=Figure("fuel", aircraft.fuel_weight_N, tank, "N"),
    )


def _step(fuel: float) -> float:
    """Return the value of a step in the third significant digit."""
    return 10.0 ** (math.floor(math.log10(fuel)) - 2) if fuel > 0 else 1.0


def _up(fuel: float) -> float:
    return rounded_up(fuel, _step(fuel))
