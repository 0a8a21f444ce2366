"""Flights of the simulated autopilot: items, modes, fences, rally points and parameters."""

import math

import pytest

from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.wind import Wind
from tests.support.autopilot.station import ACCEPTED, HOME, at, connected


START = 300


def flying(items, kind=Kind.ARDUPLANE, **options):
    """Return a station whose autopilot has begun a mission."""
    station = connected(Autopilot(kind, Start(HOME), **options))
    home = [at(0, 0)] if kind is Kind.ARDUPLANE else []
    assert station.upload([*home, *items]) == ACCEPTED
    assert station.command(START) == 0
    return station, station.connection.autopilot


def fly(autopilot, seconds, watch=lambda: None):
    """Fly without a link, and call ``watch`` ten times a second."""
    begun = autopilot.pilot.time_s
    while autopilot.pilot.time_s < begun + seconds:
        autopilot.pilot.tick()
        if (seen := watch()) is not None:
            return seen
    return None


def test_waypoints_are_reached_in_order_and_the_end_is_a_return():
    _, autopilot = flying([at(0, 500), at(500, 900), at(1200, 900)])
    assert fly(autopilot, 120, lambda: autopilot.pilot.mode is Mode.RTL or None)
    assert autopilot.reached == [1, 2, 3]
    fly(autopilot, 120)
    # The return circles over home, 100 m above it, with the radius of loiters.
    vehicle = autopilot.pilot.vehicle
    wide = 80 * vehicle.eas2tas**2
    assert math.hypot(*vehicle.place) == pytest.approx(wide, rel=0.15)
    assert vehicle.altitude_m == pytest.approx(HOME[2] + 100, abs=3)


def test_a_target_that_is_passed_already_is_flown_back_to():
    """The second waypoint lies 60 m south of the first."""
    _, autopilot = flying([at(0, 800), at(0, 740), at(0, 2000)])
    headings = []
    fly(autopilot, 60, lambda: headings.append(autopilot.pilot.vehicle.velocity[1]))
    assert autopilot.reached == [1, 2]
    assert min(headings) < -15
    assert max(headings[-50:]) > 20


@pytest.mark.parametrize("turns", [1, 2])
def test_loiters_last_as_long_as_asked(turns):
    _, autopilot = flying([at(0, 700, command=18, params=(turns, 0.0, 80.0, 0.0)), at(0, 3000)])
    pilot = autopilot.pilot
    begun = fly(autopilot, 60, lambda: pilot.time_s if pilot.navigator.is_on_circle else None)
    ended = fly(autopilot, 120, lambda: pilot.time_s if autopilot.reached else None)
    round_s = 2 * math.pi * 86 / 24
    # Up to one more round, until the aircraft points at the next waypoint.
    assert turns * round_s < ended - begun < (turns + 1.2) * round_s


def test_a_loiter_climbs_to_its_altitude_before_the_mission_continues():
    items = [at(0, 700, z=700, command=31, params=(0.0, 80.0, 0.0, 0.0)), at(0, 3000, z=700)]
    _, autopilot = flying(items)
    reached = fly(
        autopilot, 120, lambda: autopilot.pilot.vehicle.altitude_m if autopilot.reached else None
    )
    assert reached > 694


@pytest.mark.parametrize(("rise", "asked"), [(12.0, 612.0), (40.0, 620.0)])
def test_a_small_change_of_height_is_a_step_and_a_large_one_a_slope(rise, asked):
    _, autopilot = flying([at(0, 300), at(0, 1300, z=600 + rise)])
    pilot = autopilot.pilot
    half = fly(autopilot, 90, lambda: pilot.height_dem_m if pilot.vehicle.place[1] > 800 else None)
    assert half == pytest.approx(asked, abs=2)


@pytest.mark.parametrize(
    ("frame", "z", "altitude"), [(0, 600.0, 600.0), (3, 80.0, 580.0), (10, 90.0, 640.0)]
)
def test_altitudes_are_above_the_sea_home_or_the_ground(frame, z, altitude):
    options = {"ground": lambda _lat, _lon: 550.0}
    _, autopilot = flying([at(0, n * 500, z=z, frame=frame) for n in (1, 2, 3)], **options)
    seen = fly(
        autopilot,
        90,
        lambda: (
            autopilot.pilot.vehicle.altitude_m if autopilot.pilot.vehicle.place[1] > 1400 else None
        ),
    )
    assert seen == pytest.approx(altitude, abs=3)


def test_the_true_airspeed_grows_with_height():
    slow, fast = (Autopilot(Kind.ARDUPLANE, Start((46.0, 8.0, z))) for z in (0.0, 3000.0))
    ratio = fast.pilot.vehicle.eas2tas / slow.pilot.vehicle.eas2tas
    assert ratio == pytest.approx(1.16, abs=0.01)


