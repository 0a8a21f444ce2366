"""The laws of guidance and the aircraft, each by itself, against closed forms."""

import math

import numpy as np
import pytest

from pathgene.sim.autopilot.airframe import SIMULATED_PLANE, Airframe, density, eas2tas
from pathgene.sim.autopilot.fence import Fence
from pathgene.sim.autopilot.height import Tecs, Vertical
from pathgene.sim.autopilot.items import Frame
from pathgene.sim.autopilot.lateral import L1, Motion
from pathgene.sim.autopilot.npfg import Npfg
from pathgene.sim.autopilot.parameters import ARDUPLANE, PX4, Parameters
from pathgene.sim.autopilot.places import Plane, cross, past, share
from pathgene.sim.autopilot.px4_height import Px4Height
from pathgene.sim.autopilot.targets import Earth, Target
from pathgene.sim.autopilot.vehicle import PERIOD_S, Loops, Vehicle
from pathgene.sim.autopilot.wind import Wind
from tests.support.autopilot.station import HOME, at


LOOPS = Loops(0.25, 0.25, math.radians(90), math.radians(90))


def vehicle(airframe=SIMULATED_PLANE, wind=None, altitude_m=0.0, airspeed_m_s=22.0):
    return Vehicle(
        airframe,
        LOOPS,
        Wind() if wind is None else wind,
        place=(0.0, 0.0, altitude_m),
        heading_rad=0.0,
        airspeed_m_s=airspeed_m_s,
    )


def test_the_standard_atmosphere():
    """Tabulated: 1.112 kg/m^3 at 1,000 m and 0.909 at 3,000 m."""
    assert density(1000) == pytest.approx(1.112, abs=1e-3)
    assert density(3000) == pytest.approx(0.909, abs=1e-3)
    assert eas2tas(3000) == pytest.approx(1.161, abs=1e-3)


def test_l1_demands_what_its_equations_say():
    law = L1(15.0, 0.75, 0.0)
    motion = Motion((0.0, 500.0), (0.0, 25.0), (0.0, 1.0))
    distance = 0.75 * 15 * 25 / math.pi
    # On the leg, nothing; 20 m to its right, a turn to the left.
    assert law.leg(motion, (0.0, 0.0), (0.0, 1000.0), 0.1) == pytest.approx(0.0)
    offset = Motion((20.0, 500.0), (0.0, 25.0), (0.0, 1.0))
    expected = -4 * 0.75**2 * 25**2 / distance * (20 / distance)
    assert law.leg(offset, (0.0, 0.0), (0.0, 1000.0), 0.1) == pytest.approx(expected)
    assert law.crosstrack_m == pytest.approx(20)
    # A target abeam or farther back: the largest demand there is.
    most = 4 * 0.75**2 * 25**2 / distance
    assert abs(law.leg(motion, (0.0, 500.0), (0.0, 480.0), 0.1)) == pytest.approx(most)


def test_l1_holds_a_circle_with_its_centripetal_acceleration():
    law = L1(15.0, 0.75, 0.0)
    east = Motion((100.0, 0.0), (0.0, -25.0), (0.0, -1.0))
    assert law.circle(east, (0.0, 0.0), 100.0, clockwise=True) == pytest.approx(25**2 / 100)
    assert law.is_on_circle
    west = Motion((-100.0, 0.0), (0.0, -25.0), (0.0, -1.0))
    assert law.circle(west, (0.0, 0.0), 100.0, clockwise=False) == pytest.approx(-(25**2) / 100)


def test_npfg_is_at_rest_on_its_path_in_wind():
    law = Npfg(10.0, 0.7, 0.5)
    # 15 m/s through air that moves 9 m/s east leave 12 m/s north.
    assert law.steer((0.0, 12.0), (9.0, 0.0), (0.0, 1.0), 0.0, 0.0) == pytest.approx(0, abs=1e-9)
    assert law.steer((0.0, 12.0), (9.0, 0.0), (0.0, 1.0), 30.0, 0.0) < 0
    # On a circle it demands the centripetal acceleration.
    circling = law.steer((0.0, 15.0), (0.0, 0.0), (0.0, 1.0), 0.0, 1 / 90)
    assert circling == pytest.approx(15**2 / 90)


@pytest.mark.parametrize("bank_deg", [20.0, -40.0])
def test_a_turn_has_the_radius_of_its_bank(bank_deg):
    plain = Airframe.of(
        weight_n=113.0,
        wing_area_m2=0.768,
        span_m=2.4,
        drag_zero=0.025,
        lift_max=1.3,
        power_w=1850,
        cruise_m_s=23.0,
    )
    flown = vehicle(plain, altitude_m=500.0, airspeed_m_s=23.0)
    height = flown.altitude_m
    headings = []
    for _ in range(300):
        pitch = 0.03 + 0.02 * (height - flown.altitude_m) - 0.06 * flown.velocity[2]
        flown.step(math.radians(bank_deg), pitch, 0.4)
        headings.append(math.atan2(*flown.velocity[:2]))
    rate = np.gradient(np.unwrap(headings), PERIOD_S)[-50:].mean()
    speed = math.hypot(*flown.velocity[:2])
    assert rate == pytest.approx(9.80665 * math.tan(math.radians(bank_deg)) / speed, rel=0.03)


