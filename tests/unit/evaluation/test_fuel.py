"""Fuel compared with numerical integration; wind and air compared with hand calculations."""

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from pathgene.host.evaluation.fuel import air_distance, fuel_burned
from pathgene.host.problem.aircraft import load


FOX = load("silver-fox")
MALE = load("predator")


def integrated(aircraft, weight, slope_rad, distance_m):
    """Integrate dW/ds = -(sfc / eta) T numerically, T from the polar."""
    pressure_area = 0.5 * 1.225 * aircraft.cruise_speed_m_s**2 * aircraft.wing_area_m2
    factor = 1 / (
        math.pi * aircraft.oswald_efficiency * aircraft.wing_span_m**2 / aircraft.wing_area_m2
    )

    def burn(_, weight_now):
        drag = (
            pressure_area * aircraft.zero_lift_drag_coefficient
            + factor * (weight_now * math.cos(slope_rad)) ** 2 / pressure_area
        )
        thrust = drag + weight_now * math.sin(slope_rad)
        return -aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency * thrust

    solution = solve_ivp(burn, (0, distance_m), [weight], method="DOP853", rtol=1e-13, atol=1e-12)
    return weight - solution.y[0, -1]


def test_level_kilometre_by_hand():
    # q = 324.0125 Pa, q S = 248.8416 N; drag = 6.24592 + 2.72228 = 8.96820 N.
    assert fuel_burned(FOX, 113.0, 1000.0, 0.0, 1000.0) == pytest.approx(0.0129690, rel=1e-4)


@pytest.mark.parametrize("aircraft", [FOX, MALE], ids=["fox", "male"])
# Level and shallow slopes have X > 0, steep ones X < 0; the sign changes near 4.2 degrees.
@pytest.mark.parametrize("slope_deg", [-2.0, -1.0, 0.0, 1e-7, 2.0, 4.0, 4.3, 10.0, 30.0, 90.0])
@pytest.mark.parametrize("length", [1.0, 30_000.0, 2_000_000.0])
def test_closed_solution_is_the_integral(aircraft, slope_deg, length):
    slope = math.radians(slope_deg)
    burned = fuel_burned(
        aircraft, aircraft.weight_N, length * math.cos(slope), length * math.sin(slope), length
    )
    assert burned > 0
    if burned < 0.5 * aircraft.weight_N:
        # Over a metre the integral's difference of two weights loses digits; the solution does not.
        assert burned == pytest.approx(
            integrated(aircraft, aircraft.weight_N, slope, length), rel=1e-9, abs=1e-11
        )


def test_closed_solution_where_the_discriminant_vanishes():
    # With sin = 0.6 and cos = 0.8, X = 4 k 0.64 CD0 - 0.36: find a CD0 for which X is exactly 0.
    wanted = 0.36 / (4 * FOX.induced_drag_factor * 0.64)
    for _ in range(9):
        aircraft = dataclasses.replace(FOX, zero_lift_drag_coefficient=wanted)
        assert fuel_burned(aircraft, 113.0, 80.0, 60.0, 100.0) == pytest.approx(
            integrated(aircraft, 113.0, math.asin(0.6), 100.0), rel=1e-9
        )
        wanted = math.nextafter(wanted, math.inf)


def test_steep_glide_burns_nothing():
    assert fuel_burned(FOX, 113.0, 1000.0, -math.tan(math.radians(10)) * 1000, 1000.0) == 0.0


def test_weight_falls_along_the_flight():
    whole = fuel_burned(FOX, 113.0, 30_000.0, 0.0, 30_000.0)
    first = fuel_burned(FOX, 113.0, 10_000.0, 0.0, 10_000.0)
    second = fuel_burned(FOX, 113.0 - first, 20_000.0, 0.0, 20_000.0)
    assert first + second == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize(
    ("wind", "distance"),
    [
        ((0.0, 0.0), 1000.0),
        ((10.0, 0.0), 1000 * 23 / 33),
        ((-10.0, 0.0), 1000 * 23 / 13),
        ((0.0, 10.0), 1000 * 23 / math.sqrt(23**2 - 10**2)),
        ((6.0, -8.0), 1000 * 23 / (6 + math.sqrt(23**2 - 8**2))),
    ],
    ids=["calm", "tail", "head", "cross", "oblique"],
)
def test_air_distance_of_a_level_line(wind, distance):
    assert air_distance(1000.0, 1000.0, [(1.0, 0.0, 1000.0)], wind, 23.0) == pytest.approx(distance)


def test_air_distance_of_a_climb():
    # 3-4-5: the horizontal airspeed is 0.8 * 25 = 20 m/s.
    flown = air_distance(500.0, 400.0, [(0.0, 1.0, 400.0)], (0.0, -5.0), 25.0)
    assert flown == pytest.approx(25 * 400 / 15)


@given(length=st.floats(1e-3, 1e6), slope=st.floats(-1.5, 1.5))
def test_calm_air_distance_is_the_length_to_the_last_bit(length, slope):
    assert (
        air_distance(length, length * math.cos(slope), [(1.0, 0.0, length)], (0.0, -0.0), 23.0)
        == length
    )


@pytest.mark.parametrize(
    ("run_m", "wind"),
    [
        (0.0, (1.0, 0.0)),
        (100.0, (0.0, 12.0)),
        (100.0, (-11.5, 0.0)),
        (100.0, (-15.0, 0.0)),
    ],
    ids=["vertical", "cross wind", "stands still", "head wind"],
)
def test_no_air_distance_against_too_strong_wind(run_m, wind):
    # On a slope of 60 degrees 11.5 of 23 m/s are horizontal.
    directions = [(1.0, 0.0, run_m)] if run_m else []
    assert air_distance(200.0, run_m, directions, wind, 23.0) is None
