# amaranth: UnusedElaboratable=no
"""Marks of changed blocks, by hand and against the gateware's map of blocks."""

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.block_map import BlockMap
from pathgene.hdl.protocol.planner import BLOCKS
from pathgene.sim.model.planner.run_cycles import scanning
from pathgene.sim.model.run_commands import BlockMarks
from tests.support.gateware.streams import simulate


ALL = BLOCKS**2
LATENCY = 2


def corners(*pairs):
    x, y = np.array(pairs).T
    return x, y


def test_blocks_are_marked_once_until_they_are_scanned():
    marks = BlockMarks()
    marks.shift = 3
    assert [marks.scan(), marks.scan()] == [ALL, 0]
    marks.write(*corners((0, 0), (7, 7), (8, 7), (255, 255)))
    marks.write(np.arange(16, 24), np.arange(10)[:, None])
    assert [marks.scan(), marks.scan()] == [5, 0]


def test_corners_beyond_the_blocks_mark_none():
    marks = BlockMarks()
    marks.scan()
    marks.write(*corners((31, 32), (32, 31), (31, 31)))
    assert marks.scan() == 1


def test_another_size_of_blocks_marks_all():
    marks = BlockMarks()
    marks.scan()
    marks.shift = 1
    assert [marks.scan(), marks.scan()] == [ALL, 0]
    # Written with another size than the scans before and after it.
    marks.shift = 2
    marks.write(*corners((500, 500)))
    marks.shift = 1
    marks.write(*corners((0, 0)))
    assert [marks.scan(), marks.scan()] == [ALL, 0]
    # Not written in between.
    marks.shift = 2
    marks.shift = 1
    marks.write(np.zeros(0, dtype=int), np.zeros(0, dtype=int))
    assert marks.scan() == 0


@pytest.mark.parametrize("seed", range(3))
def test_the_gateware_scans_as_many(seed):
    rng = np.random.default_rng(seed)
    unit, marks = BlockMap(4, 7, 4, LATENCY), BlockMarks()
    steps = []
    for _ in range(12):
        shift = int(rng.choice([1, 2, 2]))
        span = int(rng.choice([4, 70, 128]))
        steps.append((shift, rng.integers(span, size=(int(rng.integers(4)), 2)).tolist()))

    async def bench(ctx):
        for shift, written in steps:
            ctx.set(unit.block_shift, shift)
            marks.shift = shift
            for x, y in written:
                ctx.set(unit.write, {"valid": 1, "x": x, "y": y})
                marks.write(*corners((x, y)))
                await ctx.tick()
            ctx.set(unit.write, {"valid": 0, "x": 0, "y": 0})
            if rng.integers(3) == 0:
                continue
            await ctx.tick().repeat(2)
            ctx.set(unit.launch, 1)
            await ctx.tick()
            ctx.set(unit.launch, 0)
            cycles = 0
            while ctx.get(unit.busy):
                await ctx.tick()
                cycles += 1
            assert cycles == scanning(marks.scan(), shift, 4, LATENCY), (shift, written)

    simulate(unit, bench)
