"""The evaluation of a path: the compiled one against the definition."""

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.cycles import WALK, counters_vector
from pathgene.sim.model.planner.definition.evaluation import NO_LIMIT, Evaluator, key_of
from pathgene.sim.model.planner.definition.memo import Memo
from pathgene.sim.model.planner.evaluation import evaluate
from pathgene.sim.model.planner.memo import empty_memo
from pathgene.sim.model.planner.problem import problem_vector, sizes_vector
from pathgene.sim.model.planner.score import WORK_ROWS
from tests.support.planner.cases import SMALL, USUAL, ground, headed, path, record, rows


class Both:
    """The two evaluators, with a memo each, over one map."""

    def __init__(self, config, rng, memo, *, with_headings=False, **changes):
        self.config = config
        self.record = record(config, rng, **changes)
        if with_headings:
            self.record = headed(config, rng, self.record)
        self.ground = ground(config, rng)
        self.plain = Evaluator(config, self.record, self.ground, Memo(config, memo))
        self.memo = empty_memo(memo)
        self.counters = counters_vector()
        self.vector = problem_vector(config, self.record)
        self.sizes = sizes_vector(config, memo)
        # One for all paths, as in a run.
        self.work = np.full((WORK_ROWS, config.max_waypoints + 4), 1 << 40, dtype=np.int64)

    def path(self, rng):
        points = path(self.config, rng)
        points[0], points[-1] = self.plain.ends
        return points

    def evaluate(self, points, limit, *, first):
        """The key, after a check that both agree on it and on the margins."""
        margins = list(range(len(points)))
        compiled = rows(points, margins)
        key = self.plain.evaluate(points, margins, limit, first=first)
        assert key == evaluate(
            self.vector, self.sizes, self.ground, self.memo, self.counters, self.work,
            compiled, len(points), limit, first,
        )  # fmt: skip
        assert compiled[:, 3].tolist() == margins
        return key


@pytest.mark.parametrize(
    ("memo", "with_headings"), [(0, False), (64, False), (64, True)], ids=["0", "64", "headings"]
)
@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_compiled_evaluation_is_the_defined_one(config, memo, with_headings):
    rng = np.random.default_rng(10)
    classes = set()
    steepest = (1 << 24) - 1
    for _ in range(15):
        both = Both(
            config, rng, memo, climb=steepest, descent=steepest, radius=64,
            with_headings=with_headings,
        )  # fmt: skip
        for _ in range(30):
            points = both.path(rng)
            cost = both.evaluate(points, NO_LIMIT, first=False) & (1 << VALUE_BITS) - 1
            for limit in (cost, cost + 1, NO_LIMIT):
                classes.add(both.evaluate(points, limit, first=True) >> VALUE_BITS)
        assert both.counters[WALK] == both.plain.walk
    assert classes >= {PathClass.GIVEN_UP, PathClass.INFEASIBLE}
    # On the larger map no random path is free.
    assert config is USUAL or PathClass.FEASIBLE in classes


def test_a_memo_changes_no_key_and_no_margin():
    rng = np.random.default_rng(11)
    with_memo = Both(USUAL, rng, 512)
    without = Evaluator(USUAL, with_memo.record, with_memo.ground, Memo(USUAL, 0))
    paths = [with_memo.path(rng) for _ in range(20)]
    for _ in range(2):
        for points in paths:
            margins, expected = [0] * len(points), [0] * len(points)
            key = with_memo.plain.evaluate(points, margins, NO_LIMIT, first=False)
            assert key == without.evaluate(points, expected, NO_LIMIT, first=False)
            assert margins == expected
    assert with_memo.plain.walk < without.walk * 0.75


def test_keys_sort_by_class_then_value():
    greatest = (1 << VALUE_BITS) - 1
    keys = [
        key_of(PathClass.FEASIBLE, -5),
        key_of(PathClass.FEASIBLE, 1),
        key_of(PathClass.FEASIBLE, greatest + 9),
        key_of(PathClass.GIVEN_UP, 0),
        key_of(PathClass.INFEASIBLE, 0),
    ]
    assert keys == sorted(keys)
    assert keys[0] == 0
    assert keys[2] == greatest


def test_a_walk_continues_after_a_collision():
    """Its margins equal a whole walk's, and the memo knows all; the key has fewer hits."""
    rng = np.random.default_rng(12)
    steepest = (1 << 24) - 1
    both = Both(SMALL, rng, 64, climb=steepest, descent=steepest, radius=64)
    both.ground[:] = 0
    both.ground[8, 8] = both.ground[9, 20] = SMALL.blocked_altitude
    start, goal = both.plain.ends
    points = [start, (8, 8, 100), (9, 20, 100), (20, 20, 100), goal]
    margins, expected = [0, 7, 7, 7, 0], [0] * 5
    key = both.plain.evaluate(points, margins, NO_LIMIT, first=True)
    assert both.evaluate(points, NO_LIMIT, first=True) == key
    whole = both.plain.walk
    # Again, all of it from the memo: a cycle a segment.
    assert both.evaluate(points, NO_LIMIT, first=False) > key
    assert both.plain.walk - whole == 4
    both.plain.evaluate(points, expected, NO_LIMIT, first=False)
    assert margins == expected
    assert both.counters[WALK] > 0
