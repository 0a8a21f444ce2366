"""Airspeeds for an autopilot: a plan has true airspeeds, an autopilot holds equivalent ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from pathgene.host.formats.flight_plan import CHANGE_SPEED, LAND, Item
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.atmosphere import SEA_LEVEL_DENSITY_KG_M3, equivalent_m_s


__all__ = ["with_speeds"]

# Share of the cruise speed by which the airspeed may be lower than planned to save an item. It is
# never higher, because the aircraft needs the planned one to keep its steepest climbs.
_WORTH = 0.02
# Airspeed above the stall that an autopilot keeps, as a factor.
_ABOVE_STALL = 1.2
_AIRSPEED, _SAME_THROTTLE = 0.0, -1.0


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
    highest = [max(a.alt_m, b.alt_m) for a, b in pairwise(items)]
    wanted = [
        equivalent_m_s(cruise, max(highest[max(number - 1, 0) : number + 1]))
        for number in range(len(highest))
    ]
    is_slow = min(wanted, default=cruise) < min(least, cruise)
    wanted = [math.floor(10 * max(each, min(least, cruise))) / 10 for each in wanted]
    made, present = [items[0]], cruise
    for number, item in enumerate(items[1:]):
        # PX4 takes the item before a landing for the beginning of its approach.
        if item.command != LAND and not present <= wanted[number] < present + _WORTH * cruise:
            present = _lasting(wanted[number:], _WORTH * cruise)
            speed = (_AIRSPEED, present, _SAME_THROTTLE, 0.0)
            made.append(Item(CHANGE_SPEED, speed, 0.0, 0.0, 0.0))
        made.append(item)
    return tuple(made), is_slow


def _lasting(wanted: Sequence[float], tolerance_m_s: float) -> float:
    """Return the speed that suits the most legs, none of which wants less or much more."""
    low = high = wanted[0]
    for each in wanted[1:]:
        if max(high, each) - min(low, each) >= tolerance_m_s:
            break
        low, high = min(low, each), max(high, each)
    return low


def _stall_m_s(aircraft: Aircraft) -> float:
    """Return the equivalent airspeed of the stall in level flight, 0 if it is unknown."""
    if aircraft.lift_coefficient_max is None:
        return 0.0
    pressure = aircraft.weight_N / (aircraft.wing_area_m2 * aircraft.lift_coefficient_max)
    return math.sqrt(2 * pressure / SEA_LEVEL_DENSITY_KG_M3)