def test_a_jump_repeats_a_part_of_the_mission():
    items = [
        at(0, 400),
        at(300, 400),
        at(0, 0, command=177, params=(1.0, 1.0, 0.0, 0.0)),
        at(600, 0),
    ]
    _, autopilot = flying(items)
    fly(autopilot, 150)
    assert autopilot.reached == [1, 2, 1, 2, 4]


def test_a_speed_of_the_mission_is_flown():
    items = [at(0, 300), at(0, 0, command=178, params=(0.0, 18.0, -1.0, 0.0)), at(0, 2500)]
    _, autopilot = flying(items)
    fly(autopilot, 70)
    vehicle = autopilot.pilot.vehicle
    assert vehicle.sensed_eas_m_s == pytest.approx(18, abs=0.8)


def test_a_take_off_climbs_on_its_course_before_the_mission_turns():
    start = Start(HOME, height_m=0.0, heading_deg=90.0)
    station = connected(Autopilot(Kind.ARDUPLANE, start))
    items = [at(0, 0, z=580, command=22, params=(12.0, 0.0, 0.0, 0.0)), at(0, 1500, z=600)]
    station.upload([at(0, 0), *items])
    station.command(START)
    autopilot = station.connection.autopilot
    vehicle = autopilot.pilot.vehicle
    place = fly(autopilot, 60, lambda: vehicle.place if autopilot.reached else None)
    assert place[0] > 100
    assert abs(place[1]) < 10
    assert vehicle.altitude_m == pytest.approx(580, abs=3)
    fly(autopilot, 20)
    assert vehicle.velocity[1] > 15


def test_a_landing_ends_on_the_ground():
    items = [at(0, 800, z=560), at(0, 1600, z=500, command=21)]
    station, autopilot = flying(items)
    fly(autopilot, 65)
    station.wait(20)
    assert autopilot.pilot.mode is Mode.LANDED
    assert not autopilot.armed
    assert "Landed" in station.texts
    assert autopilot.pilot.vehicle.place[1] == pytest.approx(1600, abs=120)


def test_a_new_fence_on_the_leg_breaks_the_flight_off():
    station, autopilot = flying([at(0, 6000)])
    station.wait(10)
    fence = [at(0, 1000, command=5004, params=(200.0, 0.0, 0.0, 0.0))]
    assert station.upload(fence, kind=1) == ACCEPTED
    station.wait(40)
    assert autopilot.pilot.mode is Mode.AUTO  # Fences do nothing until they are enabled.
    assert station.command(207, 1.0) == 0
    assert station.upload([at(0, 1900, command=5004, params=(300.0, 0.0, 0.0, 0.0))], kind=1) == 0
    station.wait(25)
    assert autopilot.pilot.mode is Mode.RTL
    assert "Fence breached" in station.texts


def test_px4_keeps_every_fence_and_holds():
    landing = at(0, 6000, z=500, command=21)
    station, autopilot = flying([at(0, 5000), landing], Kind.PX4)
    assert station.upload([at(0, 700, command=5004, params=(300.0, 0.0, 0.0, 0.0))], kind=1) == 0
    station.wait(40)
    assert autopilot.pilot.mode is Mode.IDLE


def test_the_nearest_rally_point_replaces_home():
    station, autopilot = flying([at(0, 4000)])
    rally = [
        at(400, 1500, z=90.0, command=5100, frame=3),
        at(0, -900, z=90.0, command=5100, frame=3),
    ]
    assert station.upload(rally, kind=2) == ACCEPTED
    station.wait(40)
    assert station.command(20) == 0
    target = autopilot.pilot.navigator.next
    assert target.place == pytest.approx((400, 1500), abs=1)
    assert target.altitude_m(autopilot.earth, target.place) == HOME[2] + 90


@pytest.mark.parametrize("last", [[], [at(0, 0, z=0.0, command=20)]], ids=["complete", "item"])
def test_the_end_of_a_mission_returns_to_the_nearest_rally_point(last):
    station, autopilot = flying([at(0, 900), *last])
    assert station.upload([at(400, 1500, z=90.0, command=5100, frame=3)], kind=2) == ACCEPTED
    station.wait(60)
    assert autopilot.pilot.mode is Mode.RTL
    assert autopilot.pilot.navigator.next.place == pytest.approx((400, 1500), abs=1)


def test_a_reposition_is_flown_at_once():
    station, autopilot = flying([at(0, 4000)])
    place = at(900, 300)
    station.connection.mav.command_int_send(
        1, 1, 0, 192, 0, 0, -1.0, 1.0, 60.0, math.nan, place.x, place.y, 650.0
    )
    station.wait(60)
    assert autopilot.pilot.mode is Mode.GUIDED
    assert math.dist(autopilot.pilot.vehicle.place, (900, 300)) < 120
    assert autopilot.pilot.vehicle.altitude_m == pytest.approx(650, abs=5)


