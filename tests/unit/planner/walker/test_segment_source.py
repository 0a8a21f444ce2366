"""The source of segments: their order and marks, and no gaps."""

import itertools

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import memory

from pathgene.hdl.planner.walker.segment_source import SegmentSource
from tests.support.gateware.streams import collect, put, simulate
from tests.support.planner.cases import corner, segments_of


SIZES = {"coordinate_bits": 3, "altitude_bits": 4, "place_bits": 2, "row_bits": 3}
START = (1, 2, 3)


def drawn_path(rng):
    """A path and its chords, one or None for each point."""

    def point():
        return tuple(rng.integers(8, size=3).tolist())

    points = [START, *(point() for _ in range(int(rng.integers(2, 6))))]
    chords = [(point(), point()) if rng.random() < 0.4 else None for _ in points]
    return points, chords, bool(rng.integers(2))


def row_of(path, i):
    """The row of a point; after the goal, and for a start without a chord, an unreadable row."""
    points, chords, _ = path
    if i >= len(points) or (i == 0 and chords[0] is None):
        return {"point": {"x": 7}, "chord": {"present": 1}}
    chord = {"present": 0}
    if chords[i] is not None:
        chord = dict(zip(("start", "stop"), map(corner, chords[i]), strict=True)) | {"present": 1}
    return {"point": corner(points[i]) | {"last": i == len(points) - 1}, "chord": chord}


def run(paths, pauses, *, late=()):
    """Return the segments of paths in the places of a memory, and the cycle of each.

    Paths are offered in every cycle, but paths with numbers in ``late`` 30 cycles later.
    """
    source = SegmentSource(**SIZES)
    rows = [row_of(path, i) for path in paths for i in range(8)]
    m = Module()
    m.submodules.source = source
    m.submodules.rows = store = memory.Memory(shape=source.row.shape(), depth=len(rows), init=rows)
    read = store.read_port()
    m.d.comb += [
        read.en.eq(source.read.enable),
        read.addr.eq(source.read.row + (source.read.place << 3)),
        source.row.eq(read.data),
    ]
    segments, cycles, offered = [], [], []
    count = sum(len(segments_of(*path)) for path in paths)

    async def offer(ctx):
        ctx.set(source.start, corner(START))
        for place, (points, chords, first) in enumerate(paths):
            if place in late:
                await ctx.tick().repeat(30)
            offered.append(len(cycles))
            await put(
                ctx,
                source.paths,
                {
                    "place": place,
                    "goal": len(points) - 1,
                    "enters": chords[0] is not None,
                    "first": first,
                },
            )

    async def watch(ctx):
        while True:
            *_, valid = await ctx.tick().sample(source.segments.valid)
            cycles.append(valid)

    async def bench(ctx):
        while len(segments) < count:
            await ctx.tick()
        await ctx.tick().repeat(5)

    simulate(m, bench, background=[watch, offer, collect(source.segments, segments, pauses)])
    return [_segment(each) for each in segments], cycles, offered


def _segment(each):
    ends = [tuple(end[axis] for axis in ("x", "y", "altitude")) for end in (each.start, each.stop)]
    names = ("begins", "last", "chord", "first")
    return *ends, {name: bool(each.identity[name]) for name in names}


def expected(paths):
    segments = itertools.chain(*(segments_of(*path) for path in paths))
    return [(*ends, marks) for ends, marks in (((a, b), c) for a, b, c in segments)]


@pytest.mark.parametrize("pauses", [(0,), (0, 1, 0, 0, 7)], ids=["steady", "stalled"])
def test_segments_of_paths(pauses):
    rng = np.random.default_rng(1)
    for _ in range(10):
        paths = [drawn_path(rng) for _ in range(4)]
        segments, cycles, _ = run(paths, pauses)
        assert segments == expected(paths)
        # Two cycles after the first path, then one in every cycle while they are taken.
        if pauses == (0,):
            first = cycles.index(1)
            assert cycles[first:] == [1] * len(segments) + [0] * (
                len(cycles) - first - len(segments)
            )
        else:
            assert cycles[-1] == 0


def test_a_late_path():
    """The first segment of a path is offered 2 cycles after the path."""
    rng = np.random.default_rng(2)
    for late in ((0,), (1,), (0, 1, 2, 3)):
        paths = [drawn_path(rng) for _ in range(4)]
        segments, cycles, offered = run(paths, (0,), late=late)
        assert segments == expected(paths)
        for place in late:
            begins = offered[place] + 2
            assert cycles[begins - 1 : begins + 1] == [0, 1]
