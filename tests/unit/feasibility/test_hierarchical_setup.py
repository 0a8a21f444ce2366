# amaranth: UnusedElaboratable=no
"""Slopes, columns and the numbers behind them: exact, and safe in the coarse map."""

import itertools
import math
import random

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import CheckerBuild, Config
from hdl.feasibility.hierarchical_columns import ColumnWalker, column_layout, probe_layout
from hdl.feasibility.hierarchical_setup import HierarchicalSetup
from hdl.feasibility.layouts import point_layout
from hdl.feasibility.reciprocal import Precision
from sim.model.checker import TerrainModel, walk
from sim.model.checker_clocks_hierarchical import segment_columns
from tests.streams import put, simulate


CONFIG = Config(
    map_size=16, coarse_factor=4, altitude_bits=6, checker=CheckerBuild.HIERARCHICAL, lanes=1
)


class Columns(wiring.Component):
    """Set-up and walker of columns."""

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "points": In(stream.Signature(point_layout(config))),
                "valid": Out(1),
                "column": Out(column_layout(config)),
                "probe": Out(probe_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        m.submodules.setup = setup = HierarchicalSetup(self.config)
        m.submodules.columns = columns = ColumnWalker(self.config)
        connect(m, flipped(self.points), setup.points)
        connect(m, setup.spans, columns.spans)
        m.d.comb += [
            columns.room.eq(1),
            columns.segment_room.eq(1),
            columns.allow.eq(1),
            self.valid.eq(columns.valid),
            self.column.eq(columns.column),
            self.probe.eq(columns.probe),
        ]
        return m


def columns_of(config, segments):
    """Return every (clock, column, probe) of paths of one segment, and the clock of each point."""
    dut = Columns(config)
    seen, taken = [], []
    terrain = TerrainModel(config)
    total = sum(len(list(segment_columns(config, terrain, *ends))) for ends in segments)

    async def source(ctx):
        for ends in segments:
            for last, (x, y, altitude) in enumerate(ends):
                await put(ctx, dut.points, {"x": x, "y": y, "altitude": altitude, "last": last})

    async def monitor(ctx):
        for clock in itertools.count():
            _, _, valid, column, probe, moved = await ctx.tick().sample(
                dut.valid, dut.column, dut.probe, dut.points.valid & dut.points.ready
            )
            if moved:
                taken.append(clock)
            if valid:
                seen.append((clock, column, probe))
            if len(seen) == total:
                return

    simulate(dut, monitor, background=[source])
    return seen, taken


def random_segments(config, rng, number):
    edge, top = config.map_size, config.blocked_altitude
    for _ in range(number):
        x, y = rng.randrange(edge), rng.randrange(edge)
        far = rng.random() < 0.7
        stop = (
            (rng.randrange(edge), rng.randrange(edge))
            if far
            else ((x + rng.randint(0, 2)) % edge, (y + rng.randint(0, 2)) % edge)
        )
        yield (x, y, rng.randrange(top + 1)), (*stop, rng.randrange(top + 1))


@pytest.mark.parametrize(
    "config",
    [CONFIG, CONFIG.replace(lanes=4), Config(checker=CheckerBuild.HIERARCHICAL, lanes=2)],
    ids=["one", "four", "full"],
)
def test_columns_cover_their_cells(config):
    """Each cell of a segment is in a probed block, not below ``lowest``; no column is left out."""
    segments = list(random_segments(config, random.Random(4), 60))
    seen, _ = columns_of(config, segments)
    seen = iter(seen)
    factor = config.coarse_factor
    fraction = Precision.of(config).reciprocal
    for start, stop in segments:
        cells = list(walk(start, stop))
        while cells:
            _, column, probe = next(seen)
            own, cells = cells[: column.more + 1], cells[column.more + 1 :]
            blocks = {
                (block, probe.row) if column.steep else (probe.row, block)
                for block in (probe.first, probe.last)
            }
            crossed = {(x // factor, y // factor) for x, y, _ in own}
            across = [(y, x) if column.steep else (x, y) for x, y, _ in own]
            assert crossed <= blocks
            assert probe.lowest == min(math.ceil(altitude) for *_, altitude in own)
            assert column.major == across[0][0]
            assert column.ends_segment == column.ends_path == (not cells)
            # What the walk of the cells starts from: a group's first cell.
            group = min(config.lanes, factor)
            behind = (-column.major - 1 if column.back else column.major) % group
            for k, ((_, minor), (*_, altitude)) in enumerate(
                zip(across, own, strict=True), start=behind
            ):
                # Sums are modulo their width: the group may begin below 0.
                place = column.minor_sum + k * column.minor_slope >> fraction
                ceiling = column.altitude_sum + k * column.altitude_slope >> fraction
                assert place % config.map_size == minor
                assert ceiling % (1 << config.altitude_bits) == math.ceil(altitude)


def test_clocks():
    """The first column 11 clocks after the second point, then one a clock."""
    for ends in random_segments(CONFIG, random.Random(6), 6):
        seen, taken = columns_of(CONFIG, [ends])
        first = taken[1] + HierarchicalSetup.LATENCY + 1
        assert [clock for clock, *_ in seen] == list(range(first, first + len(seen)))


@pytest.mark.parametrize("map_size", [8, 64, 512])
def test_sums_are_exact(map_size):
    """Cells and ceilings by sums of slopes that are not rounded, against their definition."""
    config = Config(map_size=map_size, coarse_factor=4)
    precision = Precision.of(config)
    fraction = precision.reciprocal
    half = precision.minor_bias << fraction - precision.minor
    unit = precision.rise_bias << fraction - precision.rise
    lengths = range(1, map_size) if map_size < 512 else [*range(1, 512, 25), 509, 510, 511]
    for n in lengths:
        reciprocal = precision.of_length(n)
        k = np.arange(n + 1)[:, None]
        d = np.arange(-n, n + 1)
        assert np.array_equal(half + k * (d * reciprocal) >> fraction, (2 * k * d + n) // (2 * n))
        rise = np.arange(-4095, 4096, 1 if map_size == 8 else 13)
        assert np.array_equal(unit + k * (rise * reciprocal) >> fraction, -(-k * rise // n))
