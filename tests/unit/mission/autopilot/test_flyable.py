"""Missions of few waypoints that keep the rules, flown by the simulated autopilot."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bench.exports import BESIDE_M, fly_export
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.geometry import Arc
from pathgene.host.formats.flight_plan import LOITER, WAYPOINT
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.flyable import flyable
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.planning import plan_mission
from pathgene.host.planning import Search
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain, load
from pathgene.sim.autopilot_flight import fly_items, give_mission, launched


PLAIN = Terrain("plain", np.zeros((61, 121)), 100.0, 100.0, "EPSG:32632", (5e5, 5e6))


def beside(problem, points):
    """Return the limits that legs and arcs through waypoints break."""
    path = np.array([(point.x_m, point.y_m, point.z_m) for point in points])
    return {each.limit for each in Evaluator(problem, threads=1).broken(path)}


@pytest.mark.parametrize("simplify_m", [1.0, 30.0])
def test_a_bend_around_a_zone_stays_and_the_same_bend_elsewhere_goes(simplify_m):
    """The strict rule judges the legs that a wide tolerance leaves."""
    bends = [(2000.0, 0.0), (3000.0, 20.0), (4000.0, 0.0), (6000.0, 0.0), (7000.0, 20.0)]
    path = np.array(
        [(500.0, 3000.0, 100.0)]
        + [(x, 3000.0 + y, 100.0) for x, y in (*bends, (8000.0, 0.0))]
        + [(9500.0, 3000.0, 100.0)]
    )
    problem = Problem(PLAIN, path[0], path[-1], zones=(Circle(3000.0, 2780.0, 210.0),))
    evaluator = Evaluator(problem, threads=1)
    assert evaluator.evaluate(path).feasible
    points = flyable(problem, evaluator.track(path), simplify_m)
    assert "zone 1" not in beside(problem, points)
    straight = [point for number, point in enumerate(points) if number in (0, len(points) - 1)]
    assert "zone 1" in beside(problem, straight)
    far = [point for point in points if 5000.0 < point.x_m < 8500.0]
    assert bool(far) == (simplify_m < 20.0)


def test_a_track_that_begins_before_its_start_keeps_its_waypoints():
    """It turns there from the heading of the start."""
    path = np.array([(900.0, 3000.0, 100.0), (3000.0, 3000.0, 100.0), (6000.0, 5000.0, 100.0)])
    problem = Problem(PLAIN, path[0], path[-1], start_heading_deg=80.0)
    track = Evaluator(problem, threads=1).track(path)
    assert math.dist(track.pieces[0].start, path[0]) > 10.0
    assert flyable(problem, track, 1.0) == flyable(problem, track, 0.0)


def test_zero_keeps_every_waypoint():
    path = np.array([(500.0 + 500.0 * n, 3000.0 + n % 2, 100.0) for n in range(12)])
    problem = Problem(PLAIN, path[0], path[-1])
    track = Evaluator(problem, threads=1).track(path)
    assert len(flyable(problem, track, 0.0)) > len(flyable(problem, track, 1.0)) >= 2


def test_turns_begin_while_the_aircraft_still_rolls(monkeypatch):
    """Without the time of the roll, a light aircraft flies a long turn wide."""
    path = np.array([(1000.0, 1000.0, 400.0), (6000.0, 1000.0, 400.0), (6000.0, 5000.0, 400.0)])
    problem = Problem(PLAIN, path[0], path[-1], aircraft=load_aircraft("j3cub"))
    beside_m = fly_export(problem, path).beside_m
    monkeypatch.setattr("pathgene.host.mission.autopilot.flyable._ROLL_S", 0.0)
    assert fly_export(problem, path).beside_m > beside_m + 2.0


def test_small_descents_keep_the_clearance_in_flight():
    """ArduPlane flies each leg as a step, down at its beginning."""
    x = np.arange(121) * 100.0
    heights = np.repeat(1000.0 - 0.03 * x[None, :], 61, axis=0)
    land = Terrain("slope", heights, 100.0, 100.0, "EPSG:32632", (5e5, 5e6))
    at = np.linspace(500.0, 11_500.0, 24)
    path = np.array([(x, 3000.0 + 60.0 * (n % 2), 1031.5 - 0.03 * x) for n, x in enumerate(at)])
    problem = Problem(land, path[0], path[-1])
    outcome = fly_export(problem, path)
    assert outcome.arrived
    assert outcome.share > 0.9


@pytest.mark.ci
def test_a_mission_of_46_km_has_at_most_60_items_and_is_flown_as_planned():
    """A via point, a return and two zones on a real map; the simulated ArduPlane flies it."""
    terrain = load("jacksboro")
    ends = [(4385.0, 6180.0), (16_962.0, 9198.0), (15_704.0, 21_775.0)]
    start, via, goal = ((x, y, float(terrain.ground(x, y)) + 100.0) for x, y in ends)
    zones = (Circle(16_333.0, 15_486.0, 700.0), Circle(8913.0, 12_418.0, 900.0))
    mission = MissionProblem(
        Problem(terrain, start, goal, zones=zones), [via], return_to_start=True
    )
    plan = plan_mission(mission, Search("astar", generations=1, fallback="astar"))
    problem, track = mission.whole, plan.evaluator.track(plan.path)
    assert plan.evaluation.feasible
    assert 45_000 < track.length_m < 48_000
    exported = flight_plan(problem, track, feasible=True)
    assert len(exported.items) <= 60
    assert exported.items[-1].command == LOITER
    whole = flight_plan(problem, track, wanted=HandOver(simplify_m=0.0))
    assert len(whole.items) > len(exported.items) + 15

    autopilot = launched(problem, exported)
    give_mission(autopilot, exported)
    flown, arrived = fly_items(autopilot)
    assert arrived
    east, north = flown.place[(flown.index > 1) & (flown.index <= number_of(problem, exported))].T
    plane = autopilot.earth.plane
    places = [plane.degrees(place) for place in zip(east.tolist(), north.tolist(), strict=True)]
    x, y = problem.terrain.to_local(*np.array(places).T)
    away, in_turn = beside_track(track, x, y)
    assert away[~in_turn].max() < 5.0
    assert away[in_turn].max() < BESIDE_M
    assert 0.05 < in_turn.mean() < 0.6


def number_of(problem, plan):
    """Return the number of the goal's item, home counted as ArduPilot does."""
    x, y, _ = problem.goal
    away = [
        math.dist(np.ravel(problem.terrain.to_local(item.lat, item.lon)), (x, y))
        if item.command == WAYPOINT
        else math.inf
        for item in plan.items
    ]
    return len(away) - int(np.argmin(away[::-1]))


def beside_track(track, x, y):
    """Return the distances of places from a track, and whether it turns there.

    A turn counts from 100 m before its arc, because an autopilot begins it early, to 200 m after.
    """
    samples = track.sample(1.0)
    turns = np.zeros(len(samples.s), bool)
    flown = 0.0
    for piece in track.pieces:
        if isinstance(piece, Arc):
            turns |= (samples.s > flown - 100) & (samples.s < flown + piece.length_m + 200)
        flown += piece.length_m
    away, nearest = cKDTree(np.column_stack((samples.x, samples.y))).query(np.column_stack((x, y)))
    return away, turns[nearest]
