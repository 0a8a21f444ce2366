"""An aircraft of the host's flight model, as the simulated autopilot sees it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.flight.guidance import State
from pathgene.host.problem import aircraft
from pathgene.host.terrain import Terrain
from pathgene.sim.autopilot.parameters import ARDUPLANE
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot.places import Plane
from pathgene.sim.autopilot.vehicle import PERIOD_S
from pathgene.sim.autopilot_flight import _measured, _OnPlane, parameters_of, px4_parameters_of


class Straight:
    """An aircraft that flies straight through the terrain's frame and gains speed."""

    level_throttle, climb_throttle, throttle = 0.2, 2.0, 0.5
    wind = (3.0, -4.0)

    def __init__(self):
        still = dict.fromkeys(State.__annotations__, 0.0)
        moving = {"x": 2000.0, "y": 3000.0, "z": 2000.0, "east_m_s": 12.0, "north_m_s": 16.0}
        self.state = State(**(still | moving | {"airspeed_m_s": 25.0, "climb_m_s": 2.0}))

    def step(self, roll_rad, pitch_rad, throttle):
        state = self.state
        self.state = replace(
            state,
            x=state.x + PERIOD_S * state.east_m_s,
            y=state.y + PERIOD_S * state.north_m_s,
            z=state.z + PERIOD_S * state.climb_m_s,
            east_m_s=state.east_m_s + PERIOD_S * 0.5,
        )


@pytest.fixture
def craft():
    # 4 degrees west of the meridian of its zone, where the grid is turned by 3 degrees.
    terrain = Terrain("far", np.zeros((41, 41)), 250, 250, "EPSG:32632", (195_000.0, 5_200_000.0))
    lat, lon = terrain.to_geographic(2000.0, 3000.0)
    return _OnPlane(Straight(), terrain, Plane(float(lat), float(lon)))


def test_velocities_are_turned_with_the_places(craft):
    before = craft.place
    assert before == pytest.approx((0, 0), abs=1e-6)
    east, north, up = craft.velocity
    craft.step(0.0, 0.0, 0.5)
    moved = [(new - old) / PERIOD_S for new, old in zip(craft.place, before, strict=True)]
    # The plane's metres differ from the grid's by a few thousandths.
    assert moved == pytest.approx((east, north), rel=0.006)
    assert up == 2.0
    turned = math.degrees(math.atan2(north, east) - math.atan2(16, 12))
    assert 2.5 < abs(turned) < 3.5
    angles = [math.atan2(*reversed(vector)) for vector in (craft.wind, craft.velocity[:2])]
    frame = math.atan2(-4, 3) - math.atan2(16, 12)
    assert math.remainder(angles[0] - angles[1] - frame, 2 * math.pi) == pytest.approx(0, abs=0.02)


def test_the_nose_points_through_the_air_and_speed_is_gained_along_it(craft):
    craft.step(0.0, 0.0, 0.5)
    through = np.array(craft.velocity[:2]) - craft.wind
    assert craft.nose == pytest.approx(tuple(through / np.hypot(*through)))
    assert math.hypot(*craft.nose) == pytest.approx(1)
    assert 0.1 < craft.forward_m_s2 < 0.5
    assert craft.sensed_tas_m_s == 25.0
    assert craft.sensed_eas_m_s < 23.0


def test_both_autopilots_get_the_speeds_and_throttles_of_the_aircraft():
    figures = aircraft.load("silver-fox")
    plane, px4 = parameters_of(figures), px4_parameters_of(figures)
    assert px4["FW_AIRSPD_TRIM"] == plane["AIRSPEED_CRUISE"] == figures.cruise_speed_m_s
    assert px4["FW_T_CLMB_R_SP"] == plane["TECS_CLMB_MAX"]
    assert plane["NAVL1_PERIOD"] == ARDUPLANE["NAVL1_PERIOD"]
    measured = _measured(Kind.ARDUPLANE, figures, Straight())
    speed = figures.cruise_speed_m_s
    assert measured == {
        "TRIM_THROTTLE": 20.0,
        "TECS_SINK_MIN": speed * 0.1,
        "TECS_CLMB_MAX": pytest.approx(speed * 0.4),
    }
    assert list(_measured(Kind.PX4, figures, Straight()).values()) == list(measured.values())
