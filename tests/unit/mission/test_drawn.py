"""The mission that pictures and pages show: places that equal the export's."""

import numpy as np
import pytest

import pathgene
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.drawn import drawn_mission, mission_of_plan
from pathgene.host.mission.ending import Ending
from pathgene.host.problem.problem import Problem
from pathgene.host.report.handed_over import _with_arcs
from pathgene.host.terrain import Terrain


def land(crs="EPSG:32632", height_m=100.0):
    origin = None if crs is None else (4.9e5, 5.1e6)
    return Terrain("plain", np.full((81, 81), height_m), 50, 50, crs, origin)


def made(terrain, **ending):
    path = np.array([(800.0, 800.0, 250.0), (2000.0, 1500.0, 300.0), (3000.0, 3000.0, 250.0)])
    problem = Problem(terrain, path[0], path[-1])
    track = Evaluator(problem, threads=1).track(path)
    return problem, track, HandOver(ending=Ending(**({"kind": "loiter"} | ending)))


def test_items_circle_and_rally_points_lie_where_the_export_has_them():
    problem, track, wanted = made(land())
    plan = flight_plan(problem, track, wanted=wanted)
    mission = drawn_mission(problem, track, wanted)
    lat, lon = problem.terrain.to_geographic(mission.items[:, 0], mission.items[:, 1])
    placed = [item for item in plan.items if item.lat]
    assert lat == pytest.approx([item.lat for item in placed], abs=1e-8)
    assert lon == pytest.approx([item.lon for item in placed], abs=1e-8)
    assert mission.items[0] == pytest.approx((800, 800, 250), abs=0.1)
    (circle,) = mission.circles
    assert (circle.x_m, circle.y_m) == pytest.approx((3000, 3000))
    assert circle.disc_m >= 2 * circle.radius_m
    assert len(mission.rally) == len(plan.rally) > 0
    assert mission.rally[:, 2] == pytest.approx([plan.home[2] + z for _, _, z in plan.rally])


def test_a_landing_and_a_return_are_drawn_to_their_end():
    problem, track, wanted = made(land(), kind="land", land=(3000.0, 800.0, 180.0))
    landing = drawn_mission(problem, track, wanted)
    assert landing.way[0] == pytest.approx((3000, 3000, 250))
    assert landing.way[-1] == pytest.approx((3000, 800, 100), abs=0.1)
    assert len(landing.go_around) > 1
    assert len(landing.circles) == 2
    problem, track, wanted = made(land(), kind="rtl")
    back = drawn_mission(problem, track, wanted)
    assert back.way[-1][:2] == pytest.approx((800, 800), abs=0.1)
    assert back.circles == ()


def test_nothing_is_drawn_without_a_place_or_a_feasible_path():
    assert drawn_mission(*made(land(crs=None))) is None
    wall = np.where(np.arange(81)[:, None] == 40, 5000.0, np.full((81, 81), 100.0))
    high = Terrain("wall", wall, 50, 50, "EPSG:32632", (4.9e5, 5.1e6))
    shut = Problem(high, (800.0, 800.0, 250.0), (3000.0, 3500.0, 250.0))
    plan = pathgene.plan(shut, planner="astar", generations=1, fallback="none")
    assert not plan.evaluation.feasible
    assert mission_of_plan(plan) is None


def test_nothing_is_drawn_where_the_end_has_no_room():
    y, x = np.mgrid[:81, :81]
    pit = Terrain(
        "pit", np.where(np.hypot(x - 60, y - 60) <= 3, 100.0, 2000.0), 50, 50, "EPSG:32632",
        (4.9e5, 5.1e6),
    )  # fmt: skip
    path = np.array([(800.0, 800.0, 2100.0), (2500.0, 2500.0, 2100.0), (3000.0, 3000.0, 150.0)])
    problem = Problem(pit, path[0], path[-1])
    track = Evaluator(problem, threads=1).track(path)
    assert drawn_mission(problem, track) is None


def test_turns_begin_at_the_acceptance_radius_and_are_tangent_to_the_legs():
    corners = np.array([(0.0, 0.0, 100.0), (1000.0, 0.0, 200.0), (1000.0, 800.0, 280.0)])
    line = _with_arcs(corners, [10.0, 60.0, 10.0])
    assert line[[0, -1]] == pytest.approx(corners[[0, -1]])
    arc = line[1:-1]
    assert arc[0] == pytest.approx((940, 0, 194))
    assert arc[-1] == pytest.approx((1000, 60, 206))
    # A right angle: the centre is as far from both legs as the arc is from the corner.
    assert np.hypot(arc[:, 0] - 940, arc[:, 1] - 60) == pytest.approx(np.full(len(arc), 60))
    mirrored = _with_arcs(corners * (1, -1, 1), [10.0, 60.0, 10.0])
    assert mirrored == pytest.approx(line * (1, -1, 1))
    # Half of the shorter leg is the most, and a straight way has no arc.
    assert _with_arcs(corners, [10.0, 900.0, 10.0])[1] == pytest.approx((600, 0, 160))
    straight = _with_arcs(np.array([(0.0, 0, 0), (100, 0, 0), (300, 0, 0)]), [10.0] * 3)
    assert not straight[:, 1].any()
    assert len(_with_arcs(corners, [0.0] * 3)) == 3
