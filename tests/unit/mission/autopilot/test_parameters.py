"""Parameters of the simulated autopilots, and their meaning for missions over a ridge."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.formats.flight_plan import LAND_START
from pathgene.host.mission.autopilot.advice import WANTED, advise
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.parameters import read_parameters, set_parameters
from pathgene.host.mission.autopilot.upload import upload
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.link import Faults
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot_flight import (
    airframe_of,
    fly_items,
    give_mission,
    px4_parameters_of,
)
from tests.support.host.missions import flight_of


ARDUPILOT, PX4 = 3, 12
# A ridge from south to north at 4,000 m east, 600 m high, on a plain at 100 m.
RIDGE = Terrain(
    "ridge",
    np.tile(np.where(np.arange(101) == 50, 600.0, 100.0), (41, 1)),
    *(80.0, 80.0, "EPSG:32632", (4e5, 5.2e6)),
)
NUMBERS = {ARDUPILOT: Kind.ARDUPLANE, PX4: Kind.PX4}


@pytest.fixture(scope="module")
def mission():
    """Return a problem and a plan that crosses the ridge, with a zone and without rally points."""
    path = np.array([(400.0, 1600.0, 750.0), (7600.0, 1600.0, 750.0)])
    problem = Problem(RIDGE, path[0], path[-1], zones=(Circle(3000.0, 2800.0, 100.0),))
    return problem, replace(flight_of(problem, path, feasible=True), rally=())


def linked(kind, faults=None, **parameters):
    autopilot = Autopilot(kind, Start((46.0, 7.0, 100.0), armed=False))
    autopilot.parameters |= parameters
    connection = Connection(autopilot, faults, faults, seed=3)
    link = Link(connection, clock=connection.clock)
    link.find(10.0)
    return link, autopilot, connection


@pytest.mark.parametrize("number", [ARDUPILOT, PX4])
@pytest.mark.parametrize("faults", [Faults(), Faults(0.5, 0.1, 0.2)], ids=["clean", "lossy"])
def test_reads_the_parameters_of_both_kinds(number, faults):
    link, autopilot, connection = linked(NUMBERS[number], faults)
    begun_s = connection.now_s
    found = read_parameters(link, number, WANTED[number])
    assert found == {names[0]: autopilot.parameters[names[0]] for names in WANTED[number]}
    assert connection.now_s - begun_s < (1 if not faults.loss else 30)


def test_an_older_name_of_a_parameter_will_do():
    link, autopilot, _ = linked(Kind.ARDUPLANE)
    del autopilot.parameters["RTL_ALTITUDE"]
    autopilot.parameters["ALT_HOLD_RTL"] = 10_000.0
    found = read_parameters(link, ARDUPILOT, WANTED[ARDUPILOT])
    assert found["ALT_HOLD_RTL"] == 10_000
    assert "RTL_ALTITUDE" not in found


def test_an_autopilot_that_gives_no_parameters_is_said_so(mission):
    problem, plan = mission
    link, autopilot, _ = linked(Kind.ARDUPLANE)
    autopilot.parameters.clear()
    autopilot.parameters["WP_RADIUS"] = 1.0
    found = read_parameters(link, ARDUPILOT, WANTED[ARDUPILOT])
    assert found == {}
    (sentence,) = advise(plan, found, ARDUPILOT, problem).sentences
    assert sentence.startswith("The autopilot does not give its parameters, so its fences and its ")
    assert advise(plan, found, 0, problem).sentences == ()


@pytest.mark.parametrize("number", [ARDUPILOT, PX4])
def test_sets_parameters_and_reads_them_back(number):
    link, autopilot, _ = linked(NUMBERS[number])
    values = {ARDUPILOT: {"FENCE_ENABLE": 1.0, "RTL_ALTITUDE": 512.0}}.get(
        number, {"GF_ACTION": 3.0, "RTL_RETURN_ALT": 512.0}
    )
    assert set_parameters(link, number, values) == []
    assert {name: autopilot.parameters[name] for name in values} == values


def test_parameters_set_before_one_that_is_refused_get_their_values_back():
    link, autopilot, connection = linked(Kind.ARDUPLANE)
    before = dict(autopilot.parameters)
    connection.up.drops = lambda message: (
        message.get_type() == "PARAM_SET" and message.param_id == "RTL_ALTITUDE"
    )
    values = {"FENCE_ENABLE": 1.0, "RTL_ALTITUDE": 512.0}
    assert set_parameters(link, ARDUPILOT, values) == ["RTL_ALTITUDE"]
    assert autopilot.parameters == before
    assert set_parameters(link, ARDUPILOT, {"NO_SUCH": 1.0}) == ["NO_SUCH"]


def test_the_return_height_is_compared_with_the_ridge_between(mission):
    problem, plan = mission
    clearance_m = problem.rules.clearance_m
    found = {"RTL_ALTITUDE": 100.0, "FENCE_ENABLE": 1.0, "FENCE_TYPE": 4.0}
    advice = advise(plan, found, ARDUPILOT, problem)
    (sentence,) = advice.sentences
    # An even descent from beyond the ridge passes its top, which is nearer to home.
    will_do_m = advice.values["RTL_ALTITUDE"]
    home_x, top_m = 400.0, 600.0 + clearance_m - 100.0
    nearest_x = min(4080.0 + 200.0 * i for i in range(20))
    assert top_m - 150 < will_do_m <= top_m
    assert sentence == (
        f"Straight returns to home from km 0.0 to {sentence.split(' to ')[2].split()[0]} of the "
        f"mission need {will_do_m:g} m above home, and RTL_ALTITUDE is 100 m."
    )
    for x in np.arange(nearest_x, 7600.0, 50.0):
        share = (x - 4000.0) / (x - home_x)
        assert 650.0 + share * (will_do_m - 650.0) >= top_m - 3.0
    assert advise(plan, found | advice.values, ARDUPILOT, problem).sentences == ()
    centimetres = {"ALT_HOLD_RTL": 10_000.0, "FENCE_ENABLE": 1.0}
    older = advise(plan, centimetres, ARDUPILOT, problem)
    assert older.values == {"ALT_HOLD_RTL": 100 * will_do_m}
    assert older.sentences[0].endswith("and ALT_HOLD_RTL is 10000 cm.")


def test_px4_circles_up_first_and_keeps_a_higher_altitude(mission):
    problem, plan = mission
    found = {"RTL_RETURN_ALT": 60.0, "GF_ACTION": 3.0}
    assert advise(plan, found, PX4, problem).sentences == ()
    low = replace(
        plan, items=tuple(replace(item, alt_m=min(item.alt_m, 300.0)) for item in plan.items)
    )
    advice = advise(low, found, PX4, problem)
    top_m = 500.0 + problem.rules.clearance_m
    assert advice.values["RTL_RETURN_ALT"] == pytest.approx(top_m, abs=15)


def test_fences_do_nothing_until_they_are_enabled(mission):
    problem, plan = mission
    high = {"RTL_ALTITUDE": 700.0}
    advice = advise(plan, high | {"FENCE_ENABLE": 0.0, "FENCE_TYPE": 4.0}, ARDUPILOT, problem)
    assert advice.sentences == ("FENCE_ENABLE is 0, so the fences do nothing; 1 enables them.",)
    assert advice.values == {"FENCE_ENABLE": 1.0}
    advice = advise(plan, high | {"FENCE_ENABLE": 1.0, "FENCE_TYPE": 2.0}, ARDUPILOT, problem)
    assert advice.values == {"FENCE_TYPE": 6}
    limits = {"FENCE_ENABLE": 0.0, "FENCE_TYPE": 5.0, "FENCE_ALT_MAX": 100.0}
    advice = advise(plan, high | limits, ARDUPILOT, problem)
    assert "an enabled fence would break the mission off there." in advice.sentences[0]
    assert advice.values == {}
    advice = advise(plan, {"RTL_RETURN_ALT": 700.0, "GF_ACTION": 1.0}, PX4, problem)
    assert advice.values == {"GF_ACTION": 3}
    bare = replace(plan, fence=())
    assert advise(bare, high | {"FENCE_ENABLE": 0.0}, ARDUPILOT, problem).sentences == ()


def test_rally_points_beyond_their_limit_are_not_returned_to(mission):
    problem, plan = mission
    lat, lon, _ = plan.home
    with_rally = replace(plan, rally=((lat, lon, 700.0),))
    found = {"RTL_ALTITUDE": 100.0, "FENCE_ENABLE": 1.0}
    assert advise(with_rally, found, ARDUPILOT, problem).sentences == ()
    limited = advise(with_rally, found | {"RALLY_LIMIT_KM": 3.0}, ARDUPILOT, problem)
    assert limited.sentences[0].startswith("Straight returns to home from km 3.")
    low = replace(plan, rally=((lat, lon, 100.0),))
    (sentence,) = advise(low, found, ARDUPILOT, problem).sentences
    assert sentence.startswith("Straight returns from ")
    assert sentence.endswith(" through a zone or off the map, whatever the return height.")


def test_a_plan_file_has_no_terrain(mission):
    _, plan = mission
    found = {"RTL_ALTITUDE": 100.0, "FENCE_ENABLE": 1.0, "RTL_AUTOLAND": 1.0}
    first, second = advise(plan, found, ARDUPILOT, None).sentences
    assert first.startswith("A .plan file has no terrain, so the return height of the autopilot ")
    assert second.startswith("RTL_AUTOLAND is 1, but the mission has no landing, so after a ret")


@pytest.mark.parametrize(
    ("lands", "value", "said", "set_to"),
    [
        (True, 0, "so ArduPlane does not arm with a mission that lands; with 3 it arms, and", 3),
        (
            True,
            1,
            "so a return continues from home to the landing, on a straight way that is",
            None,
        ),
        (True, 2, "so a return flies straight to the landing instead of home, on a way that", None),
        (True, 3, None, None),
        (False, 0, None, None),
        (False, 2, "but the mission has no landing, so after a return the aircraft circles", None),
        (False, 3, None, None),
    ],
)
def test_returns_that_land_are_said(mission, lands, value, said, set_to):
    _, plan = mission
    if lands:
        marker = replace(plan.items[-1], command=LAND_START)
        plan = replace(plan, items=(*plan.items, marker))
    found = {"RTL_ALTITUDE": 100.0, "FENCE_ENABLE": 1.0, "RTL_AUTOLAND": float(value)}
    advice = advise(plan, found, ARDUPILOT, None)
    told = [text for text in advice.sentences if text.startswith(f"RTL_AUTOLAND is {value}, ")]
    assert len(told) == (said is not None)
    assert all(text.partition(", ")[2].startswith(said) for text in told)
    assert advice.values.get("RTL_AUTOLAND") == set_to


def test_the_advised_parameter_arms_an_arduplane_with_a_landing(mission):
    """Without it, the autopilot says why it does not arm, unless the command forces it."""
    problem, plan = mission
    plan = replace(plan, items=(*plan.items, replace(plan.items[-1], command=LAND_START)))
    link, autopilot, connection = linked(Kind.ARDUPLANE)
    upload(plan, link)

    def arms(force=0):
        autopilot.armed = False
        connection.mav.command_long_send(1, 1, 400, 0, 1, force, 0, 0, 0, 0, 0)
        said = connection.recv_match(type=["STATUSTEXT"], timeout=1.0)
        return autopilot.armed, said and said.text

    assert arms() == (False, "Arm: DO_LAND_START set and RTL_AUTOLAND disabled")
    assert arms(21196) == (True, None)
    autopilot.armed = False
    found = read_parameters(link, ARDUPILOT, WANTED[ARDUPILOT])
    set_parameters(link, ARDUPILOT, advise(plan, found, ARDUPILOT, problem).values)
    assert arms() == (True, None)


@pytest.fixture(scope="module")
def climb():
    """Return a problem and a plan that climbs 660 m in a straight line, by three slopes."""
    path = np.array([(400.0, 1600.0, 250.0), (1900.0, 1600.0, 500.0), (3400.0, 1600.0, 550.0)])
    path = np.vstack((path, (5600.0, 1600.0, 910.0), (7000.0, 1600.0, 910.0)))
    land = Terrain("plain", np.full((41, 101), 100.0), 80.0, 80.0, "EPSG:32632", (4e5, 5.2e6))
    problem = Problem(land, path[0], path[-1])
    return problem, flight_of(problem, path, feasible=True)


def test_an_autopilot_that_climbs_too_slowly_is_said(climb):
    """The mission climbs at 3.8 m/s, of which ArduPlane holds 0.75 in gusts."""
    _, plan = climb
    slow = advise(plan, {"TECS_CLMB_MAX": 4.0}, ARDUPILOT, None).sentences
    text = next(text for text in slow if text.startswith("TECS_CLMB_MAX is 4 m/s, of which it "))
    wanted = float(text.partition("; ")[2].partition(" m/s")[0])
    enough = advise(plan, {"TECS_CLMB_MAX": wanted}, ARDUPILOT, None).sentences
    assert not any(text.startswith("TECS_CLMB_MAX") for text in enough)
    for value, is_said in ((3.0, True), (wanted, False)):
        found = advise(plan, {"FW_T_CLMB_R_SP": value}, PX4, None).sentences
        assert any(text.startswith("FW_T_CLMB_R_SP is 3 m/s, and the") for text in found) is is_said


def test_waypoints_at_whose_height_px4_arrives_late_are_said(climb):
    """The simulated PX4 circles at them, and does not with the value that would do."""
    problem, plan = climb
    found = {"NAV_FW_ALT_RAD": 10.0, "FW_T_ALT_TC": 5.0, "RTL_RETURN_ALT": 990.0}
    advice = advise(plan, found, PX4, problem)
    assert advice.sentences == (
        "NAV_FW_ALT_RAD is 10 m, but the heights of this mission are flown up to 20 m late, and "
        "later in gusts, so the aircraft may circle at waypoints until it has their height; 55 m "
        "would do.",
    )
    assert advice.values == {"NAV_FW_ALT_RAD": 55.0}
    beside_m = [beside_line(problem, plan, radius) for radius in (10.0, 55.0)]
    assert beside_m[0] > 25
    assert beside_m[1] < 5
    assert advise(plan, found | advice.values, PX4, problem).sentences == ()


def test_the_height_at_which_an_approach_begins_keeps_its_tolerance(climb):
    problem, plan = climb
    landing = replace(plan, items=(*plan.items, replace(plan.items[-1], command=LAND_START)))
    found = {"NAV_FW_ALT_RAD": 10.0, "FW_T_ALT_TC": 5.0, "RTL_RETURN_ALT": 990.0}
    advice = advise(landing, found, PX4, problem)
    assert len(advice.sentences) == 1
    assert advice.values == {}


def beside_line(problem, plan, radius_m):
    """Return how far the simulated PX4 is beside the straight mission before its last circle."""
    first = plan.items[0]
    parameters = px4_parameters_of(problem.aircraft)
    parameters |= {"MIS_TKO_LAND_REQ": 0.0, "NAV_FW_ALT_RAD": radius_m}
    start = Start(plan.home, (0.0, 0.0), first.alt_m - plan.home[2], 90.0, armed=False)
    frame = airframe_of(problem.aircraft)
    autopilot = Autopilot(Kind.PX4, start, parameters=parameters, airframe=frame)
    give_mission(autopilot, plan)
    flown, arrived = fly_items(autopilot)
    assert arrived
    on_way = flown.place[flown.index < len(plan.items) - 1]
    plane = autopilot.earth.plane
    lat, lon = np.array([plane.degrees((east, north)) for east, north in on_way.tolist()]).T
    _, y = problem.terrain.to_local(lat, lon)
    return float(np.abs(y - 1600.0).max())


def test_a_fence_whose_breach_is_only_reported_is_said(mission):
    problem, plan = mission
    sentences = advise(
        plan, {"FENCE_ACTION": 0.0, "FENCE_ENABLE": 1.0}, ARDUPILOT, problem
    ).sentences
    assert "FENCE_ACTION is 0, so a breach of the fences is only reported." in sentences
    # Without a known return height, nothing is said of it.
    assert not any("return" in text for text in sentences)
