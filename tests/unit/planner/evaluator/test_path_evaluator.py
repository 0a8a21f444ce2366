# amaranth: UnusedElaboratable=no
"""The evaluator: keys and margins of its model, and the cycles of its model."""

import numpy as np
import pytest

from pathgene.hdl.planner.path_evaluator import PathEvaluator
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.evaluator_cycles import PLACES
from tests.support.planner.cases import SMALL, ground
from tests.support.planner.evaluator_bench import run
from tests.support.planner.evaluator_cases import (
    check_cycles,
    check_findings,
    drawn_evaluator,
    drawn_paths,
    outcomes,
)


SLOTS = 20


def check(found, expected):
    """Compare all that was found with the model; return the cycles from margins to keys."""
    assert found.idle == found.keyed[-1] + 1
    return check_findings(found, expected)


def case(config, rng, count, heading, **options):
    """Return an evaluator over some ground, and paths for it."""
    hills = ground(config, rng, blocked=0.002)
    low = np.where(hills == config.blocked_altitude, hills, hills // 2)
    evaluator = drawn_evaluator(config, rng, low, heading, radius=100)
    return evaluator, drawn_paths(evaluator, rng, count, SLOTS, **options)


# The memo has no rows or 64; walks are short, or long with one lane. With paths as short as these,
# all places fill up in any case. Many more paths, of the default sizes too, run compiled.
@pytest.mark.ci
@pytest.mark.parametrize(
    ("heading", "rows", "lanes"),
    [
        pytest.param(0, 64, 4, id="free", marks=pytest.mark.ci),
        pytest.param(1, 0, 1, id="entry", marks=pytest.mark.ci),
        pytest.param(2, 0, 4, id="exit", marks=pytest.mark.ci),
        pytest.param(3, 64, 1, id="both"),
    ],
)
def test_keys_margins_and_cycles(heading, rows, lanes):
    rng = np.random.default_rng(heading)
    config = SMALL.replace(lanes=lanes, memory_latency=1 + heading % 2)
    late, keys = 0, set()
    for gaps in (False, True):
        evaluator, paths = case(config, rng, 40, heading, gaps=gaps)
        expected = outcomes(evaluator, rows, paths)
        found = run(PathEvaluator(config, SLOTS, rows), evaluator, paths)
        assert check(found, expected) == 3
        late += check_cycles(evaluator, paths, found, expected)
        keys |= {each.key >> VALUE_BITS for each in expected}
        assert 5 < sum(each.costs is not None for each in expected) < 35
    assert keys == {PathClass.FEASIBLE, PathClass.GIVEN_UP, PathClass.INFEASIBLE}
    assert late > 0


@pytest.mark.ci
@pytest.mark.parametrize("stalled", [(0,), (1,), (0, 1)], ids=str)
def test_back_pressure(stalled):
    """With pauses in some of the streams: points, keys."""
    rng = np.random.default_rng(5)
    evaluator, paths = case(SMALL, rng, 40, len(stalled))
    expected = outcomes(evaluator, 64, paths)
    if 0 in stalled:
        for path in paths:
            path.gaps = tuple(rng.choice([0, 0, 1, 2, 15], 20).tolist())
    keys = rng.choice([0, 0, 1, 70], 200).tolist() if 1 in stalled else (0,)
    assert check(run(PathEvaluator(SMALL, SLOTS, 64), evaluator, paths, keys), expected) >= 3


@pytest.mark.ci
def test_reset_discards_all_paths():
    """Paths that are inside when the reset comes do not leave a trace."""
    rng = np.random.default_rng(6)
    evaluator, paths = case(SMALL, rng, 30, 3)
    expected = outcomes(evaluator, 64, paths)
    resets = (5, 90, 171, 172, 300)
    check(run(PathEvaluator(SMALL, SLOTS, 64), evaluator, paths, resets=resets), expected)


def test_places():
    assert PLACES == 16
