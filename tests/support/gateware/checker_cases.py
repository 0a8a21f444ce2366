"""Ground, paths, an independent check and a driver for the tests of the collision checker."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.model.checker import TerrainModel, check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from pathgene.sim.model.checker_kernels import Batch, Verdicts, check_paths
from tests.support.gateware.streams import collect, put, simulate


#: A map small enough to test every segment.
TINY = Config(
    max_waypoints=4,
    map_size=8,
    coarse_factor=2,
    altitude_bits=4,
    checker=CheckerBuild.TWO_TIER,
    lanes=1,
)
FULL = Config(checker=CheckerBuild.TWO_TIER, lanes=1)

_PLACE = ("collision", "segment", "x", "y", "coarse", "cells")

BUILDS = tuple(build for build in CheckerBuild if build is not CheckerBuild.NONE)


def ground(config, rng, *, peaks=0.002, blocked=0.001):
    """Return low rough ground with scattered peaks and blocked cells."""
    edge, top = config.map_size, config.blocked_altitude
    heights = rng.integers(0, top // 4 + 1, (edge, edge))
    scattered = rng.random((edge, edge))
    heights[scattered < peaks] = rng.integers(top // 2, top, np.count_nonzero(scattered < peaks))
    heights[scattered > 1 - blocked] = top
    terrain = TerrainModel(config)
    terrain.write(0, 0, heights)
    return terrain


def random_batch(config, rng, paths, points=None):
    """Return random paths of ``points`` points, by default of any number, some segments short."""
    most = config.max_waypoints + 2
    lengths = np.full(paths, points) if points else rng.integers(2, most + 1, paths)
    total, edge, top = int(lengths.sum()), config.map_size, config.blocked_altitude
    drawn = np.stack([rng.integers(0, edge, total), rng.integers(0, edge, total)], axis=1)
    # About a third of the points stay near their predecessors.
    near = rng.integers(-2, 3, (total, 2)) + np.roll(drawn, 1, axis=0)
    drawn = np.where(rng.random((total, 1)) < 1 / 3, near.clip(0, edge - 1), drawn)
    altitudes = rng.integers(top // 4, top + 1, (total, 1))
    bounds = np.concatenate([[0], np.cumsum(lengths)])
    return Batch(np.concatenate([drawn, altitudes], axis=1), bounds)


def paths_of(batch):
    """Return the paths of a batch in the form of :func:`pathgene.sim.model.checker.check_path`."""
    points = [tuple(point) for point in batch.points.tolist()]
    return [points[i:j] for i, j in zip(batch.bounds[:-1], batch.bounds[1:], strict=True)]


def drawn(config, seed, paths, *, peaks=0.02, blocked=0.01):
    """Return ground and paths."""
    rng = np.random.default_rng(seed)
    terrain = ground(config, rng, peaks=peaks, blocked=blocked)
    return terrain, paths_of(random_batch(config, rng, paths))


def closed_form(config, terrain, batch):
    """Check a batch by the formula, all cells at once, independently of :func:`check_batch`.

    Memory is proportional to the number of cells.
    """
    number = np.diff(batch.bounds)
    path = np.repeat(np.arange(len(batch)), number - 1)
    first = np.arange(len(path)) + path  # First point of each segment.
    segment = first - batch.bounds[path]
    is_coarse = (config.checker is CheckerBuild.TWO_TIER) & (segment >= config.DETAILED_SEGMENTS)
    factor = np.where(is_coarse, config.coarse_factor, 1)[:, None]
    (x0, y0), (x1, y1) = ((batch.points[at, :2] // factor).T for at in (first, first + 1))
    z0, z1 = batch.points[first, 2], batch.points[first + 1, 2]
    n = np.maximum(np.abs(x1 - x0), np.abs(y1 - y0))
    z0 = np.where(n == 0, np.minimum(z0, z1), z0)
    n1 = np.maximum(n, 1)

    begin = np.concatenate([[0], np.cumsum(n + 1)])
    of = np.repeat(np.arange(len(n)), n + 1)
    k = np.arange(begin[-1]) - begin[of]
    x = x0[of] + (2 * k * (x1 - x0)[of] + n1[of]) // (2 * n1[of])
    y = y0[of] + (2 * k * (y1 - y0)[of] + n1[of]) // (2 * n1[of])
    edge = len(terrain.coarse)
    coarse_height = terrain.coarse[np.minimum(y, edge - 1), np.minimum(x, edge - 1)]
    height = np.where(is_coarse[of], coarse_height, terrain.heights[y, x]).astype(np.int64)
    hit = z0[of] * n1[of] + k * (z1 - z0)[of] <= height * n1[of]

    is_blocked = height == config.blocked_altitude
    colliding = np.stack(
        [np.bincount(of[hit & kind], minlength=len(n)) for kind in (~is_blocked, is_blocked)],
        axis=1,
    )
    path_begin = begin[batch.bounds[:-1] - np.arange(len(batch))]
    at = np.minimum.reduceat(np.where(hit, np.arange(len(hit)), len(hit)), path_begin)
    collision = at < len(hit)
    at = np.where(collision, at, 0)

    def where_hit(values):
        return np.where(collision, values[at], 0)

    path_end = np.append(path_begin[1:], begin[-1])
    return Verdicts(
        collision=collision,
        segment=where_hit(segment[of]),
        x=where_hit(x),
        y=where_hit(y),
        coarse=where_hit(is_coarse[of]).astype(bool),
        cells=np.where(collision, at + 1, path_end) - path_begin,
        colliding=colliding,
    )


def assert_same(one, other):
    """Assert that two :class:`Verdicts` are equal, except for counts that one of them lacks."""
    for name in ("collision", "segment", "x", "y", "coarse", "cells"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    if one.colliding is not None and other.colliding is not None:
        assert np.array_equal(one.colliding, other.colliding)


@dataclass
class Results:
    """Verdicts, counts, and the cycle in which each verdict was first offered; 1 is the first."""

    verdicts: list = field(default_factory=list)
    counts: list = field(default_factory=list)
    offered: list = field(default_factory=list)

    @property
    def summaries(self):
        """The model's verdict of each path."""
        counts = iter([(count.segment, count.terrain, count.nofly) for count in self.counts])
        return [
            (*place_of(verdict), tuple(itertools.islice(counts, verdict.entries)))
            for verdict in self.verdicts
        ]

    @property
    def costs(self):
        """``cycles`` and ``reads`` of each path."""
        return [(verdict.cycles, verdict.reads) for verdict in self.verdicts]


