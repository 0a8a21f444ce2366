"""The exported walker of paths in Verilator: hits, margins and cycles of many paths."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.planner.walker.path_walker import PathWalker
from pathgene.hdl.verilog import convert
from pathgene.sim.exported import cached_verilog
from pathgene.sim.harness.program import VerilatedProgram
from pathgene.sim.model.planner.evaluator_cycles import back, cost, walked
from pathgene.sim.model.planner.walk import walk
from tests.support.planner.cases import SMALL, USUAL, any_point, ground, heights_of, segments_of
from tests.support.planner.plain import Memo


pytestmark = pytest.mark.cosim

TINY = SMALL.replace(max_waypoints=4, map_size=8, coarse_factor=2, altitude_bits=4)


class VerilatedWalker(VerilatedProgram):
    """The walker of paths, simulated by Verilator in another process."""

    def __init__(self, config, rows):
        def export():
            return convert(PathWalker(config, rows), "path_walker")

        text = cached_verilog(export, "path_walker", repr(config), str(rows))
        main = Path(__file__).with_name("path_walker.cpp")
        super().__init__(text, "path_walker", main, str(config.index_bits))
        self.config, self.rows = config, rows

    def write(self, heights):
        rows, columns = heights.shape
        words = [
            self._packed((x, y, int(heights[y, x])))
            for y, x in itertools.product(range(rows), range(columns))
        ]
        self.send(1, len(words), words)

    def begin(self):
        """Void the memo."""
        self.send(2)

    def walk(self, paths, stall=0):
        """Return hits, cycles of offer and of result of each path, all margins, and the cost."""
        heads, segments = [], []
        for path in paths:
            heads += [path.gap, len(path.segments)]
            segments += [self._packed_segment(*each) for each in path.segments]
        self.send(3, stall, len(paths), heads, len(segments), segments)
        results = self.receive(3 * len(paths)).reshape(-1, 3).tolist()
        margins = self.receive(2 * int(self.receive(1)[0])).reshape(-1, 2).tolist()
        half = 1 << self.config.altitude_bits
        margins = [(index, (bits ^ half) - half) for index, bits in margins]
        return results, margins, int(self.receive(1)[0])

    def _packed(self, point):
        bits = self.config.coordinate_bits
        return point[0] | point[1] << bits | point[2] << 2 * bits

    def _packed_segment(self, start, stop, marks):
        size = 2 * self.config.coordinate_bits + self.config.altitude_bits
        assert 2 * size + len(marks) <= 64
        names = ("begins", "last", "chord", "first")
        bits = sum(bool(marks[name]) << i for i, name in enumerate(names))
        return self._packed(start) | self._packed(stop) << size | bits << 2 * size


class WalkedPath:
    """A path, the chords of its points, and how it is offered."""

    def __init__(self, points, chords, first, gap):
        self.points, self.chords, self.first, self.gap = points, chords, first, gap
        self.segments = segments_of(points, chords, first)


def check(chip, heights, paths, *, stall=0):
    """Compare a batch with the model; return the share that the memo answered, and all hits."""
    config = chip.config
    chip.begin()
    memo = Memo(config, chip.rows)
    results, margins, launched = chip.walk(paths, stall)
    expected, free, asked, known_ones, total, cycles = [], 0, 0, 0, 0, 0
    for path, (hits, offered, done) in zip(paths, results, strict=True):
        costs, count, stopped, before = [], 0, False, config.blocked_altitude
        index = -1
        for a, b, marks in path.segments:
            known = memo.get(a, b)
            found = known or walk(heights, config.blocked_altitude, *a, *b)
            if known is None:
                memo.put(a, b, found)
            asked, known_ones = asked + 1, known_ones + (known is not None)
            costs.append(cost(a, b, known is not None, config.lanes))
            if not stopped:
                count += found[0]
                stopped = bool(path.first and found[0])
            if not marks["chord"]:
                if index >= 0:
                    expected.append((index, min(before, found[1])))
                index, before = index + 1, found[1]
            before = min(before, found[1])
        assert hits == count, path.points
        total += count
        cycles += sum(costs)
        if not stall:
            free = walked(offered, free, costs)
            assert done == free - 1 + back(config.lanes, config.memory_latency)
    assert margins == expected
    assert launched == cycles
    return known_ones / asked, total


def random_paths(config, rng, number, *, pool=40, repeat=0.6, heading=0):
    """Paths over few points; many differ from an earlier path in one point, as children do."""
    points = [any_point(config, rng) for _ in range(pool)]
    start, goal = any_point(config, rng), any_point(config, rng)
    headings = [bool(heading & 1), bool(heading >> 1)]
    paths = []

    def any_of(items):
        return items[int(rng.integers(len(items)))]

    for _ in range(number):
        if paths and rng.random() < repeat:
            old = any_of(paths[-30:])
            inner, chords = old.points[1:-1], list(old.chords)
            inner[int(rng.integers(len(inner)))] = any_of(points)
        else:
            inner = [any_of(points) for _ in range(int(rng.integers(2, config.max_waypoints + 1)))]
            chords = [
                (any_of(points), any_of(points)) if has_arc and rng.random() < 0.4 else None
                for has_arc in (headings[0], *[True] * len(inner), headings[1])
            ]
        gap = int(rng.choice([0, 0, 0, 1, 2, 5, 30]))
        paths.append(WalkedPath([start, *inner, goal], chords, int(rng.integers(2)), gap))
    return paths


@pytest.mark.ci
@pytest.mark.parametrize(
    ("lanes", "rows", "latency", "bits"),
    [
        (1, 0, 2, 4),
        (2, 2, 1, 16),
        # The two around it, and the full size with as many rows, find the same faults.
        pytest.param(4, 512, 1, 14, marks=pytest.mark.long),
        (8, 64, 2, 6),
    ],
)
def test_tiny_map(lanes, rows, latency, bits):
    """Pairs of corners at random altitudes and children of paths are walked, also with pauses."""
    config = TINY.replace(lanes=lanes, memory_latency=latency, altitude_bits=bits)
    rng = np.random.default_rng(lanes)
    cells = list(itertools.product(range(config.map_size), repeat=2))
    pairs = list(itertools.product(cells, repeat=2))
    with VerilatedWalker(config, rows) as chip:
        heights = heights_of(config, rng)
        chip.write(heights)
        altitudes = rng.integers(config.blocked_altitude + 1, size=(len(pairs), 2)).tolist()
        chords = [
            ((*a, low), (*b, high)) for (a, b), (low, high) in zip(pairs, altitudes, strict=True)
        ]
        paths = [
            WalkedPath([any_point(config, rng) for _ in range(4)], [None, *two, None], 0, 0)
            for two in zip(chords[::2], chords[1::2], strict=True)
        ]
        _, hits = check(chip, heights, paths)
        assert hits > len(pairs)

        for stall, heading in itertools.product((0, 3), range(4)):
            heights = heights_of(config, rng, blocked=0.02) // 2
            heights[rng.random(heights.shape) < 0.02] = config.blocked_altitude
            chip.write(heights)
            paths = random_paths(config, rng, 250, pool=8, heading=heading)
            share, hits = check(chip, heights, paths, stall=stall)
            assert hits > 0
            assert (share > 0) == (rows > 0)
            assert (share > 0.3) == (rows >= 64)


@pytest.mark.long
def test_more_lanes_than_corners_of_most_segments():
    config = TINY.replace(map_size=16, lanes=16, altitude_bits=9)
    rng = np.random.default_rng(16)
    with VerilatedWalker(config, 2) as chip:
        for stall in (0, 2):
            heights = heights_of(config, rng)
            chip.write(heights)
            paths = random_paths(config, rng, 400, heading=3)
            check(chip, heights, paths, stall=stall)


@pytest.mark.parametrize("paths", [1500, pytest.param(100_000, marks=pytest.mark.long)])
@pytest.mark.ci
@pytest.mark.parametrize("lanes", [8, pytest.param(16, marks=pytest.mark.long)])
def test_full_size(lanes, paths):
    config = USUAL.replace(lanes=lanes)
    rng = np.random.default_rng(lanes)
    with VerilatedWalker(config, 512) as chip:
        heights = ground(config, rng)
        chip.write(heights)
        drawn = random_paths(config, rng, paths, pool=60)
        share, hits = check(chip, heights, drawn)
        assert 0.3 < share < 0.9
        assert hits > 0
