"""The evaluation of a path; the gateware's tests compare it with the evaluator of the chip."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.definition.score import score, walk
from pathgene.sim.model.planner.evaluation import NO_LIMIT
from tests.support.planner.cases import SMALL, USUAL, ground, headed, path, record
from tests.support.planner.plain import Evaluator


STEEPEST = (1 << 24) - 1


def evaluator_of(config, rng, memo, *, with_headings=False, **changes):
    problem = record(config, rng, **changes)
    if with_headings:
        problem = headed(config, rng, problem)
    return Evaluator(config, problem, ground(config, rng), memo)


def path_of(evaluator, rng):
    points = path(evaluator.config, rng)
    points[0], points[-1] = evaluator.ends
    return points


@pytest.mark.parametrize(
    ("memo", "with_headings"), [(0, False), (64, False), (64, True)], ids=["0", "64", "headings"]
)
@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_keys_are_those_of_the_plain_score_and_walk(config, memo, with_headings):
    """A path without a limit has its cost if it is valid, otherwise its penalty and all hits."""
    rng = np.random.default_rng(10)
    classes = set()
    for _ in range(15):
        evaluator = evaluator_of(
            config, rng, memo, climb=STEEPEST, descent=STEEPEST, radius=64,
            with_headings=with_headings,
        )  # fmt: skip
        for _ in range(30):
            points = path_of(evaluator, rng)
            scored = score(evaluator.record, points)
            chords = [arc.chord for arc in scored.arcs if arc is not None and arc.chord is not None]
            segments = [*itertools.pairwise(points), *chords]
            top = config.blocked_altitude
            hits = sum(walk(evaluator.ground, top, *each)[0] for each in segments)
            value = min(max(scored.cost >> evaluator.record.key_shift, 0), (1 << VALUE_BITS) - 1)
            penalty = min(scored.penalty + (hits << 10), (1 << VALUE_BITS) - 1)
            expected = PathClass.INFEASIBLE << VALUE_BITS | penalty if penalty else value
            key = evaluator.evaluate(points, [0] * len(points), NO_LIMIT, first=False)
            assert key == expected
            for limit in (value, value + 1, NO_LIMIT):
                key = evaluator.evaluate(points, [0] * len(points), limit, first=True)
                is_given_up = not scored.penalty and value >= limit
                assert (key >> VALUE_BITS == PathClass.GIVEN_UP) == is_given_up
                classes.add(key >> VALUE_BITS)
    assert classes >= {PathClass.GIVEN_UP, PathClass.INFEASIBLE}
    # On the larger map no random path is free.
    assert config is USUAL or PathClass.FEASIBLE in classes


def test_a_memo_changes_no_key_and_no_margin():
    rng = np.random.default_rng(11)
    with_memo = evaluator_of(USUAL, rng, 512)
    without = Evaluator(USUAL, with_memo.record, with_memo.ground, 0)
    paths = [path_of(with_memo, rng) for _ in range(12)]
    for _ in range(2):
        for points in paths:
            margins, expected = [0] * len(points), [0] * len(points)
            key = with_memo.evaluate(points, margins, NO_LIMIT, first=False)
            assert key == without.evaluate(points, expected, NO_LIMIT, first=False)
            assert margins == expected
    assert with_memo.walk < without.walk * 0.75


def test_a_walk_continues_after_a_collision():
    """Margins and memo are the same as after a full walk; the key has fewer hits."""
    rng = np.random.default_rng(12)
    evaluator = evaluator_of(SMALL, rng, 64, climb=STEEPEST, descent=STEEPEST, radius=64)
    evaluator.ground[:] = 0
    evaluator.ground[8, 8] = evaluator.ground[9, 20] = SMALL.blocked_altitude
    start, goal = evaluator.ends
    points = [start, (8, 8, 100), (9, 20, 100), (20, 20, 100), goal]
    margins, expected = [0, 7, 7, 7, 0], [0] * 5
    key = evaluator.evaluate(points, margins, NO_LIMIT, first=True)
    whole = evaluator.walk
    # Again, entirely from the memo: one cycle per segment.
    assert evaluator.evaluate(points, expected, NO_LIMIT, first=False) > key
    assert evaluator.walk - whole == 4
    assert margins == expected
