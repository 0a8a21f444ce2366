"""The walker of segments compared with the definition: small maps, 1 to 4 lanes.

More lanes, and all segments of a small map, run compiled, in ``tests/cosim/test_path_walker.py``.
"""

import itertools

import numpy as np
import pytest
from amaranth.hdl import Cat

from pathgene.hdl.config import Config
from pathgene.hdl.planner.walker.segment_walker import SegmentWalker
from pathgene.sim.model.planner.definition.score import walk
from pathgene.sim.model.planner.evaluator_cycles import walking
from tests.support.gateware.streams import put, simulate
from tests.support.planner.cases import any_point, corner, heights_of, upload


TINY = Config(map_size=8, coarse_factor=2, altitude_bits=4, lanes=4)
SMALL = TINY.replace(map_size=16, altitude_bits=6)


def walker_of(config):
    return SegmentWalker(
        config.lanes, config.coordinate_bits, config.altitude_bits, 3, config.memory_latency
    )


def segment_of(ends, row=0, answered=False):
    identity = {"marks": {}, "row": row, "answered": answered}
    return {"start": corner(ends[0]), "stop": corner(ends[1]), "identity": identity}


def run(config, heights, segments, answered=(), pauses=(0,)):
    """Walk segments; return hits and margins, and the cycles of taking and of the results."""
    dut = walker_of(config)
    taken, walked, cycles = [], [], []

    async def bench(ctx):
        await upload(ctx, dut, heights)
        for number, (segment, pause) in enumerate(zip(segments, itertools.cycle(pauses))):
            if pause:
                await ctx.tick().repeat(pause)
            request = segment_of(segment, number % 8, number in answered)
            await put(ctx, dut.segments, request)
        while len(walked) < len(segments):
            await ctx.tick()

    async def watch(ctx):
        for cycle in itertools.count():
            *_, valid, ready, result = await ctx.tick().sample(
                dut.segments.valid, dut.segments.ready, dut.walked
            )
            if valid and ready:
                taken.append(cycle)
            if result.valid:
                assert result.identity.row == len(walked) % 8
                assert result.identity.answered == (len(walked) in answered)
                walked.append((result.hits, result.margin))
                cycles.append(cycle)

    simulate(dut, bench, background=[watch])
    return walked, taken, cycles


def expected(config, heights, segments):
    return [walk(heights, config.blocked_altitude, *segment) for segment in segments]


def corners_of(start, stop):
    return max(abs(a - b) for a, b in zip(start[:2], stop[:2], strict=True)) + 1


@pytest.mark.parametrize("lanes", [1, 2, 4])
def test_random_segments(lanes):
    """Altitudes are arbitrary, and segments follow in direct succession."""
    config = SMALL.replace(lanes=lanes, memory_latency=1 + lanes % 2)
    rng = np.random.default_rng(lanes)
    heights = heights_of(config, rng)
    segments = [(any_point(config, rng), any_point(config, rng)) for _ in range(60)]
    walked, taken, cycles = run(config, heights, segments)
    assert walked == expected(config, heights, segments)
    # A segment is launched two cycles after it is taken, and costs as many as in the model.
    free = 0
    latency = walker_of(config).latency
    for segment, begin, end in zip(segments, taken, cycles, strict=True):
        free = max(begin + 2, free) + walking(corners_of(*segment), lanes)
        assert end == free - 1 + latency
    assert cycles[-1] - cycles[0] == sum(
        walking(corners_of(*segment), lanes) for segment in segments[1:]
    )


def test_widest_altitudes():
    """On short segments between extremes of 16 bits, altitudes fall below 0 within half a step."""
    config = TINY.replace(lanes=2, altitude_bits=16)
    rng = np.random.default_rng(7)
    top = config.blocked_altitude
    heights = rng.choice([0, 1, 32767, 32768, top - 1, top], size=(8, 8)).astype(np.uint16)
    values = (0, 1, 32768, top - 1, top)
    segments = [
        ((int(x), int(y), low), (int(u), int(v), high))
        for low, high in itertools.product(values, repeat=2)
        for x, y, u, v in rng.integers(8, size=(2, 4))
    ]
    segments += [((3, 3, low), (3, 3, high)) for low, high in itertools.product(values, repeat=2)]
    walked, *_ = run(config, heights, segments)
    assert walked == expected(config, heights, segments)