def place_of(verdict):
    """Return the fields that verdicts of the checker and of the model share."""
    return tuple(getattr(verdict, name) for name in _PLACE)


def defined(config, terrain, paths, count=False):
    """Return the verdicts of the definition."""
    return [check_path(config, terrain, path, count) for path in paths]


def expected(config, terrain, paths, count=False, model=defined):
    """Return a model's verdicts, in the form of :attr:`Results.summaries`."""
    verdicts = model(config, terrain, paths, count)
    return [(*place_of(verdict), verdict.entries) for verdict in verdicts]


def check_verilated(checker, terrain, paths, count=False, stall=0, *, model=check_paths):
    """Compare a batch of a Verilated checker with a model, its costs too unless it stalls.

    Return the batch.
    """
    batch = checker.check(paths, count=count, stall=stall)
    found = [
        (
            *(verdict[name] for name in _PLACE),
            tuple((entry["segment"], entry["terrain"], entry["nofly"]) for entry in entries),
        )
        for verdict, entries in zip(batch.verdicts, batch.entries, strict=True)
    ]
    wanted = expected(checker.config, terrain, paths, count, model)
    for path, one, other in zip(paths, found, wanted, strict=True):
        assert one == other, path
    if not stall:
        costs = [(verdict["cycles"], verdict["reads"]) for verdict in batch.verdicts]
        assert costs == batch_cycles(checker.config, terrain, paths, count)
    return batch


async def upload(ctx, dut, heights, x=0, y=0):
    """Write a rectangle of the map, [y, x]."""
    cells = [
        {"x": x + column, "y": y + row, "altitude": int(altitude), "last": 0}
        for row, altitudes in enumerate(heights)
        for column, altitude in enumerate(altitudes)
    ]
    cells[-1]["last"] = 1
    for cell in cells:
        await put(ctx, dut.writes, cell)


async def feed(ctx, dut, path):
    """Give the checker the points of a path."""
    for number, (x, y, altitude) in enumerate(path):
        last = number == len(path) - 1
        await put(ctx, dut.points, {"x": x, "y": y, "altitude": altitude, "last": last})


async def look_up(ctx, dut, cells):
    """Return the altitudes of ``cells``, looked up one per cycle."""
    found = []
    latency = dut.config.lookup_latency
    for cycle in range(len(cells) + latency):
        if cycle >= latency:
            found.append(ctx.get(dut.lookup_altitude))
        ctx.set(dut.lookup_valid, cycle < len(cells))
        if cycle < len(cells):
            ctx.set(dut.lookup_x, cells[cycle][0])
            ctx.set(dut.lookup_y, cells[cycle][1])
        await ctx.tick()
    return found


def results_of(dut, terrain, paths, *, count=False, alone=False, pauses=(0,), count_pauses=(0,)):
    """Check ``paths``, queued or each ``alone``; verdicts and counts are taken with pauses."""
    results = Results()

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        ctx.set(dut.count, count)
        for number, path in enumerate(paths, start=1):
            await feed(ctx, dut, path)
            while alone and len(results.verdicts) < number:
                await ctx.tick()
        while len(results.verdicts) < len(paths):
            await ctx.tick()
        while ctx.get(dut.counts.valid):
            await ctx.tick()
        assert not ctx.get(dut.busy)

    async def watch(ctx):
        cycle = 0
        begun = waiting = False
        while True:
            _, _, taken, valid, ready = await ctx.tick().sample(
                dut.points.valid & dut.points.ready, dut.verdicts.valid, dut.verdicts.ready
            )
            begun |= bool(taken)
            cycle += begun
            if valid and not waiting:
                results.offered.append(cycle)
            waiting = valid and not ready

    collectors = [
        collect(dut.verdicts, results.verdicts, pauses),
        collect(dut.counts, results.counts, count_pauses),
    ]
    simulate(dut, bench, background=[*collectors, watch])
    return results
