"""Limits of an aircraft in wind, compared with a simulated flight in moving air."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.problem import aircraft
from pathgene.host.problem.limits import Limits, slope_limits
from pathgene.host.problem.rules import Rules


FOX = aircraft.load("silver-fox")
BARE = dataclasses.replace(FOX, engine_power_W=None)


def test_as_paper_the_file_alone_limits():
    limits = Limits.of(FOX, (20.0, 0.0), None)
    assert limits == Limits(150.0, math.radians(10), math.radians(30))


def test_turn_radius_of_a_turn_with_the_wind():
    assert Limits.of(FOX, (6.0, 8.0), Rules()).turn_radius_m == pytest.approx(
        150 * (1 + 10 / 23) ** 2
    )
    stalling = dataclasses.replace(FOX, lift_coefficient_max=0.46)
    limits = Limits.of(stalling, (0.0, 0.0), Rules())
    assert limits.turn_radius_m == math.inf
    bank = math.atan(23**2 / (9.80665 * 150))
    lift = 0.5 * 1.225 * limits.stall_speed_m_s**2 * FOX.wing_area_m2 * 0.46
    assert lift * math.cos(bank) == pytest.approx(FOX.weight_N)


def test_fuel_ceiling_and_power():
    limits = Limits.of(
        dataclasses.replace(FOX, service_ceiling_m=900.0), (0.0, 0.0), Rules(reserve=0.25)
    )
    assert limits.fuel_N == pytest.approx(19 * 0.75)
    assert limits.ceiling_m == 900
    assert Limits.of(FOX, (0.0, 0.0), Rules(ceiling_m=700.0)).ceiling_m == 700
    # The power that a climb of 5 degrees takes.
    pressure_area = 0.5 * 1.225 * 23**2 * FOX.wing_area_m2
    lift, weight = FOX.weight_N * math.cos(math.radians(5)), FOX.weight_N
    drag = pressure_area * FOX.zero_lift_drag_coefficient
    drag += FOX.induced_drag_factor * lift**2 / pressure_area
    power = (drag + weight * math.sin(math.radians(5))) * 23 / FOX.propeller_efficiency
    weak = dataclasses.replace(FOX, engine_power_W=power)
    assert Limits.of(weak, (0.0, 0.0), Rules()).climb_rad == pytest.approx(math.radians(5))
    hopeless = dataclasses.replace(FOX, engine_power_W=10.0)
    assert Limits.of(hopeless, (0.0, 0.0), Rules()).climb_rad < 0


def test_slopes_in_wind_are_those_of_velocities_through_the_air():
    rng = np.random.default_rng(0)
    limits = Limits.of(BARE, (0.0, 0.0), Rules())
    for _ in range(300):
        speed, heading = rng.uniform(0, 20), rng.uniform(0, 2 * math.pi)
        wind = float(speed * math.cos(heading)), float(speed * math.sin(heading))
        east, north = math.cos(1.0), math.sin(1.0)
        climbs, descents = slope_limits(limits, 23.0, wind, np.array([east]), np.array([north]))
        for slope, still, sign in (
            (climbs[0], math.tan(math.radians(10)), 1),
            (descents[0], math.tan(math.radians(30)), -1),
        ):
            assert 0 <= slope <= still + 1e-12
            if slope == 0:
                continue
            # The aircraft flies at this slope through the air, in wind across and along the track.
            through_air = 23.0 * math.cos(math.atan(slope))
            along = wind[0] * east + wind[1] * north
            across = wind[0] * north - wind[1] * east
            over_ground = along + math.sqrt(max(through_air**2 - across**2, 0.0))
            vertical = over_ground * slope
            most = 23.0 * math.sin(math.atan(still))
            assert vertical <= most * (1 + 1e-9), sign
            # The limit is used up, unless still air sets it, or the wind stops the flight.
            stopped = over_ground < 1e-3
            assert stopped or slope == pytest.approx(still) or vertical == pytest.approx(most)
