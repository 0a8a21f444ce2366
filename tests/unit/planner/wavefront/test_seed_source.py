"""Seeds: paths and words equal the definition's, at one word per cycle and with pauses."""

import random

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.seed_source import Seeder
from pathgene.sim.model.planner.run_cycles import WAYPOINT, seeding
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.plain import seed_path
from tests.support.planner.wavefront import Words, corner, problem


class Map:
    """The map's blocks as far as seeds need them."""

    def __init__(self, lowest):
        self.lowest = lowest


def seeds(config, rng, count, length, bends, waypoints):
    """Return a problem, route, turns, guide, memories of the blocks, paths, and their words."""
    record = problem(config, rng)
    edge = record.blocks
    route = [tuple(each) for each in rng.integers(edge, size=(length, 2)).tolist()]
    turns = [tuple(each) for each in rng.integers(edge, size=(bends, 2)).tolist()]
    places = sorted({*route, *turns})
    lowest = {place: tuple(rng.integers(config.map_size, size=2).tolist()) for place in places}
    top = config.blocked_altitude
    surface = {place: int(rng.integers(top + 1)) for place in places if rng.random() < 0.8}
    source = Words(rng)
    blocks = Map(lowest)
    corners = rng.integers(config.map_size, size=(waypoints, 2))
    guide = np.column_stack((corners, rng.integers(top + 1, size=waypoints))).tolist()
    paths = [
        seed_path(config, record, blocks, surface, route, source, turns, guide)
        for _ in range(count)
    ]
    return record, route, turns, guide, lowest, surface, paths, source.taken


@pytest.mark.parametrize("share", [1, 0.4], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "count", "length", "bends", "waypoints"),
    [
        (SMALL, 60, 1, 0, 0),
        (SMALL, 60, 1024, 0, 0),
        (SMALL, 30, 1, 2, 0),
        (SMALL, 30, 9, SMALL.max_waypoints, 0),
        (SMALL, 30, 1, 0, 2),
        (SMALL, 30, 9, 3, SMALL.max_waypoints),
        (USUAL, 20, 37, 0, 0),
        (USUAL, 20, 37, 7, 0),
        (USUAL, 20, 37, 7, 9),
        (USUAL, 5, 4096, USUAL.max_waypoints, 0),
        (LARGE, 6, 4096, 0, 0),
        (LARGE, 6, 1000, 40, 0),
        (LARGE, 6, 1000, 0, LARGE.max_waypoints),
    ],
)
def test_matches_the_definition(config, count, length, bends, waypoints, share):
    rng, pauses = np.random.default_rng(count + length), random.Random(length)
    record, route, turns, guide, lowest, surface, paths, words = seeds(
        config, rng, count, length, bends, waypoints
    )
    read_from = [] if guide else turns or route
    dut = shared(Seeder, config)
    points, found, stepped, busy = [], [], [], []

    async def bench(ctx):
        limits = record.x_limit, record.y_limit, record.altitude_limit
        ctx.set(dut.limits, corner(*limits))
        ctx.set(dut.length, length)
        ctx.set(dut.follows, bool(guide or turns))
        ctx.set(dut.guided, bool(guide))
        ctx.set(dut.turns, len(guide) or len(turns))
        ctx.set(dut.block_shift, record.block_shift)
        asked, read = [0] * 2, [(0, 0)] * 2
        left, cycle = count, 0
        while left or ctx.get(dut.busy) or len(points) < sum(map(len, paths)):
            assert cycle < 20_000
            # The next one follows immediately, while waypoints of the previous one are in flight.
            launches = left and not ctx.get(dut.busy)
            left -= launches
            ctx.set(dut.launch, launches)
            ready = pauses.random() < share and len(stepped) < len(words)
            ctx.set(dut.word_ready, ready)
            ctx.set(dut.word, words[len(stepped)] & (1 << 19) - 1 if ready else 0)
            busy.append(ctx.get(dut.busy))
            if ctx.get(dut.step):
                assert ready
                stepped.append(cycle)
            point = ctx.get(dut.found)
            if point.valid:
                points.append((point.x, point.y, point.altitude, point.last))
                found.append(cycle)
            place = ctx.get(dut.read_block)
            asked.append(ctx.get(dut.number))
            read.append((place & 63, place >> 6))
            await ctx.tick()
            cycle += 1
            x, y = read_from[asked[-2]] if asked[-2] < len(read_from) else (0, 0)
            ctx.set(dut.place, {"x": x, "y": y})
            ctx.set(dut.guide, corner(*(guide[asked[-2]] if asked[-2] < len(guide) else (0, 0, 0))))
            block = read[-2]
            x, y = lowest.get(block, (0, 0))
            altitude = surface.get(block, 0)
            ctx.set(dut.block, {"x": x, "y": y, "free": block in surface, "altitude": 1})
            ctx.set(dut.surface, {"free": block in surface, "altitude": altitude})

    simulate(dut, bench)
    assert points == [
        (*waypoint[:3], i == len(path) - 1) for path in paths for i, waypoint in enumerate(path)
    ]
    assert len(stepped) == len(words)
    assert Seeder.latency == WAYPOINT
    firsts = np.cumsum([0, *map(len, paths[:-1])])
    assert [found[i] - stepped[i + n + 1] for n, i in enumerate(firsts)] == [WAYPOINT] * count
    if share == 1:
        # One idle cycle for each, in which it is launched.
        expected = [each for path in paths for each in [0] + [1] * seeding(len(path))]
        assert busy[: len(expected)] == expected
