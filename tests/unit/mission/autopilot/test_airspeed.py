"""Airspeeds for an autopilot, which holds equivalent ones."""

import dataclasses
import math

import pytest

from pathgene.host.formats.flight_plan import CHANGE_SPEED, LOITER, WAYPOINT, Item
from pathgene.host.mission.autopilot.airspeed import equivalent_m_s, with_speeds
from pathgene.host.problem.aircraft import load
from pathgene.sim.autopilot.airframe import eas2tas


FOX = load("silver-fox")


def mission(*heights):
    places = [Item(WAYPOINT, (0.0, 10.0, 0.0, None), 46.0, 7.0, height) for height in heights]
    return [*places, Item(LOITER, (0.0, 0.0, 150.0, 0.0), 46.0, 7.0, heights[-1])]


def legs(items):
    """Return height and asked airspeed of each waypoint's leg, for both orders of items.

    ArduPilot changes the speed on the way to the waypoint before it, PX4 after that waypoint.
    """
    found, speed, before = [], FOX.cruise_speed_m_s, None
    for number, item in enumerate(items):
        if item.command == CHANGE_SPEED:
            continue
        if before is not None:
            highest = max(before.alt_m, item.alt_m)
            found.append((highest, speed))
        for later in items[number + 1 :]:
            if later.command != CHANGE_SPEED:
                break
            if before is not None:
                found.append((highest, later.params[1]))
            speed = later.params[1]
        before = item
    return found


@pytest.mark.parametrize("altitude_m", [0.0, 1500.0, 4800.0, 9000.0])
def test_the_equivalent_airspeed_is_the_simulated_autopilots(altitude_m):
    assert equivalent_m_s(23.0, altitude_m) * eas2tas(altitude_m) == pytest.approx(23, rel=1e-4)


def test_no_leg_is_faster_through_the_air_than_planned():
    items, is_thin = with_speeds(mission(300, 900, 2000, 3500, 3500, 1200, 300, 300), FOX)
    assert not is_thin
    assert sum(item.command == CHANGE_SPEED for item in items) >= 5
    for height, speed in legs(items):
        assert speed * eas2tas(height) <= 23.0 * eas2tas(300) + 0.3
    last = [item.params[1] for item in items if item.command == CHANGE_SPEED][-1]
    assert last == pytest.approx(23.0 / eas2tas(300), rel=0.03)


def test_a_low_mission_has_no_change_of_speed():
    items, _ = with_speeds(mission(0, 0, 0), FOX)
    assert {item.command for item in items} == {WAYPOINT, LOITER}


def test_no_speed_is_near_the_stall():
    heavy = dataclasses.replace(FOX, weight_N=150.0)
    stall = math.sqrt(2 * 150 / (1.225 * FOX.wing_area_m2 * FOX.lift_coefficient_max))
    items, is_thin = with_speeds(mission(5000, 5000, 5000), heavy)
    assert is_thin
    speeds = [item.params[1] for item in items if item.command == CHANGE_SPEED]
    assert min(speeds) == pytest.approx(1.2 * stall, abs=0.1)
    unknown = dataclasses.replace(heavy, lift_coefficient_max=None)
    assert not with_speeds(mission(5000, 5000, 5000), unknown)[1]
