"""A checker in Amaranth's simulator: its map, its queue of paths, and the results."""

import itertools
from dataclasses import dataclass, field

from tests.support.gateware.streams import collect, put, simulate


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
            (
                bool(verdict.collision),
                verdict.segment,
                verdict.x,
                verdict.y,
                bool(verdict.coarse),
                verdict.cells,
                tuple(itertools.islice(counts, verdict.entries)),
            )
            for verdict in self.verdicts
        ]

    @property
    def costs(self):
        """``cycles`` and ``reads`` of each path."""
        return [(verdict.cycles, verdict.reads) for verdict in self.verdicts]


def summary(verdict):
    """The same for a verdict of the model."""
    return (
        verdict.collision,
        verdict.segment,
        verdict.x,
        verdict.y,
        verdict.coarse,
        verdict.cells,
        verdict.entries,
    )


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

    async def verdicts(ctx):
        await collect(ctx, dut.verdicts, results.verdicts, pauses)

    async def counts(ctx):
        await collect(ctx, dut.counts, results.counts, count_pauses)

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

    simulate(dut, bench, background=[verdicts, counts, watch])
    return results
