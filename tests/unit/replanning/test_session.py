"""Eventful flights in JSBSim; users of various projects have met each of these events."""

import dataclasses
import math
import os
import signal

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.flight import PERIOD_S
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.way import WayProblem
from pathgene.host.problem.zones import Circle
from pathgene.host.replanning import session as replanning_session
from pathgene.host.replanning.fly import underway
from pathgene.host.replanning.outcome import judge
from pathgene.host.replanning.planner import HOST_S, Attempt, InFlightPlanner, PlanningTime
from pathgene.host.replanning.scenario import Event, NewZone, Placed, Scenario
from pathgene.host.replanning.session import Session
from pathgene.host.replanning.tracks import is_smooth, pose_at, run_of
from pathgene.sim.board.scheme import start_simulated


def fly(mission, path, planner, *events, **options):
    """Fly; return the session, its outcome, and its messages."""
    said = []
    autopilot = options.pop("autopilot", "at-once")
    session = Session(
        mission, path, planner, Scenario(events, autopilot), say=said.append, **options
    )
    session.run()
    return session, judge(session), said


def test_without_events_the_path_is_flown(mission, straight, on_processor):
    session, outcome, said = fly(mission, straight, on_processor(0.1))
    assert (outcome.ended, outcome.kept, session.changes, said) == ("arrived", True, [], [])
    assert outcome.flight_time_s == pytest.approx(5000 / 23, rel=0.01)
    assert outcome.zone_distance_m == math.inf
    assert outcome.ready_share == 1.0


def test_a_zone_on_the_path_is_flown_around_by_the_chip(mission, straight, on_chip):
    zone = Circle(4000.0, 4500.0, 300.0)
    session, outcome, _ = fly(mission, straight, on_chip, Event(30.0, (NewZone(zone),)))
    assert outcome.kept
    (change,) = session.changes
    assert (change.needed, change.held, len(change.attempts)) == (True, False, 1)
    time = change.attempts[0][1].time
    # Events are looked at every 1/30 s.
    assert change.active_s == pytest.approx(time.total_s, abs=PERIOD_S)
    assert change.active_s >= time.total_s - 1e-9
    assert change.flown_m == pytest.approx(23 * change.active_s, rel=0.02)
    assert change.flown_m < 1.5
    flown = np.array(session.pilot.samples)
    nearest = np.hypot(flown[:, 1] - 4000, flown[:, 2] - 4500).min() - 300
    assert outcome.zone_distance_m == pytest.approx(nearest)
    assert outcome.zone_distance_m > 10
    assert [leg.kind for leg in session.pilot.legs] == ["path", "path"]


def test_a_goal_far_below_the_start_is_flown_to(mission, straight, on_chip):
    """The line to it burns no fuel, from either the mission's start or the aircraft."""
    goal = (2300.0, 4500.0, 170.0)
    session, outcome, _ = fly(mission, straight, on_chip, Event(15.0, goal=goal))
    assert (outcome.ended, outcome.kept) == ("arrived", True)
    (change,) = session.changes
    assert change.active_s is not None


def test_a_slow_planner_plans_from_where_the_aircraft_will_be(mission, straight, on_processor):
    zone = Circle(4500.0, 4500.0, 300.0)
    session, outcome, _ = fly(mission, straight, on_processor(2.0), Event(30.0, (NewZone(zone),)))
    assert outcome.kept
    (change,) = session.changes
    assert change.active_s == pytest.approx(2.0, abs=0.1)
    assert change.flown_m == pytest.approx(46, abs=3)
    # The new track leaves the old one ahead of the aircraft, without a sideways step.
    assert outcome.cross_track_max_m < 8


def test_the_fuel_that_is_left_counts(mission, straight, on_processor):
    session, _, _ = fly(mission, straight, on_processor(0.1))
    before, after = mission.aircraft, session.pilot.aircraft
    burnt = before.fuel_weight_N - after.fuel_weight_N
    assert burnt == pytest.approx(before.weight_N - after.weight_N)
    planned = Evaluator(mission, threads=1).evaluate(straight).fuel_N
    assert burnt == pytest.approx(planned, rel=0.1)
    session.pilot.burnt_N = 1e9
    assert 0 < session.pilot.aircraft.fuel_weight_N < 1e-3


def test_the_same_constants_give_the_same_flight(mission, straight, on_processor):
    event = Event(30.0, (NewZone(Circle(4500.0, 4500.0, 300.0)),))
    first, second = (
        fly(mission, straight, on_processor(0.5), event, gusts="light", seed=5)[0] for _ in range(2)
    )
    assert first.pilot.samples == second.pilot.samples


def test_a_zone_over_the_aircraft_is_left_the_shortest_way(mission, straight, on_chip):
    above = NewZone(Placed("aircraft", 350.0))
    session, outcome, said = fly(mission, straight, on_chip, Event(60.0, (above,)))
    assert outcome.kept
    assert any("way out" in text for text in said)
    assert session.changes[0].inside_m == pytest.approx(350, abs=1)
    assert "way-out" in [leg.kind for leg in session.pilot.legs]


