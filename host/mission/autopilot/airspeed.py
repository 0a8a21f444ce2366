"""Airspeeds for an autopilot: a plan has true airspeeds, an autopilot holds equivalent ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from pathgene.host.evaluation.fuel import air_density
from pathgene.host.formats.flight_plan import CHANGE_SPEED, Item
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.limits import SEA_LEVEL_DENSITY_KG_M3


__all__ = ["equivalent_m_s", "with_speeds"]

# A higher speed is worth an item from this share of the cruise speed on; a lower one always is,
# because the aircraft needs it to keep its steepest climbs.
_WORTH = 0.02
# Airspeed above the stall that an autopilot keeps, as a factor.
_ABOVE_STALL = 1.2
_AIRSPEED, _SAME_THROTTLE = 0.0, -1.0


def equivalent_m_s(true_m_s: float, altitude_m: float) -> float:
    """Return the equivalent airspeed of a true one in the standard atmosphere."""
    return true_m_s * math.sqrt(air_density(altitude_m) / SEA_LEVEL_DENSITY_KG_M3)


def with_speeds(items: Sequence[Item], aircraft: Aircraft) -> tuple[tuple[Item, ...], bool]:
    """Return a mission with the changes of speed that keep the planned true airspeed.

    ArduPilot carries out a change of speed on the way to the waypoint before it, PX4 after that
    waypoint. So it suits the heights of both legs: the airspeed of the highest point is the
    lowest.

    Returns
    -------
    items : tuple of Item
        The mission.
    is_slow : bool
        Whether the planned airspeed would be too near to the stall somewhere. The autopilot then
        holds 1.2 times the stall speed, and is faster than planned.
    """
    cruise = aircraft.cruise_speed_m_s
    least = _ABOVE_STALL * _stall_m_s(aircraft)
    made, present, is_slow = [items[0]], cruise, False
    highest = [max(a.alt_m, b.alt_m) for a, b in pairwise(items)]
    for number, item in enumerate(items[1:]):
        wanted = equivalent_m_s(cruise, max(highest[max(number - 1, 0) : number + 1]))
        is_slow |= wanted < min(least, cruise)
        wanted = math.floor(10 * max(wanted, min(least, cruise))) / 10
        if not present <= wanted < present + _WORTH * cruise:
            made.append(Item(CHANGE_SPEED, (_AIRSPEED, wanted, _SAME_THROTTLE, 0.0), 0.0, 0.0, 0.0))
            present = wanted
        made.append(item)
    return tuple(made), is_slow


def _stall_m_s(aircraft: Aircraft) -> float:
    """Return the equivalent airspeed of the stall in level flight, 0 if it is unknown."""
    if aircraft.lift_coefficient_max is None:
        return 0.0
    pressure = aircraft.weight_N / (aircraft.wing_area_m2 * aircraft.lift_coefficient_max)
    return math.sqrt(2 * pressure / SEA_LEVEL_DENSITY_KG_M3)
