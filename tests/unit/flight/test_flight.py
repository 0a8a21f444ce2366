"""Flights of the whole chain: guidance, autopilot and JSBSim."""

import math

import numpy as np
import pytest

from pathgene.host.errors import JobError
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.flight.flight import Flight, fly_track, limits_of
from pathgene.host.flight.models import MODELS
from pathgene.host.problem import aircraft
from tests.unit.flight.conftest import flown, straight


START = (4000.0, 10_000.0, 500.0)
#: A bend to either side, a climb and a descent.
PATH = np.array(
    [START, (5200, 10_000, 500), (6000, 11_000, 580), (7200, 11_000, 500), (7600, 9_000, 520)]
)


def test_level_flight_of_the_own_aircraft_has_the_power_of_its_polar(flat):
    flight = flown(flat, [straight((4000.0, 10_000.0, 0.0), 1500.0)])
    fox = aircraft.load("silver-fox")
    pressure_area = 0.5 * 1.225 * 23.0**2 * fox.wing_area_m2
    drag = (
        pressure_area * fox.zero_lift_drag_coefficient
        + fox.induced_drag_factor * fox.weight_N**2 / pressure_area
    )
    power = drag * 23.0 / fox.propeller_efficiency
    assert flight.power_W.mean() == pytest.approx(power, rel=0.04)
    assert np.ptp(flight.power_W) < 5
    # The lift coefficient is 0.45 at an angle of attack of 0.15 / 4.9 radians; the path is level.
    assert flight.airspeed_m_s == pytest.approx(23.0, abs=0.05)
    assert abs(flight.climb_m_s).max() < 0.02


@pytest.mark.parametrize("name", MODELS)
def test_every_model_keeps_to_a_track_in_calm_air(flat, name):
    figures = aircraft.load(name)
    scale = figures.turn_radius_m / 150
    path = np.array(START) + (PATH - START) * (scale, scale, 0.8)
    flight = flown(flat, smooth(path, figures.turn_radius_m).pieces, name)
    assert flight.arrived
    assert abs(flight.cross_m).max() < 8
    assert abs(flight.height_error_m).max() < 3
    assert flight.airspeed_m_s == pytest.approx(figures.cruise_speed_m_s, rel=0.1)


@pytest.mark.parametrize("wind", [(8.0, 0.0), (-8.0, 0.0), (0.0, 8.0)])
def test_wind_counts(flat, wind):
    flight = flown(flat, [straight(START, 2000.0)], wind=wind)
    ground = math.sqrt(23.0**2 - wind[1] ** 2) + wind[0]
    assert 2000 / flight.t_s[-1] == pytest.approx(ground, rel=0.01)
    assert flight.airspeed_m_s == pytest.approx(23.0, abs=0.1)
    assert abs(flight.cross_m).max() < 0.5


def test_same_seed_gives_the_same_flight(flat):
    first, again, other = (
        flown(flat, [straight(START, 1000.0)], gusts="light", seed=seed) for seed in (0, 0, 1)
    )
    assert np.array_equal(first.x, again.x)
    assert np.array_equal(first.z, again.z)
    assert not np.array_equal(first.z[:100], other.z[:100])
    assert 0.1 < np.std(first.airspeed_m_s) < 3


def test_gusts_grow_with_their_name(flat):
    spread = [
        float(np.std(flown(flat, [straight(START, 1500.0)], gusts=gusts, seed=1).airspeed_m_s))
        for gusts in ("none", "light", "moderate")
    ]
    assert spread == sorted(spread)
    assert spread[0] < 0.05


def test_commands_keep_the_limits_of_the_aircraft():
    fox = aircraft.load("silver-fox")
    limits = limits_of(fox)
    assert limits.bank_rad == pytest.approx(1.05 * math.atan(23**2 / (9.80665 * 150)))
    assert limits.climb_m_s == pytest.approx(1.05 * 23 * math.sin(math.radians(10)))
    assert limits.descent_m_s == pytest.approx(1.05 * 23 * math.sin(math.radians(30)))
    assert limits.power_W == 1850


def test_a_new_track_is_followed_in_flight(flat):
    fox = aircraft.load("silver-fox")
    flight = Flight([straight(START, 5000.0)], flat, fox, MODELS["silver-fox"])
    while flight.commands.place.along_m < 1000:
        flight.step()
    x, y, z = flight.state.x, flight.state.y, flight.state.z
    flight.follow([straight((x - 100.0, y + 30.0, z), 3000.0)])
    assert flight.commands.place.cross_m == pytest.approx(-30, abs=1)
    for _ in range(900):
        flight.step()
    assert flight.commands.place.cross_m == pytest.approx(0, abs=0.5)


def test_lost_aircraft_is_one_sentence(flat):
    flight = Flight(
        [straight(START, 2000.0)], flat, aircraft.load("silver-fox"), MODELS["silver-fox"]
    )
    # No time is left before the start.
    with pytest.raises(JobError, match=r"^The aircraft did not reach the start of the path; "):
        fly_track(flight, 0.0, 1e6)
