"""The flight of a late autopilot, and missions that climb too late for one."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.late import (
    LateClimbError,
    check_climbs,
    late_heights,
    lowest,
)
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.export import exported_with_room
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


TAIL_WIND, CALM = (8.0, 0.0), (0.0, 0.0)
# Slope of the land: 0.98 of the Cessna's climb in the tail wind.
SLOPE, FOOT_M, TOP_M, Y_M = 0.0587, 1000.0, 7000.0, 3000.0
HEIGHT_M = SLOPE * (TOP_M - FOOT_M)


def make(wind, start_m=40.0):
    """Return a problem over a long slope, and a feasible path up it."""
    along = np.arange(121) * 100.0
    land = np.tile(SLOPE * np.clip(along - FOOT_M, 0.0, TOP_M - FOOT_M), (61, 1))
    terrain = at_origin(Terrain("slope", land, 100.0, 100.0), 46.0, 8.0)
    start, goal = (500.0, Y_M, start_m), (10_500.0, Y_M, HEIGHT_M + 90.0)
    problem = Problem(terrain, start, goal, aircraft.load("c172p"), wind=wind)
    path = np.array([start, (TOP_M, Y_M, HEIGHT_M + 40.0), goal])
    assert Evaluator(problem, threads=1).evaluate(path).feasible
    return problem, path


def plan_of(problem, path, feasible):
    return flight_plan(problem, Evaluator(problem, threads=1).track(path), feasible=feasible)


def test_late_heights_follow_a_ramp_by_the_lag_and_no_faster_than_the_rate():
    at_s = np.arange(0.0, 200.0, 0.25)
    times, heights = np.array([0.0, 20.0, 120.0, 200.0]), np.array([100.0, 100.0, 400.0, 400.0])
    asked = np.interp(at_s, times, heights)
    late = late_heights(times, heights, at_s, 3.0, 4.0)
    ramp = (at_s > 50) & (at_s < 119)
    assert (asked - late)[ramp] == pytest.approx(np.full(ramp.sum(), 9.0), abs=0.5)
    weak = late_heights(times, heights, at_s, 3.0, 2.0)
    assert weak[at_s == 110][0] == pytest.approx(100 + 2.0 * (90 - 3), abs=1.0)
    assert late_heights(times, heights, at_s, 0.0, 4.0) == pytest.approx(asked)


def test_small_descents_are_flown_as_steps():
    at_s = np.arange(0.0, 100.0, 0.25)
    for rise, expected in ((-14.0, 286.0), (-16.0, 300.0 - 16.0 * 0.3), (14.0, 300 + 14 * 0.3)):
        late = late_heights(np.array([0.0, 100.0]), np.array([300.0, 300.0 + rise]), at_s, 0.0, 9.0)
        assert late[120] == pytest.approx(expected, abs=0.1)


def test_a_climb_at_the_limit_in_a_tail_wind_has_no_flight_plan():
    problem, path = make(TAIL_WIND)
    with pytest.raises(
        LateClimbError,
        match=r"^An autopilot that climbs late flies \d+ m (over|below) the ground at x \d+ m, y "
        r"3000 m, where 30 m over it are required, because it follows the heights 3 s "
        r"late and holds less than the steepest climb in gusts; start (\d+) m higher, or plan a "
        r"way with more room to climb\.$",
    ) as caught:
        plan_of(problem, path, True)
    # Without a verdict on the path, or with a bad one, a file may be made for inspection.
    assert plan_of(problem, path, False).items
    # The sentence says how to mend it.
    higher, path = make(TAIL_WIND, 40.0 + caught.value.raise_m)
    assert plan_of(higher, path, True).items


def test_the_same_climb_is_kept_in_calm_air_and_without_rules():
    problem, path = make(CALM)
    assert plan_of(problem, path, True).items
    problem, path = make(TAIL_WIND)
    points = [RoutePoint(x, y, 0.0, 10) for x, y, _ in path.tolist()]
    assert lowest(problem, points).missing_m > 300
    free = replace(problem, rules=None, as_paper=True)
    assert lowest(free, points) is None
    check_climbs(free, points)


def test_the_ground_beside_the_legs_counts():
    problem, path = make(CALM)
    points = [RoutePoint(*place, 10) for place in path.tolist()]
    land = problem.terrain.elevation.copy()
    land[31, 60:64] += 400.0
    beside = replace(problem, terrain=replace(problem.terrain, elevation=land))
    assert lowest(beside, points).missing_m > lowest(problem, points).missing_m + 20


def test_a_run_keeps_its_other_files():
    problem, path = make(TAIL_WIND)
    files, missing = exported_with_room(
        problem, path, ["plan", "kml"], lambda _: None, feasible=True
    )
    assert missing.startswith("An autopilot that climbs late flies ")
    assert missing.endswith("; path.plan is not written.")
    assert set(files) == {"path.kml"}