def test_a_goal_that_is_covered_ends_on_a_circle_and_no_endless_attempts(
    mission, straight, on_chip
):
    session, outcome, said = fly(
        mission, straight, on_chip, Event(60.0, (NewZone(Placed("goal", 200.0)),))
    )
    assert (outcome.ended, outcome.alive, outcome.kept) == ("holding", True, False)
    assert len(session.changes[0].attempts) == 1
    assert sum("no new path" in text for text in said) <= 2
    assert outcome.zone_distance_m > 20
    assert "no path to the goal" in outcome.breaks[-1]


def test_a_goal_that_is_free_again_is_reached(mission, straight, on_chip):
    storm = NewZone(Placed("goal", 200.0), "storm")
    session, outcome, _ = fly(
        mission, straight, on_chip, Event(60.0, (storm,)), Event(260.0, gone=("storm",))
    )
    assert outcome.kept
    assert [leg.kind for leg in session.pilot.legs] == ["path", "holding", "path"]
    assert session.changes[0].held


def test_a_drifting_storm_a_new_goal_and_another_wind(mission, straight, on_chip):
    storm = NewZone(Circle(4500.0, 4900.0, 250.0), "storm", (0.0, -6.0))
    session, outcome, _ = fly(
        mission,
        straight,
        on_chip,
        Event(20.0, (storm,)),
        Event(70.0, goal=(6500.0, 5500.0, 260.0)),
        Event(100.0, wind=(0.0, 6.0)),
    )
    assert outcome.kept
    assert sum(change.needed for change in session.changes) >= 3
    end = session.pilot.samples[-1]
    assert math.hypot(end[1] - 6500, end[2] - 5500) < 30
    assert session.pilot.flight.state.east_m_s != pytest.approx(23, abs=0.2)


def test_a_board_that_dies_is_replaced_by_the_processor(mission, straight, on_processor):
    with open_board("model:?core=planner") as board:
        planner = InFlightPlanner("ga-chip", board=board)
        planner.prepare(Evaluator(mission, threads=1))
        session, outcome, said = fly(
            mission,
            straight,
            planner,
            Event(20.0, board_lost=True),
            Event(30.0, (NewZone(Circle(4500.0, 4500.0, 300.0)),)),
            fallback=on_processor(0.3),
        )
    assert outcome.kept
    assert any("astar plans in its place" in text for text in said)
    (change,) = session.changes
    assert [attempt.planner for _, attempt in change.attempts] == ["ga-chip", "astar"]
    assert change.active_s == pytest.approx(0.4, abs=0.15)


@pytest.mark.ci
def test_an_autopilot_that_finishes_its_leg_first(mission, on_processor):
    bend = np.array([mission.start, (4000.0, 5200.0, 250.0), mission.goal])
    event = Event(20.0, (NewZone(Circle(5500.0, 4700.0, 250.0)),))
    turns_off = {}
    for autopilot in ("at-once", "finishes-leg"):
        session, outcome, _ = fly(mission, bend, on_processor(0.1), event, autopilot=autopilot)
        assert outcome.kept
        points, others = (
            np.array(
                [pose_at(leg.track, at).point[:2] for at in np.arange(0.0, run_of(leg.track), 10.0)]
            )
            for leg in reversed(session.pilot.legs)
        )
        off = [np.hypot(*(others - point).T).min() > 6 for point in points]
        turns_off[autopilot] = points[off.index(True)][0]
    # Immediately: somewhat after x = 1,500 + 20 s of flight; otherwise where the first straight
    # line ends.
    assert 1900 < turns_off["at-once"] < 2600
    assert 3800 < turns_off["finishes-leg"] < 4500


def test_a_zone_that_does_not_concern_the_path_changes_nothing(mission, straight, on_chip):
    aside = Circle(4000.0, 7000.0, 300.0)
    session, outcome, _ = fly(mission, straight, on_chip, Event(30.0, (NewZone(aside),)))
    assert outcome.kept
    (change,) = session.changes
    assert not change.needed
    assert [leg.kind for leg in session.pilot.legs] == ["path"]


def test_the_flight_goes_back_where_a_zone_is_gone(mission, straight, on_chip):
    storm = NewZone(Circle(4500.0, 4500.0, 900.0), "storm")
    session, outcome, _ = fly(
        mission, straight, on_chip, Event(20.0, (storm,)), Event(40.0, gone=("storm",))
    )
    assert outcome.kept
    came, went = session.changes
    assert came.needed
    assert not went.needed
    assert went.active_s is not None
    assert outcome.flight_time_s < 1.1 * 5000 / 23


