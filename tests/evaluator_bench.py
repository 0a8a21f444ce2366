"""Driver of the evaluator of paths in the Amaranth simulator."""

import itertools
from dataclasses import dataclass, field

from tests.scorer_cases import problem_fields
from tests.streams import put, simulate
from tests.walker_cases import corner, upload


__all__ = ["Findings", "run"]


@dataclass
class Findings:
    """What came out of the evaluator, and when: cycles are even in the first one of a slot.

    Attributes
    ----------
    members : list of (key, slot, length)
    margins : list of (slot, index, margin)
    offered, goals, keyed : list of int
        Of each path: cycle in which its first point is offered, its goal taken, its key taken.
    walk : int
    """

    members: list = field(default_factory=list)
    margins: list = field(default_factory=list)
    offered: list = field(default_factory=list)
    goals: list = field(default_factory=list)
    keyed: list = field(default_factory=list)
    walk: int = 0


def run(dut, evaluator, paths, *, key_pauses=(0,), margin_pauses=(0,), background=()):
    """Return what an evaluator finds of paths, each part of it as far as it is ready for it."""
    found = Findings()
    ready = [_pattern(key_pauses), _pattern(margin_pauses)]

    async def heads(ctx):
        for path in paths:
            head = {"slot": path.slot, "first": path.first, "limited": path.limit is not None}
            await put(ctx, dut.paths, head | {"limit": path.limit or 0})

    async def bench(ctx):
        await upload(ctx, dut, evaluator.ground)
        ctx.set(dut.problem, problem_fields(evaluator.record))
        ctx.set(dut.clear_counters, 1)
        await ctx.tick()
        ctx.set(dut.clear_counters, 0)
        while ctx.get(dut.busy):
            await ctx.tick()
        cycle, offers = 0, _offers(paths)
        wait, point = next(offers)
        is_offered = False
        while len(found.members) < len(paths) or not ctx.get(dut.idle):
            ctx.set(dut.phase, cycle & 1)
            offering = point is not None and wait == 0
            ctx.set(dut.points.valid, offering)
            if offering:
                ctx.set(dut.points.p, corner(point[1]) | {"last": point[2]})
                if point[0] and not is_offered:
                    found.offered.append(cycle)
                is_offered = True
            ctx.set(dut.evaluated.ready, next(ready[0]))
            ctx.set(dut.margins.ready, next(ready[1]))
            if ctx.get(dut.points.valid & dut.points.ready):
                if point[2]:
                    found.goals.append(cycle)
                wait, point = next(offers, (0, None))
                is_offered = False
            elif wait:
                wait -= 1
            if ctx.get(dut.evaluated.valid & dut.evaluated.ready):
                member = ctx.get(dut.evaluated.p)
                found.members.append((member.key, member.slot, member.length))
                found.keyed.append(cycle)
            if ctx.get(dut.margins.valid & dut.margins.ready):
                margin = ctx.get(dut.margins.p)
                found.margins.append((margin.place.slot, margin.place.index, margin.margin))
            await ctx.tick()
            cycle += 1
            assert cycle < 200_000
        found.walk = ctx.get(dut.walk)

    simulate(dut, bench, background=[heads, *background])
    return found


def _pattern(pauses):
    """Yield 0 for the cycles of each pause, then 1."""
    for pause in itertools.cycle(pauses):
        yield from itertools.repeat(0, pause)
        yield 1


def _offers(paths):
    """Yield each point as (is first, point, is last), with the cycles to wait before it."""
    for path in paths:
        gaps = itertools.cycle(path.gaps)
        for i, point in enumerate(path.points):
            yield next(gaps) if i else path.gap, (i == 0, point, i == len(path.points) - 1)