def test_answered_segments_take_a_cycle():
    """All further segments still get their results, with pauses between them."""
    config = TINY.replace(lanes=2)
    rng = np.random.default_rng(5)
    heights = heights_of(config, rng)
    segments = [(any_point(config, rng), any_point(config, rng)) for _ in range(60)]
    answered = {number for number in range(60) if rng.random() < 0.4}
    for pauses in ((0,), (0, 0, 7, 1)):
        walked, taken, cycles = run(config, heights, segments, answered, pauses)
        wanted = expected(config, heights, segments)
        assert [w for n, w in enumerate(walked) if n not in answered] == [
            w for n, w in enumerate(wanted) if n not in answered
        ]
        free, latency = 0, walker_of(config).latency
        for number, (segment, begin, end) in enumerate(zip(segments, taken, cycles, strict=True)):
            cost = 1 if number in answered else walking(corners_of(*segment), 2)
            free = max(begin + 2, free) + cost
            assert end == free - 1 + latency


def rows_of(config, rng, number):
    """Arbitrary rows of corners, in the form of their layout."""
    columns = config.map_size // config.lanes
    return [
        {"x": int(rng.integers(columns)), "y": int(rng.integers(config.map_size))}
        for _ in range(number)
    ]


async def read_rows(ctx, dut, rows):
    """Request a row each cycle; return the corners of each row ``row_latency`` cycles later."""
    found = []
    for row in [*rows, *[{"x": 0, "y": 0}] * dut.row_latency]:
        ctx.set(dut.row, row)
        *_, corners = await ctx.tick().sample(Cat(*dut.corners))
        found.append(corners)
    bits = dut.altitude_bits
    return [
        [corners >> bits * lane & (1 << bits) - 1 for lane in range(dut.lanes)]
        for corners in found[dut.row_latency :]
    ]


def corners_in(heights, lanes, rows):
    return [heights[row["y"], row["x"] * lanes : (row["x"] + 1) * lanes].tolist() for row in rows]


@pytest.mark.ci
@pytest.mark.parametrize("latency", [1, 2])
@pytest.mark.parametrize("lanes", [1, 2, 4, 8, 16])
def test_rows(lanes, latency):
    """Rows come each cycle from one cycle after a write, also between walks of steep segments."""
    config = SMALL.replace(lanes=lanes, memory_latency=latency)
    rng = np.random.default_rng(10 * lanes + latency)
    heights = heights_of(config, rng)
    dut = walker_of(config)
    assert dut.row_latency == latency + 4
    segments = [((1, 0, 9), (3, 15, 2)), ((14, 2, 0), (0, 7, 40)), ((9, 15, 30), (9, 1, 3))]

    async def bench(ctx):
        await upload(ctx, dut, heights)
        for segment in segments:
            rows = rows_of(config, rng, 20)
            assert await read_rows(ctx, dut, rows) == corners_in(heights, lanes, rows)
            # The row is asked for in the cycle after the write.
            x, y, altitude = (int(value) for value in rng.integers(config.map_size, size=3))
            heights[y, x] = altitude
            await put(ctx, dut.writes, {**corner((x, y, altitude)), "last": 0})
            rows = [{"x": x // lanes, "y": y}, *rows_of(config, rng, 4)]
            assert await read_rows(ctx, dut, rows) == corners_in(heights, lanes, rows)
            await put(ctx, dut.segments, segment_of(segment))
            # Rows that are asked for meanwhile change nothing.
            ctx.set(dut.row, rows_of(config, rng, 1)[0])
            while not ctx.get(dut.walked.valid):
                await ctx.tick()
            result = ctx.get(dut.walked)
            assert (result.hits, result.margin) == expected(config, heights, [segment])[0]

    simulate(dut, bench)


@pytest.mark.parametrize(("lanes", "coordinate_bits", "limit"), [(32, 5, 16), (4, 1, 2)])
def test_lanes_are_within_the_map_and_sixteen(lanes, coordinate_bits, limit):
    rule = f"^Lanes must be a power of two from 1 to {limit}, not {lanes}$"
    with pytest.raises(ValueError, match=rule):
        SegmentWalker(lanes, coordinate_bits, 4, 2, 2)
