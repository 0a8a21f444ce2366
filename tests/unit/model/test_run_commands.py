"""Marks of changed blocks, computed by hand and by the gateware, and shapes that are blocked."""

import dataclasses
import itertools

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.block_map import BlockMap
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, NoFlyShape
from pathgene.hdl.protocol.runs import RunOptions, guide_request
from pathgene.sim.model.check_commands import CheckingModel
from pathgene.sim.model.planner.run_cycles import scanning
from pathgene.sim.model.requests import RefusedError
from pathgene.sim.model.run_commands import BlockMarks, RunningModel, block
from tests.support.gateware.streams import pulse, simulate
from tests.support.planner.cases import SMALL, USUAL, record, shape
from tests.support.planner.plain import drawn


ALL = COARSE_BLOCKS**2
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
    # Written with a block size that differs from the scans before and after it.
    marks.shift = 2
    marks.write(*corners((500, 500)))
    marks.shift = 1
    marks.write(*corners((0, 0)))
    assert [marks.scan(), marks.scan()] == [ALL, 0]
    # As many corners in more blocks.
    marks.edge = BLOCKS
    assert [marks.scan(), marks.scan()] == [BLOCKS**2, 0]
    marks.write(*corners((63, 64), (127, 0), (128, 0)))
    assert marks.scan() == 2
    marks.edge = COARSE_BLOCKS
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
        shift, edge = int(rng.choice([1, 2, 2])), BLOCKS if rng.random() < 0.3 else COARSE_BLOCKS
        span = int(rng.choice([4, 70, 128]))
        steps.append((shift, edge, rng.integers(span, size=(int(rng.integers(4)), 2)).tolist()))

    async def bench(ctx):
        for shift, edge, written in steps:
            ctx.set(unit.block_shift, shift)
            ctx.set(unit.fine, edge == BLOCKS)
            marks.shift, marks.edge = shift, edge
            for x, y in written:
                ctx.set(unit.write, {"valid": 1, "x": x, "y": y})
                marks.write(*corners((x, y)))
                await ctx.tick()
            ctx.set(unit.write, {"valid": 0, "x": 0, "y": 0})
            if rng.integers(3) == 0:
                continue
            await ctx.tick().repeat(2)
            await pulse(ctx, unit.launch)
            cycles = 0
            while ctx.get(unit.busy):
                await ctx.tick()
                cycles += 1
            assert cycles == scanning(edge, marks.scan(), shift, 4, LATENCY), (shift, written)

    simulate(unit, bench)


def is_inside(shape, x, y):
    """The formula of the record."""
    u, v = x - shape.first_x, y - shape.first_y
    if u < 0 or x > shape.last_x or v < 0 or y > shape.last_y:
        return False
    bends = itertools.chain([shape.bend_x * u * u + shape.bend_y * v * v], itertools.repeat(0))
    return all(
        at + east * u + north * v - bend >= 0
        for (at, east, north), bend in zip(shape.edges, bends, strict=False)
    )


@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_shapes_are_drawn_as_their_formula_says(config):
    rng = np.random.default_rng(21)
    sizes = []
    for _ in range(60 if config is SMALL else 3):
        some = shape(config, rng)
        before = rng.integers(9, size=(config.map_size,) * 2).astype(np.uint16)
        after = before.copy()
        block(after, config.blocked_altitude, some)
        inside = [(x, y) for y, x in np.ndindex(before.shape) if is_inside(some, x, y)]
        assert drawn(some) == inside
        changed = after != before
        assert changed.sum() == len(inside)
        assert (after[changed] == config.blocked_altitude).all()
        sizes.append(len(inside))
    assert min(sizes) == 0 or config is USUAL
    assert max(sizes) > config.map_size


def test_a_disc_and_a_triangle():
    disc = NoFlyShape(
        first_x=2, first_y=3, last_x=6, last_y=7, edges=((-4, 4, 4),), bend_x=1, bend_y=1
    )
    rows = ["  #  ", " ### ", "#####", " ### ", "  #  "]
    assert drawn(disc) == [
        (2 + u, 3 + v) for v, row in enumerate(rows) for u, mark in enumerate(row) if mark == "#"
    ]
    triangle = NoFlyShape(
        first_x=0, first_y=0, last_x=3, last_y=3, edges=((0, 1, 0), (0, 0, 1), (2, -1, -1))
    )
    assert drawn(triangle) == [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)]


def test_a_box_is_a_shape_without_edges():
    box = NoFlyShape(first_x=1, first_y=2, last_x=2, last_y=2, edges=())
    assert drawn(box) == [(1, 2), (2, 2)]


def test_a_guided_run_begins_along_the_guide():
    """Without generations the population has the waypoints of the guide, whatever their order."""
    config, rng = USUAL, np.random.default_rng(8)
    problem = dataclasses.replace(
        record(config, rng), x_limit=400, y_limit=500, altitude_limit=3000, block_shift=3
    )
    corners = rng.integers(512, size=(5, 2)).tolist()
    guide = [(x, y, int(z)) for (x, y), z in zip(corners, rng.integers(2000, size=5), strict=True)]
    chip = CheckingModel(config)
    model, layout = RunningModel(config, chip.terrain), guide_request(config)
    assert model.set_problem(problem.pack(config), False) == b""
    for index in (3, 0, 4, 1, 2):
        x, y, altitude = guide[index]
        assert model.guide(layout.pack(index=index, x=x, y=y, altitude=altitude), False) == b""
    # A repeated command changes nothing.
    model.guide(layout.pack(index=0, x=1, y=1, altitude=1), True)
    options = RunOptions(generations=0, slopes=(3,), lifts=0, guided=5, seeds=40)
    model.run(options.pack(config), False)
    paths = model.latest.population
    assert len(paths) == config.population
    for path in paths:
        assert [(x, y) for x, y, _ in path] == [(min(x, 400), min(y, 500)) for x, y, _ in guide]
        rises = [z - each[2] for (*_, z), each in zip(path, guide, strict=True)]
        assert all(0 <= rise <= config.box_steps for rise in rises)
    assert len({tuple(path) for path in paths}) > 10
    with pytest.raises(RefusedError):
        model.guide(layout.pack(index=config.max_waypoints, x=0, y=0, altitude=0), False)