def test_a_path_into_a_zone_that_nobody_can_avoid_is_judged(mission, straight, on_processor):
    """The judge is independent of the pilot: a flight through a zone is noticed."""
    session = Session(mission, straight, on_processor(0.1), Scenario())
    while session.pilot.time_s < 100:
        session.step()
    session.airspace.happen(
        Event(100.0, (NewZone(Circle(5000.0, 4500.0, 200.0)),)), lambda on, ahead: (0.0, 0.0)
    )
    session.run()
    outcome = judge(session)
    assert not outcome.alive
    assert "enters the no-fly zone" in outcome.breaks[0]
    assert outcome.zone_distance_m < -100


def test_a_hill_on_the_way_is_seen(mission, on_processor):
    low = np.array([mission.start, (3000.0, 4500.0, 60.0), mission.goal])
    _, outcome, _ = fly(mission, low, on_processor(0.1))
    assert (outcome.ended, outcome.alive) == ("crashed", False)
    assert "under the ground" in outcome.breaks[0]


def test_missions_that_cannot_be_replanned_are_refused(mission, straight, on_processor):
    planner = on_processor(0.1)
    as_paper = dataclasses.replace(mission, rules=None)
    with pytest.raises(InputError, match="plan without --as-paper"):
        Session(as_paper, straight, planner, Scenario())
    way = WayProblem(
        mission.terrain,
        (mission.start, (4000.0, 4500.0, 250.0), mission.goal),
        aircraft=mission.aircraft,
        rules=Rules(),
    )
    with pytest.raises(InputError, match="via points"):
        Session(way, straight, planner, Scenario())
    with pytest.raises(InputError, match=r"off the map|outside"):
        Session(mission, straight, planner, Scenario((Event(1.0, goal=(-5.0, 0.0, 90.0)),)))
    with pytest.raises(InputError, match="not below the airspeed"):
        Session(mission, straight, planner, Scenario((Event(1.0, wind=(40.0, 0.0)),)))


def test_a_flight_without_path_and_circle_ends(mission, straight, on_processor, monkeypatch):
    planner = on_processor(0.01)
    nothing = Attempt(None, PlanningTime(host_s=0.01), planner.name, "There is none.")
    monkeypatch.setattr(planner, "attempt", lambda *_: nothing)
    monkeypatch.setattr(replanning_session, "holding_on", lambda *_: None)
    event = Event(30.0, (NewZone(Placed("aircraft", 150.0)),))
    session, outcome, _ = fly(mission, straight, planner, event)
    assert session.ended == "lost"
    assert session.pilot.time_s < 400
    kinds = [leg.kind for leg in session.pilot.legs]
    assert kinds[0] == "path"
    assert set(kinds[1:]) == {"way-out"}
    assert len(kinds) > 3
    assert not outcome.alive
    # It stays above the ground throughout.
    assert outcome.clearance_flown_m > 0


def test_a_path_that_does_not_begin_on_the_track_is_refused(
    mission, straight, on_processor, monkeypatch
):
    planner = on_processor(0.05)
    # From the start of the mission, which is far from the aircraft.
    plan = planner.prepare(Evaluator(mission, threads=1))
    elsewhere = Attempt(plan, PlanningTime(host_s=0.05), planner.name)
    monkeypatch.setattr(planner, "attempt", lambda *_: elsewhere)
    event = Event(30.0, (NewZone(Placed("path", 150.0, 900.0)),))
    session, outcome, said = fly(mission, straight, planner, event)
    assert any("turns too sharply where it begins" in each for each in said)
    assert outcome.ended == "holding"
    assert outcome.alive
    assert all(is_smooth(leg.track) for leg in session.pilot.legs)


def check_that_astar_takes_over(mission, path, planner, board, kill):
    """Fly with a board that ends after 20 s, and a zone that appears then."""
    said = []
    with underway(
        mission,
        path,
        Scenario(),
        planner=planner,
        board=board,
        seconds=HOST_S,
        say=said.append,
    ) as (session, report):
        while session.pilot.time_s < 20:
            session.step()
        kill(session)
        session.happen(Event(0.0, (NewZone(Circle(4500.0, 4500.0, 300.0)),)))
        session.run()
        flown = report()
    assert flown.outcome.kept
    assert any(text.endswith("astar plans in its place.") for text in said)
    (change,) = session.changes
    assert [attempt.planner for _, attempt in change.attempts] == [planner, "astar"]


@pytest.mark.parametrize("planner", ["ga-chip", "ga-fpga"])
def test_a_board_that_dies_unannounced_is_replaced_by_the_processor(
    mission, straight, planner, monkeypatch
):
    def fail(data):
        raise OSError("the cable is out")

    def kill(session):
        monkeypatch.setattr(session._planner.board.link._transport, "write", fail)

    check_that_astar_takes_over(mission, straight, planner, "model:", kill)


@pytest.mark.long  # The model's board, above, fails in the same way.
@pytest.mark.cosim
def test_a_killed_simulator_is_replaced_by_the_processor(mission, straight):
    with start_simulated("sim:?core=planner", pty=True, keep=True) as board:
        check_that_astar_takes_over(
            mission, straight, "ga-chip", board.url, lambda _: os.kill(board.pid, signal.SIGKILL)
        )