def test_new_items_behind_the_present_one_are_flown():
    """The upload writes in place while the mission runs; the present leg is not disturbed."""
    station, autopilot = flying([at(0, 1500), at(0, 3000)])
    station.wait(5)
    assert station.upload([at(0, 0), at(0, 1500), at(1500, 1500)]) == ACCEPTED
    fly(autopilot, 130)
    assert autopilot.reached == [1, 2]


def test_another_mission_is_resumed_by_number_unless_its_first_item_is_chosen():
    """As after guided flight: the new mission has nothing to do with item 2 of the old one."""
    old = [at(0, 500), at(0, 5000)]
    new = [at(0, 0), at(600, 600), at(3000, -3000)]
    station, autopilot = flying(old)
    fly(autopilot, 30, lambda: autopilot.reached or None)
    assert station.command(176, 1.0, 15.0) == 0
    assert station.upload(new) == ACCEPTED
    assert autopilot.pilot.mode is Mode.GUIDED
    assert station.command(176, 1.0, 10.0) == 0
    assert autopilot.pilot.sequencer.index == 2

    assert station.command(176, 1.0, 15.0) == 0
    assert station.command(224, 1.0) == 0
    assert station.command(176, 1.0, 10.0) == 0
    assert autopilot.pilot.sequencer.index == 1


def test_a_cleared_mission_is_forgotten():
    station, autopilot = flying([at(0, 500), at(0, 5000)])
    fly(autopilot, 30, lambda: autopilot.reached or None)
    station.command(176, 1.0, 15.0)
    station.connection.mav.mission_clear_all_send(1, 1, 0)
    station.wait(0.5)
    assert station.acks[-1] == ACCEPTED
    assert autopilot.pilot.sequencer.index == 1
    assert station.command(START) == 2


def test_another_current_item_is_flown_to():
    station, autopilot = flying([at(0, 1500), at(0, 3000), at(2000, 0)])
    assert station.command(224, 3) == 0
    station.wait(1.5)
    assert autopilot.pilot.sequencer.index == 3
    assert station.command(224, 9) == 2


@pytest.mark.parametrize(("kind", "high_m"), [(Kind.ARDUPLANE, 100), (Kind.PX4, 300)])
def test_only_a_px4_keeps_its_altitude_above_the_return_height(kind, high_m):
    high = Autopilot(kind, Start(HOME, height_m=300.0)).pilot.home_target()
    assert high.z_m == pytest.approx(HOME[2] + high_m)
    low = Autopilot(kind, Start(HOME, height_m=20.0)).pilot.home_target()
    assert low.z_m == HOME[2] + {Kind.ARDUPLANE: 100, Kind.PX4: 60}[kind]


def test_parameters_are_read_and_set():
    station = connected(Autopilot(Kind.ARDUPLANE, Start(HOME)))
    assert station.parameter("ALT_SLOPE_MIN") == 15
    station.connection.mav.param_set_send(1, 1, b"RTL_ALTITUDE", 250.0, 9)
    station.wait(0.2)
    assert station.parameter("RTL_ALTITUDE") == 250
    assert station.connection.autopilot.pilot.home_target().z_m == HOME[2] + 250


def test_turbulence_is_the_same_for_the_same_seed():
    def end(seed):
        wind = Wind(5.0, -3.0, gusts_m_s=1.5, seed=seed)
        _, autopilot = flying([at(0, 3000)], wind=wind)
        fly(autopilot, 40)
        return autopilot.pilot.vehicle.place

    assert end(1) == end(1)
    assert end(1) != end(2)


def test_wind_drifts_no_leg():
    _, autopilot = flying([at(0, 400), at(0, 3000)], wind=Wind(8.0, 0.0))
    fly(autopilot, 80, lambda: autopilot.pilot.vehicle.place[1] > 2500 or None)
    assert abs(autopilot.pilot.vehicle.place[0]) < 3


def test_the_mission_has_states():
    station = connected(Autopilot(Kind.ARDUPLANE, Start(HOME)))
    station.wait(1.5)
    assert station.states[-1] == 1
    station.upload([at(0, 0), at(0, 500)])
    station.wait(1.5)
    assert station.states[-1] == 2
    station.command(START)
    station.wait(1.5)
    assert station.states[-1] == 3
    station.wait(40)
    assert station.states[-1] == 5


def test_px4_flies_its_legs_too():
    items = [at(0, 600), at(600, 1200), at(0, 1800), at(0, 2600, z=500, command=21)]
    _, autopilot = flying(items, Kind.PX4)
    fly(autopilot, 200, lambda: len(autopilot.reached) == 3 or None)
    assert autopilot.reached == [0, 1, 2]


def test_px4_does_not_widen_loiters():
    items = [at(0, 600, command=17, params=(0.0, 0.0, 90.0, 0.0)), at(0, 3000, z=500, command=21)]
    _, autopilot = flying(items, Kind.PX4)
    fly(autopilot, 150)
    assert math.dist(autopilot.pilot.vehicle.place, (0, 600)) == pytest.approx(90, rel=0.12)
