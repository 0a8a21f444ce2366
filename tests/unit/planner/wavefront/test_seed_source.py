"""Seeds: paths and words equal the definition's, at one word per cycle and with pauses."""

import random

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.seed_source import Seeder
from pathgene.hdl.protocol.planner import seed_waypoints
from pathgene.sim.model.planner.run_cycles import WAYPOINT, seeding
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.plain import seed_path
from tests.support.planner.wavefront import Words, corner, problem


class Map:
    """The map's blocks as far as seeds need them."""

    def __init__(self, lowest):
        self.lowest = lowest


def seeds(config, rng, count, length):
    """Return a problem, a route, memories of the blocks, paths, and their words."""
    record = problem(config, rng)
    route = [tuple(each) for each in rng.integers(32, size=(length, 2)).tolist()]
    places = sorted(set(route))
    lowest = {place: tuple(rng.integers(config.map_size, size=2).tolist()) for place in places}
    top = config.blocked_altitude
    surface = {place: int(rng.integers(top + 1)) for place in places if rng.random() < 0.8}
    source = Words(rng)
    paths = [seed_path(config, record, Map(lowest), surface, route, source) for _ in range(count)]
    return record, route, lowest, surface, paths, source.taken


@pytest.mark.parametrize("share", [1, 0.4], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "count", "length"),
    [(SMALL, 60, 1), (SMALL, 60, 1024), (USUAL, 20, 37), (LARGE, 6, 1000)],
)
def test_matches_the_definition(config, count, length, share):
    rng, pauses = np.random.default_rng(count + length), random.Random(length)
    record, route, lowest, surface, paths, words = seeds(config, rng, count, length)
    dut = shared(Seeder, config)
    points, found, stepped, busy = [], [], [], []

    async def bench(ctx):
        limits = record.x_limit, record.y_limit, record.altitude_limit
        ctx.set(dut.limits, corner(*limits))
        ctx.set(dut.length, length)
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
            read.append((place & 31, place >> 5))
            await ctx.tick()
            cycle += 1
            x, y = route[asked[-2]] if asked[-2] < length else (0, 0)
            ctx.set(dut.place, {"x": x, "y": y})
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
    _, longest = seed_waypoints(config.max_waypoints)
    each = longest + 1
    firsts = np.cumsum([0, *map(len, paths[:-1])])
    assert [found[i] - stepped[each * n + 1] for n, i in enumerate(firsts)] == [WAYPOINT] * count
    if share == 1:
        # One idle cycle for each, in which it is launched.
        assert busy[: count * (each + 1)] == ([0] + [1] * seeding(longest)) * count
