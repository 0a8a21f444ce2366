"""The evaluator: keys, margins and cycles equal its model's, also keys at the limits."""

import numpy as np
import pytest

from pathgene.hdl.planner.path_evaluator import KeyMaker, PathEvaluator
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.evaluator_cycles import PLACES
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.cases import SMALL, ground
from tests.support.planner.evaluator_bench import run
from tests.support.planner.evaluator_cases import (
    check_cycles,
    check_findings,
    drawn_evaluator,
    drawn_paths,
    outcomes,
)


TOP = (1 << VALUE_BITS) - 1
#: Walked, infeasible, value, hits: every kind of path, at both ends of the values.
PATHS = [
    (walked, infeasible, value, hits)
    for walked in (0, 1)
    for infeasible in (0, 1)
    for value in (0, 1, TOP - 1024, TOP - 1023, TOP)
    for hits in ((0, 1, 2, (1 << 20) - 1) if walked else (0,))
]


def key_of(walked, infeasible, value, hits):
    """The class and the value of a key."""
    if hits or (walked and infeasible):
        penalty = (value if infeasible else 0) + hits * 4 * 256
        return PathClass.INFEASIBLE << VALUE_BITS | min(penalty, TOP)
    if walked:
        return PathClass.FEASIBLE << VALUE_BITS | value
    return (PathClass.INFEASIBLE if infeasible else PathClass.GIVEN_UP) << VALUE_BITS | value


def keys_of(decided, walked):
    """Return keys, slots and lengths with their cycles, given when paths are decided and walked."""
    dut = shared(KeyMaker, slot_bits=8, length_bits=3, hits_bits=20)
    members, cycles = [], []

    async def bench(ctx):
        ctx.set(dut.evaluated.ready, 1)
        for cycle in range(max(*decided, *walked) + 20):
            number = decided.index(cycle) if cycle in decided else None
            ctx.set(dut.decision.valid, number is not None)
            if number is not None:
                names = ("walked", "infeasible", "value")
                path = {"head": {"slot": number}, "length": number % 8}
                fields = dict(zip(names, PATHS[number], strict=False))
                ctx.set(dut.decision, {"valid": 1, **fields, "path": path})
            number = walked.index(cycle) if cycle in walked else None
            ctx.set(dut.result.valid, number is not None)
            if number is not None:
                ctx.set(dut.result.hits, [path for path in PATHS if path[0]][number][-1])
            if ctx.get(dut.evaluated.valid):
                member = ctx.get(dut.evaluated.p)
                members.append((member.key, member.slot, member.length))
                cycles.append(cycle)
            await ctx.tick()

    simulate(dut, bench)
    return members, cycles


def test_keys():
    """Keys follow decisions and results after 3 cycles, or the previous key after one."""
    rng = np.random.default_rng(1)
    for gap in (6, 3, 1):
        decided = np.cumsum(rng.integers(gap, gap + 3, size=len(PATHS))).tolist()
        walked, at, cycles = [], 0, [0]
        for path, cycle in zip(PATHS, decided, strict=True):
            known = cycle
            if path[0]:
                at = max(at, cycle) + int(rng.integers(1, gap + 3))
                walked.append(at)
                known = at
            cycles.append(max(known + 3, cycles[-1] + 1))
        members, found = keys_of(decided, walked)
        expected = [(key_of(*path), i, i % 8) for i, path in enumerate(PATHS)]
        assert members == expected
        assert found == cycles[1:]


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


# The memo has no rows or 64; walks are short, or long with one lane. With such short paths, all
# places fill up in any case. The compiled test runs many more paths, also with the default sizes.
@pytest.mark.ci
@pytest.mark.parametrize(
    ("heading", "rows", "lanes"),
    [
        pytest.param(0, 64, 4, id="free", marks=pytest.mark.long),
        pytest.param(1, 0, 1, id="entry"),
        pytest.param(2, 0, 4, id="exit", marks=pytest.mark.long),
        pytest.param(3, 64, 1, id="both"),
    ],
)
def test_keys_margins_and_cycles(heading, rows, lanes):
    rng = np.random.default_rng(heading)
    config = SMALL.replace(
        lanes=lanes, memory_latency=1 + heading % 2, point_cycles=1 + heading // 2 % 2
    )
    late, keys = 0, set()
    for gaps in (False, True):
        evaluator, paths = case(config, rng, 40, heading, gaps=gaps)
        expected = outcomes(evaluator, rows, paths)
        found = run(shared(PathEvaluator, config, SLOTS, rows), evaluator, paths)
        assert check(found, expected) == 3
        late += check_cycles(evaluator, paths, found, expected)
        keys |= {each.key >> VALUE_BITS for each in expected}
        assert 5 < sum(each.costs is not None for each in expected) < 35
    assert keys == {PathClass.FEASIBLE, PathClass.GIVEN_UP, PathClass.INFEASIBLE}
    assert late > 0


@pytest.mark.ci
@pytest.mark.parametrize(
    "stalled",
    [*(pytest.param(one, marks=pytest.mark.long) for one in ((0,), (1,))), (0, 1)],
    ids=str,
)
def test_back_pressure(stalled):
    """Some of the streams of points and keys have pauses."""
    rng = np.random.default_rng(5)
    evaluator, paths = case(SMALL, rng, 40, len(stalled))
    expected = outcomes(evaluator, 64, paths)
    if 0 in stalled:
        for path in paths:
            path.gaps = tuple(rng.choice([0, 0, 1, 2, 15], 20).tolist())
    keys = rng.choice([0, 0, 1, 70], 200).tolist() if 1 in stalled else (0,)
    assert (
        check(run(shared(PathEvaluator, SMALL, SLOTS, 64), evaluator, paths, keys), expected) >= 3
    )


@pytest.mark.ci
@pytest.mark.parametrize("point_cycles", [1, 2])
def test_reset_discards_all_paths(point_cycles):
    """Paths that are inside when the reset comes do not leave a trace."""
    rng = np.random.default_rng(6)
    config = SMALL.replace(point_cycles=point_cycles)
    evaluator, paths = case(config, rng, 30, 3)
    expected = outcomes(evaluator, 64, paths)
    resets = (5, 90, 171, 172, 300)
    check(run(shared(PathEvaluator, config, SLOTS, 64), evaluator, paths, resets=resets), expected)


def test_places():
    assert PLACES == 16
