"""Landings, missed approaches and returns of the simulated autopilot."""

import math

import pytest

from pathgene.sim.autopilot import plane_navigator
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.items import Frame
from pathgene.sim.autopilot.lateral import Motion
from pathgene.sim.autopilot.parameters import ARDUPLANE, SIMULATED_PLANE, Parameters
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.places import Plane
from pathgene.sim.autopilot.plane_landing import PlaneLanding
from pathgene.sim.autopilot.targets import Air, Earth, Target
from pathgene.sim.autopilot.wind import Wind
from tests.support.autopilot.station import ACCEPTED, HOME, at, connected


START, GO_AROUND, DENIED = 300, 191, 2


def flying(items, kind=Kind.ARDUPLANE, **options):
    station = connected(Autopilot(kind, Start(HOME), **options))
    home = [at(0, 0)] if kind is Kind.ARDUPLANE else []
    assert station.upload([*home, *items]) == ACCEPTED
    assert station.command(START) == 0
    return station, station.connection.autopilot


def fly_until(station, is_over, seconds=300):
    """Fly until a condition holds; return the places and altitudes on the way."""
    vehicle = station.connection.autopilot.pilot.vehicle
    flown = []
    for _ in range(10 * seconds):
        if is_over():
            return flown
        station.wait(0.1)
        flown.append((*vehicle.place, vehicle.altitude_m))
    raise AssertionError("it never happened")


def landing(abort_m=0.0):
    """Return an approach to the north: a circle, a level leg and a glide of 5 degrees."""
    return [
        at(0, 600, z=560, command=189, params=(0.0,) * 4),
        at(0, 600, z=560, command=31, params=(1.0, 90.0, 0.0, 0.0)),
        at(0, 1400, z=560),
        at(0, 2086, z=500, command=21, params=(abort_m, 0.0, 0.0, 0.0)),
    ]


# The slope of that glide.
GLIDE = 60 / 686


def on_final(north_m, altitude_m, *, ground_m_s=22.0, head_m_s=0.0, climb_m_s=0.0):
    """Return an aircraft that flies north, 500 m above the sea over flat ground."""
    earth = Earth(Plane(*HOME[:2]), 500.0, lambda _place: 500.0)
    motion = Motion((0.0, north_m), (0.0, ground_m_s), (0.0, 1.0))
    return Air(motion, altitude_m, climb_m_s, (0.0, -head_m_s), 22.0, 1.0, earth)


def final():
    """Return the law of a landing 1,000 m to the north and 60 m lower."""
    touch_down = Target((0.0, 1000.0), 500.0, Frame.AMSL, lands=True)
    parameters = Parameters(ARDUPLANE, SIMULATED_PLANE)
    return PlaneLanding(parameters, Target((0.0, 0.0), 560.0), touch_down)


def test_arduplane_aims_before_and_above_the_touch_down():
    """At 20 m/s over ground the sink rate is 1.2 m/s.

    The flare begins 2 s before the ground, at 2.4 m. It sinks at the mean of 1.2 and 0.25 m/s, so
    it takes 3.310 s, 66.2 m.
    """
    height, approach = final().update(on_final(500.0, 530.0, ground_m_s=20.0), 0.0, 530.0)
    assert height == pytest.approx(500 + 2.4 + (500 - 66.2) * (60 - 2.4) / (1000 - 66.2), abs=0.01)
    assert not approach.flares
    # The slope has no end at the touch-down.
    height, _ = final().update(on_final(980.0, 504.0, ground_m_s=20.0), 0.0, 530.0)
    assert height == pytest.approx(500 + 2.4 - 46.2 * (60 - 2.4) / (1000 - 66.2), abs=0.01)


@pytest.mark.parametrize(("head_m_s", "speed"), [(0.0, 16.0), (8.0, 20.0), (20.0, 22.0), (-8, 16)])
def test_arduplane_lands_between_minimum_and_cruise_and_faster_in_a_head_wind(head_m_s, speed):
    _, approach = final().update(on_final(500.0, 530.0, head_m_s=head_m_s), 0.0, 530.0)
    assert approach.eas_m_s == speed
    # Beside the leg and not yet halfway, it is no approach: the line of the leg at cruise speed.
    height, approach = final().update(on_final(100.0, 570.0), 50.0, 554.0)
    assert (height, approach.eas_m_s) == (554.0, 22.0)


@pytest.mark.parametrize(
    ("north_m", "above_m", "climb_m_s", "flares"),
    [
        (900.0, 3.1, 0.0, False),
        (900.0, 2.9, 0.0, True),
        (900.0, 5.0, -15.0, True),  # Two seconds above the ground; the sink rate is filtered.
        (999.0, 20.0, 0.0, False),
        (1001.0, 20.0, 0.0, True),  # After the touch-down, however high it is.
    ],
)
def test_arduplane_flares_by_height_time_and_place(north_m, above_m, climb_m_s, flares):
    air = on_final(north_m, 500.0 + above_m, climb_m_s=climb_m_s)
    _, approach = final().update(air, 0.0, 505.0)
    assert approach.flares == flares


WINDS = {"calm": (0.0, 0.0), "head": (0.0, -8.0), "cross": (8.0, 0.0)}


