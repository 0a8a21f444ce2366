"""The evaluator: populations, threads, feasibility at two steps, clearance, bad arguments."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.kernels import WORST_FITNESS
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle


@pytest.fixture
def problem(make_problem):
    rng = np.random.default_rng(3)
    return make_problem(
        (0, 0, 400),
        (5000, 5000, 500),
        rng.uniform(0, 400, (51, 51)),
        zones=(Circle(2500, 2500, 300),),
    )


def population(problem, count, max_n=9):
    """Return random paths, with NaN in the rows beyond their lengths."""
    rng = np.random.default_rng(4)
    lengths = rng.integers(2, max_n + 1, count)
    paths = np.full((count, max_n, 3), np.nan)
    for path, n in zip(paths, lengths, strict=True):
        path[:n] = rng.uniform((0, 0, 300), (5000, 5000, 900), (n, 3))
        path[0], path[n - 1] = problem.start, problem.goal
    return paths, lengths


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("count", [1, 15, 200])
def test_population_equals_its_paths(problem, threads, count):
    evaluator = Evaluator(problem, threads=threads)
    paths, lengths = population(problem, count)
    single = [evaluator.evaluate(path[:n]) for path, n in zip(paths, lengths, strict=True)]
    assert evaluator.fitness(paths, lengths).tolist() == [terms.fitness for terms in single]
    penalty, cost = evaluator.penalty_cost(paths, lengths)
    assert penalty.tolist() == pytest.approx([terms.penalty for terms in single], rel=1e-14)
    assert cost.tolist() == [terms.cost for terms in single]
    fine, _ = evaluator.penalty_cost(paths, lengths, fine=True)
    assert fine.tolist() == pytest.approx([terms.penalty_fine for terms in single], rel=1e-14)


@pytest.mark.parametrize(
    "rules", [{}, {"ceiling_agl_m": 600.0}, {"ceiling_m": 560.0}, {"reserve": 0.995}]
)
def test_the_first_feasible_path_is_the_first_without_a_penalty(make_problem, rules):
    """It is found among paths that break each of the limits, in any order."""
    problem = make_problem(
        (500, 500, 400),
        (4500, 4500, 500),
        np.random.default_rng(3).uniform(0, 200, (51, 51)),
        zones=(Circle(2500, 2500, 300),),
        rules=Rules(clearance_m=40, **{"reserve": 0, **rules}),
    )
    evaluator = Evaluator(problem)
    rng = np.random.default_rng(5)
    lengths = rng.integers(3, 6, 4000)
    paths = np.zeros((4000, 5, 3))
    for path, n in zip(paths, lengths, strict=True):
        inner = np.sort(rng.uniform(600, 4400, (n - 2, 2)), axis=0)
        path[1 : n - 1] = np.column_stack((inner, rng.uniform(250, 700, n - 2)))
        path[0], path[n - 1] = problem.start, problem.goal
    # Paths of length 0: the ends are not checked.
    paths[5:9] = problem.start
    kept = np.flatnonzero(evaluator.fitness(paths, lengths, strict=True) > 1)
    assert 30 < len(kept) < 3000
    begin, found = 0, []
    while (first := evaluator.first_feasible(paths[begin:], lengths[begin:])) is not None:
        found.append(begin + first)
        begin += first + 1
    assert found == kept.tolist()


def test_as_paper_no_path_is_feasible_by_the_strict_rule(problem):
    with pytest.raises(ValueError, match="needs rules"):
        Evaluator(problem).first_feasible(*population(problem, 3))


def test_accepts_counted_distances(problem):
    evaluator = Evaluator(problem)
    paths, lengths = population(problem, 40)
    single = [evaluator.evaluate(path[:n]) for path, n in zip(paths, lengths, strict=True)]
    sampled = np.array(
        [terms.distance_under_terrain_m + terms.distance_in_nofly_m for terms in single]
    )
    assert np.count_nonzero(sampled) > 0
    np.testing.assert_allclose(
        evaluator.fitness_counted(paths, lengths, sampled),
        [terms.fitness for terms in single],
        rtol=1e-12,
    )
    others = [
        1 / (1 + terms.penalty - own) if terms.penalty > own else 1 + 1 / (1 + terms.cost)
        for terms, own in zip(single, sampled, strict=True)
    ]
    np.testing.assert_allclose(
        evaluator.fitness_counted(paths, lengths, np.zeros(40)), others, rtol=1e-9
    )
    with pytest.raises(ValueError, match="Counted distances must have shape"):
        evaluator.fitness_counted(paths, lengths, sampled[1:])


def test_accepts_populations_of_other_layouts_and_types(problem):
    evaluator = Evaluator(problem)
    paths, lengths = population(problem, 20)
    expected = evaluator.fitness(paths, lengths)
    np.testing.assert_array_equal(
        evaluator.fitness(np.asfortranarray(paths), lengths.astype(np.uint8)), expected
    )


def test_empty_population(problem):
    evaluator = Evaluator(problem)
    assert evaluator.fitness(np.empty((0, 5, 3)), np.empty(0, dtype=int)).shape == (0,)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_invalid_path_never_wins(problem, bad, axis):
    evaluator = Evaluator(problem)
    paths, lengths = population(problem, 40)
    lengths[:] = 5
    paths[:, :5] = np.nan_to_num(paths[:, :5], nan=400.0)
    paths[7, 3, axis] = bad
    fitness = evaluator.fitness(paths, lengths)
    assert fitness[7] == WORST_FITNESS
    assert (np.delete(fitness, 7) > WORST_FITNESS).all()
    penalty, cost = evaluator.penalty_cost(paths, lengths)
    assert (penalty[7], cost[7]) == (math.inf, math.inf)


def test_collapsed_paths_have_finite_fitness(problem):
    evaluator = Evaluator(problem)
    paths = np.array(
        [
            [problem.start] * 4 + [problem.goal],
            [problem.start] + [problem.goal] * 4,
            [problem.goal] * 5,
        ]
    )
    fitness = evaluator.fitness(paths, np.full(3, 5))
    assert ((fitness > 0) & (fitness < 1)).all()
    assert fitness[2] == WORST_FITNESS


def test_feasible_needs_both_steps(make_problem):
    # A peak 100 m wide lies between mid-points 250 m apart, but not between those 31.25 m apart.
    elevation = np.full((51, 51), 100.0)
    elevation[5, 10] = 350.0
    problem = make_problem((0, 500, 200), (2000, 500, 200), elevation, ds_m=250.0)
    terms = Evaluator(problem).evaluate(np.array([problem.start, problem.goal]))
    assert (terms.feasible_at_ds, terms.feasible) == (True, False)
    assert (terms.penalty, terms.fitness) == (0, 1.5)
    assert terms.penalty_fine == pytest.approx(100, abs=31.25)
    assert terms.minimum_clearance_m == -150
    above = make_problem((0, 500, 360), (2000, 500, 360), elevation, ds_m=250.0)
    terms = Evaluator(above).evaluate(np.array([above.start, above.goal]))
    assert (terms.feasible_at_ds, terms.feasible, terms.penalty_fine) == (True, True, 0)
    assert terms.minimum_clearance_m == 10


def test_feasible_at_ds_is_the_verdict_of_the_search_or_of_the_rule(make_problem):
    path = np.array([(500.0, 2500.0, 200.0), (4500.0, 2500.0, 200.0)])
    # The margin ends 5 m beside the track and meets the cells that the track crosses.
    for away_m, feasible in ((40.0, True), (30.0, False)):
        zone = Circle(2500.0, 2500.0 + away_m, 10.0)
        problem = make_problem(path[0], path[1], zones=[zone], rules=Rules())
        evaluator = Evaluator(problem, threads=1)
        assert evaluator.fitness(path[None], np.array([2]))[0] < 1
        found = evaluator.evaluate(path)
        assert (found.feasible, found.feasible_at_ds) == (feasible, feasible)


def test_clearance_counts_start_and_goal_and_no_void(make_problem):
    elevation = np.full((51, 51), 100.0)
    elevation[:, 10] = np.nan
    problem = make_problem((0, 500, 101), (2000, 500, 300), elevation)
    terms = Evaluator(problem).evaluate(np.array([problem.start, problem.goal]))
    assert terms.minimum_clearance_m == 1
    assert terms.void_crossed_m > 0


def test_terms_are_plain_json_values(problem):
    terms = Evaluator(problem).evaluate(np.array([problem.start, problem.goal])).to_dict()
    assert {type(value) for value in terms.values()} == {bool, float, int}
    assert list(terms)[:5] == ["feasible", "feasible_at_ds", "fitness", "penalty", "cost"]


def test_own_step_overrides_the_problems(problem):
    assert Evaluator(problem).ds_m == 50
    assert Evaluator(problem, ds_m=7).ds_m == 7


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"ds_m": 0}, r"^Sampling step must be a positive number of metres, not 0$"),
        ({"ds_m": math.nan}, r"^Sampling step must be a positive number of metres, not nan$"),
        ({"threads": 0}, r"^Thread count must be a positive integer, not 0$"),
        ({"threads": 1.5}, r"^Thread count must be a positive integer, not 1\.5$"),
    ],
)
def test_refuses_bad_options(problem, options, message):
    with pytest.raises(ValueError, match=message):
        Evaluator(problem, **options)


@pytest.mark.parametrize(
    ("paths", "lengths", "message"),
    [
        (np.zeros((5, 3)), np.full(5, 2), r"^Paths must have shape \(m, max_n, 3\), not \(5, 3\)$"),
        (np.zeros((5, 4, 3)), np.full(4, 2), r"^Lengths must have shape \(5,\), not \(4,\)$"),
        (np.zeros((2, 4, 3)), np.array([1, 3]), r"^Lengths must be 2 to 4, not 1 to 3$"),
        (np.zeros((2, 4, 3)), np.array([2, 5]), r"^Lengths must be 2 to 4, not 2 to 5$"),
    ],
)
def test_refuses_a_bad_population(problem, paths, lengths, message):
    with pytest.raises(ValueError, match=message):
        Evaluator(problem).fitness(paths, lengths)


@pytest.mark.parametrize("method", ["evaluate", "track"])
def test_refuses_a_bad_path(problem, method):
    call = getattr(Evaluator(problem), method)
    with pytest.raises(
        ValueError,
        match=r"^Path must have shape \(n, 3\) with n >= 2, "
        r"not \(1, 3\)$",
    ):
        call(np.zeros((1, 3)))
    with pytest.raises(
        ValueError,
        match=r"^Path must start at \(0\.0, 0\.0, 400\.0\), "
        r"not \(1\.0, 0\.0, 400\.0\)$",
    ):
        call(np.array([(1, 0, 400), problem.goal]))
    with pytest.raises(ValueError, match=r"^Path must end at \(5000\.0, 5000\.0, 500\.0\), not "):
        call(np.array([problem.start, (1, 0, 400)]))
    with pytest.raises(
        InputError,
        match=r"^The path has a coordinate that is not a number; correct "
        r"its file\.$",
    ):
        call(np.array([problem.start, (math.nan, 0, 400), problem.goal]))
    with pytest.raises(
        InputError,
        match=r"^The path has a coordinate beyond 10,000 km, which is "
        r"on no map; give it in metres of the terrain's local "
        r"frame\.$",
    ):
        call(np.array([problem.start, (0, 1e8, 400), problem.goal]))
    far = np.array([problem.start, (0, 9e6, 400), (9e6, 9e6, 400), problem.goal])
    call(far)
    problem = dataclasses.replace(problem, ds_m=10.0)
    with pytest.raises(
        InputError,
        match=r"^The path is 30,721 km long, of which a sampling step of 10 m makes more than "
        r"2,000,000 samples; correct the path, or increase the step to 17 m\.$",
    ):
        Evaluator(problem, threads=1).evaluate(far)


@pytest.mark.parametrize(
    ("start", "goal", "options", "message"),
    [
        (
            (100, 100, 1000),
            (900, 1400, 250),
            {},
            "The straight line from start to goal is so steep a glide that it burns no fuel, and "
            "costs are relative to it; raise the goal or lower the start.",
        ),
        (
            (100, 100, -50),
            (1400, 1400, -50),
            {"elevation": np.full((21, 31), -400.0)},
            "The straight line from start to goal has a mean altitude of -50 m, and costs are "
            "relative to it; shift the datum so that it is positive.",
        ),
        # 45 degrees up leave 16.3 m/s of horizontal airspeed.
        (
            (100, 100, 200),
            (1100, 100, 1200),
            {"wind": (0, 20)},
            "The straight line from start to goal cannot be flown in this wind, and costs are "
            "relative to it; reduce the wind or move start or goal.",
        ),
    ],
    ids=["glide", "below the datum", "wind"],
)
def test_refuses_ends_without_a_reference_cost(make_problem, start, goal, options, message):
    with pytest.raises(InputError) as caught:
        Evaluator(make_problem(start, goal, **options))
    assert str(caught.value) == message


def test_a_waypoint_very_near_the_start_is_above_it(make_problem):
    evaluator = Evaluator(make_problem((0, 0, 200), (3000, 3000, 200)))
    above, beside = (
        np.array([(0, 0, 200), (0, y, 300), (3000, 3000, 200)], dtype=np.float64)
        for y in (0.0, 2e-311)
    )
    assert evaluator.evaluate(beside) == evaluator.evaluate(above)
