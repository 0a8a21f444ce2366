"""Replans on a board that is still open, on the software model."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import COARSE_BLOCKS
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip_map import drawn_corners
from pathgene.host.errors import InputError
from pathgene.host.planners.base import Options
from pathgene.host.planners.chip.ga_chip import ChipGeneticPlanner
from pathgene.host.planners.chip.problem_record import problem_record
from pathgene.host.planners.chip.replanner import replan_options
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.no_fly_shape import no_fly_shape
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone
from pathgene.sim.model.planner.run import plan as model_plan


#: In the gap of the ridge, and beyond it.
IN_THE_GAP = Zone.circle(3000, 3300, 250)
BEHIND = Zone.circle(4300, 2600, 300)
#: Across the whole map.
WALL = Zone.polygon([(3400, -100), (3600, -100), (3600, 4100), (3400, 4100)])
NO_MARGINS = Rules(clearance_m=0, corridor_m=0, zone_margin_m=0, reserve=0)


def model_of(board):
    return board.link._transport.chip


def runs_of(plan):
    return plan.result.hardware["runs"]


def middle(plan):
    """Return a point of the path, in the air."""
    return 0.5 * (plan.path[0] + plan.path[1])


@pytest.mark.parametrize(
    ("zones", "moves"),
    [((IN_THE_GAP,), True), ((BEHIND,), False), ((IN_THE_GAP, BEHIND), True), ((), True)],
)
def test_a_replan_goes_on_from_the_population(evaluator, board, search, zones, moves):
    before = search.run(evaluator)
    start = middle(before) if moves else None
    after = before.replan(zones=zones, start=start)
    assert after.evaluation.feasible
    assert after.fallback is None
    flight = after.evaluator.problem
    assert flight.zones == (*evaluator.problem.zones, *zones)
    assert after.path[0].tolist() == list(flight.start)
    assert flight.start == (tuple(start) if moves else evaluator.problem.start)
    assert all(run["warm"] for run in runs_of(after))
    assert after.result.hardware["cycles"]["total"] < 400_000
    # No map is sent over the line.
    assert sum(after.result.hardware["bytes"].values()) < 1_500 * len(runs_of(after))
    (run,) = runs_of(after)
    assert run["generations"] == replan_options(board.config, 0).generations


def test_the_paths_are_those_of_the_model(evaluator, board, search):
    before = search.run(evaluator)
    model = model_of(board)
    population = model.running.latest.population
    start = middle(before)
    after = before.replan(zones=[BEHIND], start=start)
    flight = changed_problem(evaluator.problem, [BEHIND], start)
    # The map has the disc and is exact around the ends.
    old, new = (CornerMap(board.config, each) for each in (evaluator.problem, flight))
    corners = old.corners((evaluator.problem.start, flight.goal))
    shape = no_fly_shape(old, BEHIND)
    rows = slice(shape.first_y, shape.last_y + 1)
    box = rows, slice(shape.first_x, shape.last_x + 1)
    corners[box][drawn_corners(shape)] = board.config.blocked_altitude
    around = old.around(flight.start)
    corners[around] = new.corners((flight.start, flight.goal))[around]
    assert np.array_equal(model.checking.terrain.heights, corners)
    record = problem_record(board.config, flight, new, COARSE_BLOCKS)
    outcome = model_plan(board.config, corners, record, replan_options(board.config, 3), population)
    assert runs_of(after)[0]["waypoints"] == [len(path) for path in outcome.paths]
    paths = [
        np.vstack((flight.start, old.corners_to_metres(np.array(path)), flight.goal)).tolist()
        for path in outcome.paths
    ]
    assert after.path.tolist() in paths


def test_a_replan_is_replanned_in_its_turn(evaluator, search):
    plan = search.run(evaluator)
    for number, start in enumerate([(900, 900, 220), (1400, 1500, 240), (1900, 2200, 260)]):
        zone = Zone.circle(3700 + 600 * number, 3000 - 700 * number, 150)
        plan = plan.replan(zones=[zone], start=start)
        assert plan.evaluation.feasible
        assert all(run["warm"] for run in runs_of(plan))
    assert len(plan.evaluator.problem.zones) == 4
    # A zone that the problem already has is not drawn again.
    again = plan.replan(zones=plan.evaluator.problem.zones)
    assert again.evaluator.problem.zones == plan.evaluator.problem.zones


@pytest.mark.parametrize(
    "zone",
    [
        # A dent, a hole, limits that can be flown over, and times.
        Zone.polygon(
            [(3600, 1800), (4600, 1800), (4600, 3800), (4300, 3800), (4300, 2100), (3600, 2100)]
        ),
        Zone.polygon(
            [(3600, 1800), (5000, 1800), (5000, 3400), (3600, 3400)],
            [[(3900, 2100), (4700, 2100), (4700, 3100), (3900, 3100)]],
        ),
        Zone.circle(4300, 2600, 400, upper_m=320),
        Zone.circle(4300, 2600, 400, t0_s=5, t1_s=60),
        # It does not meet any corner.
        Zone.circle(90_000, 2600, 400),
    ],
    ids=["dent", "hole", "heights", "times", "away"],
)
def test_what_is_no_disc_is_exact(make_evaluator, board, search, zone):
    evaluator = make_evaluator(rules=NO_MARGINS)
    before = search.run(evaluator)
    after = before.replan(zones=[zone])
    ends = evaluator.problem.start, evaluator.problem.goal
    exact = CornerMap(board.config, after.evaluator.problem).corners(ends)
    assert np.array_equal(model_of(board).checking.terrain.heights, exact)
    assert after.evaluation.feasible


def test_a_zone_that_is_not_active_at_the_passage_stays_open(make_evaluator, search):
    plan = search.run(make_evaluator(rules=NO_MARGINS))
    for times in ({"t1_s": 1.0}, {"t0_s": 3600.0}):
        plan = plan.replan(zones=[replace(WALL, **times), BEHIND], elapsed_s=10.0)
        assert plan.evaluation.feasible
        assert plan.fallback is None
        assert plan.result.hardware["searches"] == 1
        assert runs_of(plan)[0]["warm"]


def test_a_zone_that_is_active_at_the_passage_is_drawn_for_the_next_search(make_evaluator, search):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    x, y, _ = before.path[-2]
    active = Zone.circle(x, y, 400, t0_s=10.0, t1_s=900.0)
    after = before.replan(zones=[active, replace(WALL, t0_s=3600.0)])
    assert after.evaluation.feasible
    assert after.fallback is None
    assert not after.evaluator.entered(after.path)
    hardware = after.result.hardware
    assert hardware["searches"] == 2
    runs = hardware["runs"]
    assert len(runs) >= 2
    assert hardware["cycles"]["total"] == sum(run["cycles"] for run in runs)
    for way in ("to_board", "from_board"):
        assert hardware["bytes"][way] >= sum(run["bytes"][way] for run in runs)


def test_zones_that_are_gone_are_free_again(make_evaluator, board, search):
    evaluator = make_evaluator(rules=NO_MARGINS)
    storm, moved = (Zone.circle(x, 2600, 400) for x in (4300, 4600))
    plan = search.run(evaluator).replan(zones=[storm])
    heights = model_of(board).checking.terrain.heights
    ends = evaluator.problem.start, evaluator.problem.goal
    # The moved zone is drawn over the corners that have been freed.
    plan = plan.replan(zones=[moved], gone=[storm])
    plan.finish()
    assert plan.evaluator.problem.zones == (*evaluator.problem.zones, moved)
    exact = CornerMap(board.config, plan.evaluator.problem).corners(ends)
    shape = no_fly_shape(CornerMap(board.config, evaluator.problem), moved)
    box = slice(shape.first_y, shape.last_y + 1), slice(shape.first_x, shape.last_x + 1)
    exact[box][drawn_corners(shape)] = board.config.blocked_altitude
    assert np.array_equal(heights, exact)
    plan = plan.replan(gone=[moved])
    assert np.array_equal(heights, CornerMap(board.config, evaluator.problem).corners(ends))
    assert all(run["warm"] for run in runs_of(plan))
    with pytest.raises(InputError, match="none of the problem"):
        plan.replan(gone=[moved])


@pytest.mark.parametrize("is_finished", [True, False], ids=["finished", "at once"])
def test_a_zone_without_a_way_around_it_is_free_when_it_goes(
    make_evaluator, board, search, is_finished
):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    heights = model_of(board).checking.terrain.heights
    exact = heights.copy()
    vain = before.replan(zones=[WALL])
    assert not vain.result.evaluation.feasible
    assert not np.array_equal(heights, exact)
    if is_finished:
        vain.finish()
        assert np.array_equal(heights, exact)
    # It is drawn again while it remains.
    again = vain.replan()
    assert not again.result.evaluation.feasible
    assert (heights[:, 35] == board.config.blocked_altitude).sum() > 40
    if is_finished:
        again.finish()
    after = again.replan(gone=[WALL])
    assert after.evaluation.feasible
    assert [run["warm"] for run in runs_of(after)] == [True]
    assert np.array_equal(heights, exact)
    waits = runs_of(after)[0]["waits"]
    # Otherwise the corners of the whole wall are sent with PROBLEM and RUN.
    assert (waits["commands"] < waits["after_zones"] + 30) is is_finished


def test_a_second_replan_of_a_plan_continues_from_the_first(make_evaluator, board, search):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    heights = model_of(board).checking.terrain.heights
    first = before.replan(zones=[IN_THE_GAP])
    second = before.replan(zones=[BEHIND])
    assert all(run["warm"] for run in runs_of(second))
    assert second.evaluation.feasible
    assert second.evaluator.problem.zones == (*before.evaluator.problem.zones, BEHIND)
    # The zone of the first replan is gone.
    before.finish()
    exact = CornerMap(board.config, second.evaluator.problem)
    assert np.array_equal(heights, exact.corners(second.evaluator.problem.way))
    # So does a replan of each plan, until another plan has the chip.
    assert all(each.result.replanner.is_ready for each in (before, first, second))
    assert all(run["warm"] for run in runs_of(first.replan(zones=[IN_THE_GAP])))
    search.run(make_evaluator(rules=NO_MARGINS))
    assert not any(each.result.replanner.is_ready for each in (before, first, second))
    assert not any(run["warm"] for run in runs_of(before.replan())[:1])


def test_a_host_waits_twice_in_a_replan(make_evaluator, board, search):
    before = search.run(make_evaluator(rules=NO_MARGINS))
    exchanges = board.link.traffic.exchanges
    after = before.replan(zones=[IN_THE_GAP, BEHIND], start=middle(before))
    # For all commands up to RUN together, and for STATUS and the paths together.
    (run,) = runs_of(after)
    assert run["waits"]["exchanges"] == 2
    assert board.link.traffic.exchanges - exchanges == 2 + run["looks"]


def test_a_new_goal_and_another_wind_go_on_from_the_population(make_evaluator, search):
    plan = search.run(make_evaluator(rules=NO_MARGINS))
    goal = 0.5 * (plan.path[-1] + plan.path[-2])
    after = plan.replan(goal=goal, wind=(0, -6))
    assert after.evaluation.feasible
    assert after.path[-1].tolist() == goal.tolist()
    assert after.evaluator.problem.wind == (0.0, -6.0)
    assert all(run["warm"] for run in runs_of(after))


def test_a_heading_is_kept(make_evaluator, search):
    evaluator = make_evaluator(rules=NO_MARGINS)
    before = search.run(evaluator)
    way = before.path[1] - before.path[0]
    heading = float(np.degrees(np.arctan2(way[0], way[1])))
    after = before.replan(zones=[BEHIND], start=middle(before), heading=heading)
    assert after.evaluation.feasible
    assert after.evaluator.problem.start_heading_deg == pytest.approx(heading % 360)
    assert all(run["warm"] for run in runs_of(after))
    ahead = after.path[1] - after.path[0]
    assert ahead[0] * way[1] == pytest.approx(ahead[1] * way[0])
    # A new start without a heading has none; the same start keeps it.
    assert after.replan().evaluator.problem.start_heading_deg == pytest.approx(heading % 360)
    assert after.replan(start=middle(after)).evaluator.problem.start_heading_deg is None


def test_a_goal_that_stays_is_not_sent_again(make_evaluator, board, search):
    elevation = np.zeros((41, 61))
    # A wall around the goal, with a gate.
    elevation[6:9, 54:57] = 400
    elevation[7, 55] = elevation[6:8, 54] = 0
    evaluator = make_evaluator(elevation, zones=(), rules=NO_MARGINS)
    before = search.run(evaluator)
    assert runs_of(before)[-1]["ease"] == 2
    # Now the corners around both ends are lowered.
    problem = before.evaluator.problem
    grid = CornerMap(board.config, problem)
    ends = problem.start, problem.goal
    heights = model_of(board).checking.terrain.heights
    at_goal = grid.around(problem.goal)
    eased = heights[at_goal].copy()
    assert np.array_equal(eased, grid.corners(ends, 2)[at_goal])
    assert not np.array_equal(eased, grid.corners(ends)[at_goal])
    after = before.replan(start=(1500, 600, 210))
    assert after.evaluation.feasible
    assert np.array_equal(heights[at_goal], eased)
    # Once a zone has moved away from it, it is freed in time and lowered as before.
    storm, moved = (Zone.circle(x, problem.goal[1] + 500, 300) for x in (5500, 4600))
    beside = after.replan(zones=[storm])
    away = beside.replan(zones=[moved], gone=[storm])
    assert away.evaluation.feasible
    assert np.array_equal(heights[at_goal], eased)


def test_outside_the_box_a_replan_gets_a_map_of_its_own(make_evaluator, search):
    evaluator = make_evaluator(
        np.zeros((700, 40)), (), start=(500, 2_000, 150), goal=(3_400, 9_000, 150)
    )
    before = search.run(evaluator)
    assert before.result.hardware["map"]["offset_m"][1] == 50.0
    near = before.replan(start=(600, 2_500, 150))
    assert runs_of(near)[0]["warm"]
    far = near.replan(start=(600, 60_000, 150), goal=(3_400, 66_000, 150))
    assert far.evaluation.feasible
    assert far.fallback is None
    assert not runs_of(far)[0]["warm"]
    assert far.result.hardware["map"]["offset_m"][1] == 50.0 + 100 * (700 - 512)
    # The chip continues on the new map.
    zone = Zone.circle(2_000, 63_000, 600)
    around = far.replan(zones=[zone])
    assert around.evaluation.feasible
    assert runs_of(around)[0]["warm"]
    assert around.result.hardware["map"] == far.result.hardware["map"]


def test_another_planner_plans_anew(evaluator):
    before = Search("astar").run(evaluator)
    after = before.replan(zones=[BEHIND], start=middle(before))
    assert (after.planner, after.source) == ("astar", before.source)
    assert after.evaluation.feasible
    assert after.evaluator.problem.zones[-1] == BEHIND


def test_a_board_has_the_core_that_the_planner_needs(evaluator):
    with open_board("model:") as board:
        assert not board.config.planner_core
        before = Search("ga-chip", board=board, chip_ms=4).run(evaluator)
        assert before.board == "model:"
        after = before.replan(zones=[BEHIND])
        assert [run["warm"] for run in runs_of(after)] == [True]
        # The board itself still has the paper core.
        found = Search("ga-fpga", board=board, generations=2).run(evaluator)
        assert found.result.hardware["bytes"]["to_board"] > 0
        assert after.result.replanner.is_ready
    assert not after.result.replanner.is_ready


def test_an_open_board_that_lacks_the_core_is_refused(evaluator):
    with (
        open_board("model:?core=paper") as board,
        pytest.raises(InputError, match=r"^This board has no planner core, "),
    ):
        ChipGeneticPlanner(board=board).plan(evaluator, Options())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"zones": 3}, "The zones must be a list of no-fly zones, not 3."),
        ({"zones": [(1, 2, 3)]}, "The zones must be a list of no-fly zones, not [(1, 2, 3)]."),
        ({"start": (1, 2)}, "The start must be 3 finite numbers, not (1, 2)."),
        ({"start": "here"}, "The start must be 3 finite numbers, not 'here'."),
        (
            {"start": (900, -1, 200)},
            "The start at (900, -1) is outside the map, which reaches from (0, 0) to (6000, 4000) "
            "m.",
        ),
        (
            {"start": (3000, 500, 200)},
            "The start at an altitude of 200 m is inside the ground, which is at 600 m there; "
            "raise it, or give --agl if 200 m is its height above the ground.",
        ),
        (
            {"zones": [Zone.circle(600, 500, 200)]},
            "The start at (500, 500) is inside a no-fly zone; move it or the zone.",
        ),
        (
            {"heading": 90},
            "The evaluation of the papers knows no headings; leave the heading out.",
        ),
    ],
)
def test_wrong_uses(evaluator, search, arguments, sentence):
    before = search.run(evaluator)
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        before.replan(**arguments)
    # Nothing has reached the chip.
    assert before.replan(zones=[BEHIND]).result.hardware["runs"][0]["warm"]


def test_a_plan_from_elsewhere_is_refused(evaluator, search):
    made = search.run(evaluator)
    plan = Plan(evaluator, made.result, "ga-chip", None, 0, {})
    sentence = r"^Only a plan that a planner has made here can be replanned; "
    with pytest.raises(InputError, match=sentence):
        plan.replan()


def test_options_fit_the_chip(board):
    first = replan_options(board.config, (1 << 64) + 5)
    assert (first.seed, first.warm, first.paths, first.until_feasible) == (5, True, 4, True)
    again = replan_options(board.config, 5, 1)
    assert (again.seed, again.warm) == (6, False)
    # 1.4 and 2.8 ms at 100 MHz, and no surface twice.
    assert (first.cycles, again.cycles) == (144_000, 280_000)
    assert not set(first.slopes) & set(again.slopes)
    for options in (first, again):
        options.check(board.config)
    small = board.config.replace(
        population=8, children=4, elites=2, survivors=2, perturbs=1, inserts=1
    )
    assert replan_options(small, 0).give_up_rank == 7


def test_what_is_gone_beside_a_new_zone_is_set_free_behind_the_run(evaluator, board, search):
    heights = []

    def bytes_to_board(plan):
        return plan.result.hardware["bytes"]["to_board"]

    before = search.run(evaluator).replan(zones=[BEHIND])
    model = model_of(board)
    poll = board.runs.poll

    def noted():
        heights.append(model.checking.terrain.heights.copy())
        return poll()

    board.runs.poll = noted
    moved = Zone.circle(BEHIND.x_m + 60, BEHIND.y_m, BEHIND.radius_m)
    after = before.replan(zones=[moved], gone=[BEHIND])
    assert after.evaluation.feasible
    assert after.evaluator.problem.zones == (*evaluator.problem.zones, moved)
    (during,) = heights
    assert np.array_equal(model.checking.terrain.heights, during)
    after.finish()
    blocked = board.config.blocked_altitude
    box = CornerMap(board.config, evaluator.problem).around_zone(BEHIND)
    freed = (during == blocked) & (model.checking.terrain.heights != blocked)
    assert freed[box].any()
    freed[box] = False
    assert not freed.any()
    # In the end the chip has the same map as after an upload, except for the drawn discs.
    exact = CornerMap(board.config, after.evaluator.problem)
    shape = no_fly_shape(exact, moved)
    drawn = (slice(shape.first_y, shape.last_y + 1), slice(shape.first_x, shape.last_x + 1))
    corners = exact.corners((evaluator.problem.start, evaluator.problem.goal))
    corners[drawn][drawn_corners(shape)] = blocked
    assert np.array_equal(model.checking.terrain.heights[box], corners[box])
    # Only the new disc was sent over the line before the path was known.
    other = after.replan(zones=[Zone.circle(moved.x_m, moved.y_m + 10, moved.radius_m)])
    assert bytes_to_board(after) <= bytes_to_board(other) + 16
    # Unfinished uploads are sent with the next replan.
    back = other.replan(zones=[BEHIND], gone=[moved])
    last = back.replan(zones=[Zone.circle(1500, 3000, BEHIND.radius_m)])
    assert bytes_to_board(last) > bytes_to_board(other) + 10