def test_the_simulated_plane_slips_outwards_in_a_turn():
    """Its turns have three quarters of the rate of their bank, as in the flights."""
    flown = vehicle(altitude_m=1000.0, airspeed_m_s=24.0)
    headings = []
    for _ in range(200):
        pitch = 0.02 * (1000 - flown.altitude_m) - 0.06 * flown.velocity[2] - 0.03
        flown.step(math.radians(37), pitch, 0.55)
        headings.append(math.atan2(*flown.velocity[:2]))
    rate = np.gradient(np.unwrap(headings), PERIOD_S)[-50:].mean()
    speed = math.hypot(*flown.velocity[:2])
    assert rate * speed / (9.80665 * math.tan(math.radians(37))) == pytest.approx(0.76, abs=0.04)


def test_bank_follows_at_its_rate():
    flown = vehicle(altitude_m=500.0)
    banks = []
    for _ in range(15):
        flown.step(math.radians(65), -0.05, 0.5)
        banks.append(math.degrees(flown.roll_rad))
    assert np.diff(banks).max() == pytest.approx(9.0, abs=0.6)  # 90 degrees a second.
    assert max(banks) < 72
    assert banks[-1] == pytest.approx(65, abs=3)


def test_wind_moves_the_aircraft_and_not_its_airspeed():
    flown = vehicle(wind=Wind(6.0, -4.0), altitude_m=500.0)
    assert flown.tas_m_s == pytest.approx(22.0)
    assert flown.velocity[:2] == pytest.approx((6.0, 18.0))


def test_gusts_have_their_size_and_time():
    samples = Wind(gusts_m_s=2.0, gust_s=0.5, up=0.5, seed=3).samples()
    gusts = np.concatenate([samples.next() for _ in range(20_000)])
    assert gusts.std(axis=0) == pytest.approx([2.0, 2.0, 1.0], rel=0.05)
    east = gusts[:, 0]
    assert (east[50:] * east[:-50]).mean() / east.var() == pytest.approx(math.exp(-1), abs=0.05)


def test_places_go_there_and_back():
    plane = Plane(46.0, 8.0)
    lat, lon = plane.degrees((3000.0, -2000.0))
    assert plane.local(lat, lon) == pytest.approx((3000.0, -2000.0))
    assert cross((0.0, 1.0), (1.0, 0.0)) == 1.0  # East is to the right of north.
    assert share((5.0, 250.0), (0.0, 0.0), (0.0, 1000.0)) == 0.25
    assert past((0.0, 1000.0), (0.0, 0.0), (0.0, 1000.0))
    assert past((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))


def test_a_target_has_its_altitude_in_each_frame():
    earth = Earth(Plane(46.0, 8.0), 500.0, lambda place: 600.0 + place[0])
    for frame, altitude in ((Frame.AMSL, 90.0), (Frame.HOME, 590.0), (Frame.TERRAIN, 700.0)):
        assert Target((0.0, 0.0), 90.0, frame).altitude_m(earth, (10.0, 0.0)) == altitude


@pytest.mark.parametrize(
    ("place", "breached"),
    [((0, 0), False), ((150, 0), True), ((0, 900), True), ((400, 400), False)],
)
def test_fences_keep_in_and_out(place, breached):
    square = [(-500, -500), (500, -500), (500, 500), (-500, 500)]
    items = [at(*corner, command=5001, params=(4.0, 0.0, 0.0, 0.0)) for corner in square]
    items.append(at(200, 0, command=5004, params=(100.0, 0.0, 0.0, 0.0)))
    fence = Fence.of(items, Plane(*HOME[:2]))
    assert Fence.fault(items) is None
    assert fence.breached(tuple(map(float, place))) == breached


@pytest.mark.parametrize("law", [Tecs(Parameters(ARDUPLANE)), Px4Height(Parameters(PX4))])
def test_only_arduplane_slows_a_climb_that_the_throttle_does_not_hold(law):
    """The aircraft does not climb at all, so the throttle is at its stop."""
    now = Vertical(500.0, 0.0, 15.0, 0.0, 1.0, 0.0, 0.0)
    for tick in range(300):
        demand = law.update(now, 500.0 + 0.25 * tick, 15.0, 1.0, 0.1)
    assert demand.throttle >= 0.75
    # The demand has risen by 75 m; PX4's reference is late by 5 s at 2.5 m/s.
    if isinstance(law, Px4Height):
        assert law.height_m == law._energy.height_m == pytest.approx(575 - 12.5, abs=0.5)
    else:
        assert law.height_m < 540
