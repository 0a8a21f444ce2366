"""Loops of the autopilot, tested on the state alone."""

import dataclasses

import pytest

from pathgene.host.flight.autopilot import Autopilot
from pathgene.host.flight.guidance import Commands
from pathgene.host.flight.models import MODELS
from pathgene.host.flight.route import Place
from pathgene.host.problem import aircraft
from tests.unit.flight.test_guidance import state


LEVEL = state(0, 0, 0, 0.0)


def autopilot(**figures):
    fox = dataclasses.replace(aircraft.load("silver-fox"), **figures)
    return Autopilot(MODELS["silver-fox"], fox, 1 / 30)


def commands(bank=0.0, climb=0.0):
    return Commands(Place(0, 0.0, 0.0), bank, climb, 0.0)


def test_level_flight_needs_no_surface():
    aileron, elevator, rudder, throttle, brake = autopilot().controls(LEVEL, commands())
    assert (aileron, elevator, rudder, brake) == (0, 0, 0, 0)
    assert throttle == MODELS["silver-fox"].throttle_level


@pytest.mark.parametrize("sign", [-1, 1])
def test_surfaces_answer_the_commands(sign):
    aileron, elevator, *_ = autopilot().controls(LEVEL, commands(sign * 0.3, sign * 2.0))
    assert aileron * sign > 0.05
    assert elevator * sign > 0.01


def test_steep_descent_takes_the_brake():
    *_, throttle, brake = autopilot().controls(LEVEL, commands(climb=-10.0))
    assert throttle == 0
    assert brake > 0.5


def test_slow_flight_gives_up_height():
    # The stall speed at sea level is 13.8 m/s, at 3000 m 16 m/s.
    def elevator(airspeed, height=0.0, **figures):
        slow = dataclasses.replace(LEVEL, airspeed_m_s=airspeed, z=height)
        pilot = autopilot(**figures)
        return [pilot.controls(slow, commands())[1] for _ in range(90)][-1]

    assert elevator(15.0) < -0.05
    assert elevator(18.0) == 0
    assert elevator(18.0, 3000.0) < -0.05
    assert elevator(15.0, lift_coefficient_max=None) == 0


def test_throttle_is_held_back_to_the_power():
    pilot = autopilot(engine_power_W=500.0)
    strong = dataclasses.replace(LEVEL, airspeed_m_s=20.0, power_W=1000.0)
    throttles = [pilot.controls(strong, commands(climb=4.0))[3] for _ in range(60)]
    assert throttles[0] > 0.9
    assert throttles[-1] < 0.5
