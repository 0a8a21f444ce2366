# amaranth: UnusedElaboratable=no
"""Seeds: the definition's paths and words, a word a cycle, and with pauses on both sides."""

import random

import numpy as np
import pytest

from hdl.planner.wavefront.seeder import Seeder
from sim.model.planner.definition.seeds import seed_path
from tests.planner_cases import LARGE, SMALL, USUAL
from tests.planner_wavefront import Words, corner, problem
from tests.streams import simulate


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
    dut = Seeder(config)
    points, offered, stepped = [], [], []

    async def bench(ctx):
        limits = record.x_limit, record.y_limit, record.altitude_limit
        ctx.set(dut.limits, corner(*limits))
        ctx.set(dut.length, length)
        ctx.set(dut.paths, count)
        asked, read = [0] * 2, [(0, 0)] * 2
        ctx.set(dut.launch, 1)
        await ctx.tick()
        ctx.set(dut.launch, 0)
        cycle = 0
        while ctx.get(dut.busy):
            ready = pauses.random() < share and len(stepped) < len(words)
            ctx.set(dut.word_ready, ready)
            ctx.set(dut.word, words[len(stepped)] & (1 << 19) - 1 if ready else 0)
            ctx.set(dut.waypoints.ready, pauses.random() < share)
            if ctx.get(dut.step):
                assert ready
                stepped.append(cycle)
            if ctx.get(dut.waypoints.valid & dut.waypoints.ready):
                point = ctx.get(dut.waypoints.payload)
                points.append((point.x, point.y, point.altitude, point.last))
                offered.append(cycle)
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
            assert cycle < 20_000

    simulate(dut, bench)
    assert points == [
        (*waypoint[:3], i == len(path) - 1) for path in paths for i, waypoint in enumerate(path)
    ]
    assert len(stepped) == len(words)
    if share == 1:
        assert offered[0] == stepped[1] + Seeder.latency
        if config is not LARGE:
            # Fewer waypoints are on their way than the seeder has places for.
            assert stepped == list(range(len(words)))
