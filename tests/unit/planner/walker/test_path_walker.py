"""The walker of paths compared with the evaluation of paths, including the chords of turns.

Cycles, and many paths: ``tests/cosim/test_path_walker.py``.
"""

import itertools

import numpy as np
import pytest

from pathgene.hdl.planner.walker.path_walker import PathWalker
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner.definition.score import score
from pathgene.sim.model.planner.evaluation import NO_LIMIT
from pathgene.sim.model.planner.evaluator_cycles import back, cost, walked
from tests.support.gateware.streams import put, shared, simulate
from tests.support.planner.cases import SMALL, corner, ground, path, segments_of, upload
from tests.support.planner.evaluator_cases import chords_of, drawn_evaluator


CONFIG = SMALL.replace(max_waypoints=4, map_size=16, altitude_bits=6)


def case(config, rng, number, heading):
    """A problem over some ground, and paths with their chords; gentle enough that most are walked.

    With a heading, 1 at the start and 2 at the goal, the problem has an entry or an exit.
    """
    terrain = ground(config, rng, blocked=0.03)
    evaluator = drawn_evaluator(config, rng, terrain, heading, radius=300)
    start, goal = evaluator.ends
    paths = []
    while len(paths) < number:
        points = [start, *path(config, rng)[1:-1], goal]
        scored = score(evaluator.record, points)
        first = bool(rng.integers(2))
        if scored.penalty == 0:
            paths.append((points, chords_of(evaluator.record, scored), first))
    return evaluator, paths


def run(rows, evaluator, paths, pauses=(0,)):
    """Return hits of the paths, and margins in the order in which they are given."""
    config = evaluator.config
    dut = shared(PathWalker, config, rows)
    assert dut.latency == back(config.lanes, config.memory_latency)
    hits, margins = [], []

    async def bench(ctx):
        await upload(ctx, dut, evaluator.ground)
        gaps = itertools.cycle(pauses)
        for start, stop, marks in itertools.chain(*(segments_of(*each) for each in paths)):
            for _ in range(next(gaps)):
                await ctx.tick()
            payload = {"start": corner(start), "stop": corner(stop), "identity": marks}
            await put(ctx, dut.segments, payload)
        await ctx.tick().repeat(dut.latency)
        while len(hits) < len(paths):
            await ctx.tick()

    async def watch(ctx):
        while True:
            *_, margin, result = await ctx.tick().sample(dut.margin, dut.result)
            if margin.valid:
                margins.append((margin.index, margin.margin))
            if result.valid:
                hits.append(result.hits)

    simulate(dut, bench, background=[watch])
    return hits, margins


def expected(evaluator, paths):
    """Return the same from the evaluation, with hits derived from the penalties."""
    hits, margins = [], []
    for points, _, first in paths:
        found = [0] * len(points)
        key = evaluator.evaluate(points, found, NO_LIMIT, first=first)
        infeasible = PathClass.INFEASIBLE << VALUE_BITS
        units = key - infeasible if key >= infeasible else 0
        assert units % 1024 == 0
        hits.append(units // 1024)
        margins += enumerate(found[1:-1])
    return hits, margins


@pytest.mark.parametrize("heading", range(4), ids=["free", "entry", "exit", "both"])
@pytest.mark.parametrize(("rows", "pauses"), [(0, (0,)), (64, (0, 3, 0, 0, 12)), (2, (0, 0, 5, 1))])
def test_hits_and_margins_of_the_evaluation(rows, pauses, heading):
    rng = np.random.default_rng(22)
    evaluator, paths = case(CONFIG, rng, 25, heading)
    paths += paths[::2]
    hits, margins = run(rows, evaluator, paths, pauses)
    assert (hits, margins) == expected(evaluator, paths)
    # Both kinds of chords, also at both ends, and both kinds of paths.
    places = slice(1, -1), *[slice(0, 1)] * (heading & 1), *[slice(-1, None)] * (heading >> 1)
    for place in places:
        chords = [chord is not None for _, some, _ in paths for chord in some[place]]
        assert any(chords)
        assert not all(chords)
    assert 0 in hits
    assert any(hits)


def test_cycles_of_a_lone_path():
    """They follow the model: a full walk, then from the memo, then only partly from the memo."""
    assert walked(7, 0, [3, 1]) == 16
    assert walked(7, 20, [3, 1]) == 24
    assert back(8, 2) == 15
    assert cost((0, 0, 5), (16, 9, 5), False, 8) == 3
    assert cost((0, 0, 5), (16, 9, 5), True, 8) == 1
    assert cost((3, 3, 5), (3, 3, 9), False, 8) == 1