def landed(kind, wind, gusts_m_s=1.0, most_s=300):
    """Return the places and altitudes of a landing, and its last demands."""
    options = {"wind": Wind(*WINDS[wind], gusts_m_s=gusts_m_s, seed=3)}
    station, autopilot = flying(landing(), kind, **options)
    return fly_until(station, lambda: autopilot.pilot.mode is Mode.LANDED, most_s)


@pytest.mark.parametrize("wind", WINDS)
def test_arduplane_keeps_to_its_slope_and_touches_down_near_its_point(wind):
    """It flies below the straight line by no more than its aim, twice ``LAND_FLARE_ALT``.

    In the flare, of some 5 s, a bank of 5 degrees does not hold the line against gusts of 1 m/s.
    """
    flown = landed(Kind.ARDUPLANE, wind)
    above = [z - 500 - (2086 - y) * GLIDE for x, y, z in flown if 1800 < y < 2030 and z < 540]
    assert -6.0 < min(above) < max(above) < 3.0
    assert flown[-1][0] == pytest.approx(0, abs=6.0)
    assert flown[-1][1] == pytest.approx(2086, abs=50)


def test_arduplane_never_turns_back_after_its_touch_down(monkeypatch):
    """Too high at its point, it flies on; with its target at the point it turned around."""

    def steers(north_m):
        navigator = plane_navigator.PlaneNavigator(Parameters(ARDUPLANE, SIMULATED_PLANE))
        navigator.enter(on_final(0.0, 560.0))
        touch_down = Target((0.0, 1000.0), 500.0, Frame.AMSL, lands=True)
        navigator.set_next(touch_down, on_final(0.0, 560.0), None)
        step, _ = navigator.land(on_final(north_m, 520.0), 0.1)
        return step.steer_m_s2

    assert steers(1500.0) == pytest.approx(0.0, abs=1e-9)
    monkeypatch.setattr(plane_navigator, "_AHEAD_M", -600.0)
    assert abs(steers(1500.0)) > 1.0


def test_px4_flies_above_its_line_because_the_lag_is_not_compensated():
    flown = landed(Kind.PX4, "calm", gusts_m_s=0.0)
    above = [z - 500 - (2086 - y) * GLIDE for x, y, z in flown if 1900 < y < 2030 and z < 530]
    assert 3.0 < max(above) < 9.0
    assert flown[-1][0] == pytest.approx(0, abs=1.0)


def test_arduplane_goes_around_and_begins_the_approach_again():
    station, autopilot = flying(landing(abort_m=70.0))
    assert station.command(GO_AROUND) == DENIED  # It is not landing yet.
    vehicle = autopilot.pilot.vehicle
    fly_until(station, lambda: vehicle.altitude_m < 515)
    assert station.command(GO_AROUND) == 0
    climb = fly_until(station, lambda: autopilot.pilot.sequencer.command == 31)
    assert climb[-1][2] == pytest.approx(570, abs=6)
    assert max(abs(x) for x, *_ in climb) < 8  # Straight ahead.
    flown = fly_until(station, lambda: autopilot.pilot.mode is Mode.LANDED)
    assert math.dist(flown[-1][:2], (0, 2086)) < 25


@pytest.mark.ci
def test_px4_circles_over_the_landing_point_after_a_missed_approach():
    station, autopilot = flying(landing(), Kind.PX4)
    vehicle = autopilot.pilot.vehicle
    fly_until(station, lambda: vehicle.altitude_m < 515)
    assert station.command(GO_AROUND) == 0
    station.wait(90)
    assert vehicle.altitude_m == pytest.approx(530, abs=3)
    assert math.dist(vehicle.place, (0, 2086)) == pytest.approx(80, rel=0.15)


@pytest.mark.ci
@pytest.mark.parametrize("kind", Kind)
def test_a_return_of_the_mission_is_flown_at_the_return_height(kind):
    station = connected(Autopilot(kind, Start(HOME)))
    autopilot = station.connection.autopilot
    px4 = {"MIS_TKO_LAND_REQ": 0.0, "RTL_RETURN_ALT": 140.0}
    autopilot.parameters.update(px4 if kind is Kind.PX4 else {})
    home = [at(0, 0)] if kind is Kind.ARDUPLANE else []
    assert station.upload([*home, at(0, 800), at(0, 0, command=20, z=0.0)]) == ACCEPTED
    assert station.command(START) == 0
    fly_until(station, lambda: autopilot.pilot.mode is Mode.RTL)
    station.wait(120)
    height = {Kind.ARDUPLANE: 100.0, Kind.PX4: 140.0}[kind]
    assert autopilot.pilot.vehicle.altitude_m == pytest.approx(500 + height, abs=4)
    assert math.hypot(*autopilot.pilot.vehicle.place) < 130


def test_ardupilot_keeps_neither_heading_of_a_landing_nor_request_of_a_loiter():
    station, _ = flying(landing(abort_m=70.0))
    station.connection.autopilot.pilot.mode = Mode.IDLE
    *_, loiter, _, land = station.download()
    assert (loiter.param1, loiter.param2, loiter.param4) == (0, 90, 0)
    assert (land.param1, land.param4) == (70, 1)
