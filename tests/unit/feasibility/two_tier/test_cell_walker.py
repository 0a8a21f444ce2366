"""Set-up and walker of the two-tier build: cells, exact altitudes, and the cycles between them."""

import itertools
import random
from fractions import Fraction

import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.two_tier.cell_walker import AltitudeComparator, CellWalker
from pathgene.hdl.feasibility.two_tier.segment_setup import TwoTierSegmentSetup
from pathgene.hdl.layouts import point_layout
from pathgene.sim.model.checker import to_coarse, walk
from tests.support.gateware.streams import put, shared, simulate


CONFIG = Config(checker="two-tier", lanes=1, map_size=8, coarse_factor=2, altitude_bits=4)
#: Cycles from the transfer of the second point of a path to its first cell, both included.
FIRST = 4


class Walk(wiring.Component):
    """Set-up and walker."""

    def __init__(self, config):
        self.config = config
        points = point_layout(config.coordinate_bits, config.altitude_bits)
        self.walker = walker = CellWalker(
            config.coordinate_bits, config.altitude_bits, config.segment_bits
        )
        super().__init__(
            {
                "points": In(stream.Signature(points)),
                "room": In(1),
                "visiting": Out(1),
                "visit": Out(walker.visit.shape()),
                "level": Out(walker.level.shape()),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        m.submodules.setup = setup = TwoTierSegmentSetup(
            config.coordinate_bits,
            config.coarse_bits,
            config.altitude_bits,
            config.segment_bits,
            config.DETAILED_SEGMENTS,
        )
        m.submodules.walker = walker = self.walker
        connect(m, flipped(self.points), setup.points)
        connect(m, setup.segments, walker.segments)
        m.d.comb += [
            walker.room.eq(self.room),
            walker.segment_room.eq(self.room),
            self.visiting.eq(walker.visiting),
            self.visit.eq(walker.visit),
            self.level.eq(walker.level),
        ]
        return m


def expected(config, path):
    """Every visit of a path, and its altitude."""
    cells = []
    segments = list(itertools.pairwise(path))
    for number, (start, stop) in enumerate(segments):
        coarse = number >= config.DETAILED_SEGMENTS
        if coarse:
            start, stop = to_coarse(config, start), to_coarse(config, stop)
        visited = list(walk(start, stop))
        for index, (x, y, altitude) in enumerate(visited):
            ends = index == len(visited) - 1
            ends_path = ends and number == len(segments) - 1
            place = (number, int(number == index == 0), int(ends), int(ends_path))
            cells.append((x, y, int(coarse), *place, altitude))
    return cells


def visits(config, paths, pauses=(0,)):
    """Return every (cycle, visit with its altitude), and the cycle of each transfer of a point."""
    dut = shared(Walk, config)
    seen, taken = [], []
    total = sum(len(expected(config, path)) for path in paths)
    allowed = itertools.cycle(cycle for pause in pauses for cycle in [*[0] * pause, 1])

    async def source(ctx):
        for path in paths:
            for index, (x, y, altitude) in enumerate(path):
                last = index == len(path) - 1
                await put(ctx, dut.points, {"x": x, "y": y, "altitude": altitude, "last": last})

    async def monitor(ctx):
        waiting = None
        for cycle in itertools.count():
            ctx.set(dut.room, next(allowed))
            _, _, visiting, visit, valid, ready = await ctx.tick().sample(
                dut.visiting, dut.visit, dut.points.valid, dut.points.ready
            )
            if valid and ready:
                taken.append(cycle)
            if visiting:
                level = ctx.get(dut.level)
                waiting = [visit[field] for field, _ in dut.visit.shape()]
                seen.append((cycle, (*waiting, Fraction(level.scaled, level.steps))))
            if len(seen) == total:
                return

    simulate(dut, monitor, background=[source])
    return seen, taken


def random_path(rng, config, most=5):
    edge, top = config.map_size, config.blocked_altitude
    return [
        (rng.randrange(edge), rng.randrange(edge), rng.randrange(top + 1))
        for _ in range(rng.randint(2, most))
    ]


def corner_segments():
    """Segments from a corner of the map, or back to it, have every slope in all directions."""
    edge = CONFIG.map_size - 1
    rng = random.Random(1)
    for corner in itertools.product((0, edge), repeat=2):
        for cell in itertools.product(range(edge + 1), repeat=2):
            ends = [(*corner, rng.randrange(16)), (*cell, rng.randrange(16))]
            yield ends if sum(cell) % 2 else ends[::-1]


@pytest.mark.parametrize("pauses", [(0,), (0, 1, 3)], ids=["steady", "stalled"])
def test_every_slope(pauses):
    paths = list(corner_segments())
    seen, _ = visits(CONFIG, paths, pauses)
    assert [visit for _, visit in seen] == [cell for p in paths for cell in expected(CONFIG, p)]


@pytest.mark.parametrize("map_size", [8, 512])
def test_paths(map_size):
    config = CONFIG.replace(map_size=map_size, altitude_bits=12)
    rng = random.Random(map_size)
    paths = [random_path(rng, config) for _ in range(300 * 8 // map_size + 4)]
    seen, _ = visits(config, paths)
    assert [visit for _, visit in seen] == [cell for p in paths for cell in expected(config, p)]


def test_loses_no_cycle():
    """The first cell follows 3 cycles after the second point, then one per cycle along the path."""
    rng = random.Random(3)
    for _ in range(8):
        path = random_path(rng, CONFIG, most=8)
        seen, taken = visits(CONFIG, [path])
        first = taken[1] + FIRST - 1
        assert [cycle for cycle, _ in seen] == list(range(first, first + len(seen)))


@pytest.mark.parametrize("memory_latency", [1, 2])
def test_latency_of_a_comparison(memory_latency):
    assert AltitudeComparator(5, 4, 3, memory_latency).latency == memory_latency + 3
