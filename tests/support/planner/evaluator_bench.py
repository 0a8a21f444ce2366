"""Driver of the path evaluator in the Amaranth simulator."""

import itertools
from dataclasses import dataclass, field

from amaranth.hdl import Cat

from tests.support.gateware.streams import pulse, resettable, simulate
from tests.support.planner.cases import corner, upload
from tests.support.planner.scorer_cases import problem_fields


#: Cycles in which only heads are offered.
AHEAD = 3


@dataclass
class Findings:
    """Outputs of the evaluator with their cycles; slots begin in even cycles.

    Attributes
    ----------
    members : list of (key, slot, length)
    decisions : list of (slot, walked)
    margins : list of (slot, index, margin)
    offered, goals, keyed : list of int
        Cycles in which each path's first point is offered, its goal taken, and its key taken.
    decided, written : list of int
        Cycles of the decisions and of the margins.
    idle : int
        First cycle in which the evaluator was idle again.
    """

    members: list = field(default_factory=list)
    decisions: list = field(default_factory=list)
    margins: list = field(default_factory=list)
    offered: list = field(default_factory=list)
    goals: list = field(default_factory=list)
    keyed: list = field(default_factory=list)
    decided: list = field(default_factory=list)
    written: list = field(default_factory=list)
    idle: int = 0
    walk: int = 0


def run(dut, evaluator, paths, pauses=(0,), *, resets=()):
    """Return the findings of an evaluator on paths, after a reset in each cycle of ``resets``.

    The paths are offered again after a reset. ``pauses`` are the cycles before keys are taken,
    repeated.
    """
    top, reset = resettable(dut)
    found = None

    async def bench(ctx):
        nonlocal found
        await upload(ctx, dut, evaluator.ground)
        ctx.set(dut.problem, problem_fields(evaluator.record))
        for reset_at in (*resets, None):
            await pulse(ctx, dut.clear_counters)
            while ctx.get(dut.busy):
                await ctx.tick()
            found = await _drive(ctx, dut, paths, pauses, reset_at)
            if reset_at is not None:
                ctx.set(dut.paths.valid, 0)
                ctx.set(dut.points.valid, 0)
                await pulse(ctx, reset)

    simulate(top, bench)
    return found


async def _drive(ctx, dut, paths, pauses, reset_at):
    """Offer paths, and take all outputs until the evaluator is idle, or until a reset."""
    found, heads, offers = Findings(), iter(paths), _offers(paths)
    keys = _pattern(pauses)
    moved = Cat(each.valid & each.ready for each in (dut.paths, dut.points, dut.evaluated))
    seen = moved, dut.evaluated.p, dut.decided, dut.margin, dut.idle, dut.walk
    _offer_head(ctx, dut, next(heads))
    wait, point = next(offers)
    for cycle in range(200_000):
        if cycle == reset_at:
            return found
        ctx.set(dut.phase, cycle & 1)
        if wait == 0 and point is not None:
            ctx.set(dut.points.valid, 1)
            ctx.set(dut.points.p, corner(point[1]) | {"last": point[2]})
            if point[0]:
                found.offered.append(cycle)
        ctx.set(dut.evaluated.ready, next(keys))

        *_, moves, member, decision, margin, idle, walk = await ctx.tick().sample(*seen)
        if moves & 1:
            _offer_head(ctx, dut, next(heads, None))
        wait -= 1
        if moves & 2:
            if point[2]:
                found.goals.append(cycle)
            wait, point = next(offers, (0, None))
            ctx.set(dut.points.valid, 0)
        if moves & 4:
            found.members.append((member.key, member.slot, member.length))
            found.keyed.append(cycle)
        if decision.valid:
            found.decisions.append((decision.slot, decision.walked))
            found.decided.append(cycle)
        if margin.valid:
            found.margins.append((margin.place.slot, margin.place.index, margin.margin))
            found.written.append(cycle)
        if cycle and idle:
            found.idle, found.walk = cycle, walk
            return found
    raise TimeoutError("The evaluator does not end")


def _offer_head(ctx, dut, path):
    ctx.set(dut.paths.valid, path is not None)
    if path is not None:
        ctx.set(dut.paths.p, path.head)


def _pattern(pauses):
    """Yield 0 for the cycles of each pause, then 1."""
    for pause in itertools.cycle(pauses):
        yield from itertools.repeat(0, pause)
        yield 1


def _offers(paths):
    """Yield the cycles to wait before each point, and (is first, point, is last)."""
    for number, path in enumerate(paths):
        gaps = itertools.cycle(path.gaps)
        first_gap = path.gap if number else path.gap + AHEAD
        for i, point in enumerate(path.points):
            yield next(gaps) if i else first_gap, (i == 0, point, i == len(path.points) - 1)
