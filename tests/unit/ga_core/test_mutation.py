"""The mutation unit compared with the model: plans, captured waypoints, limits, cycles."""

import random
from functools import partial

import pytest

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.ga_core.mutation import Mutation
from pathgene.hdl.protocol.breeding import crossover
from pathgene.sim.model.mutation import Limits
from pathgene.sim.model.mutation import Mutation as Model
from pathgene.sim.model.selection import Draws
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import as_test, shared, simulate


SMALL = TINY.replace(
    population=16, children=8, elites=3, survivors=5, perturbs=2, inserts=2, deletes=2,
    max_waypoints=5, box_percent=60,
)  # fmt: skip
CONFIGS = {
    "default": Config(checker=CheckerBuild.NONE),
    "small": SMALL,
    "shortest": SMALL.replace(max_waypoints=3),
    "all_children": SMALL.replace(perturbs=3, inserts=3, deletes=2),
    "longest": SMALL.replace(max_waypoints=20),
}


class Case:
    """Inputs of one generation, and the model's result."""

    def __init__(self, config, rng, *, length=None):
        def coordinate(box):
            return rng.choice((-box, box, rng.randint(-box, box)))

        self.limits = Limits(
            rng.randrange(config.map_size),
            rng.randrange(config.map_size),
            rng.randrange(config.blocked_altitude),
        )
        self.parents = [
            [
                rng.getrandbits(config.waypoint_bits)
                for _ in range(length or rng.randint(config.MIN_WAYPOINTS, config.max_waypoints))
            ]
            for _ in range(config.crossovers)
        ]
        self.draws = Draws(
            parents=(),
            survivors=(),
            children=tuple(rng.sample(range(config.children), config.mutators)),
            waypoints=tuple(
                rng.choice((0, 0xFFFF, rng.getrandbits(16))) for _ in range(config.mutators)
            ),
            offsets=tuple(
                (
                    coordinate(config.box_cells),
                    coordinate(config.box_cells),
                    coordinate(config.box_steps),
                )
                for _ in range(config.patches)
            ),
        )
        self.expected = Model(config).mutate(crossover(self.parents), self.draws, self.limits)


async def run(ctx, dut, case):
    """Run one generation; return the cycles from ``start`` to ``planned`` and of the mutation."""
    ctx.set(dut.children, list(case.draws.children))
    ctx.set(dut.draws, list(case.draws.waypoints))
    offsets = [dict(zip(("x", "y", "altitude"), each, strict=True)) for each in case.draws.offsets]
    ctx.set(dut.offsets, offsets)
    limits = {"x": case.limits.x, "y": case.limits.y, "altitude": case.limits.altitude}
    ctx.set(dut.limits, limits)
    for port, path in zip(dut.lengths, case.parents, strict=True):
        ctx.set(port, len(path))

    ctx.set(dut.start, 1)
    latency = 0
    while not ctx.get(dut.planned):
        await ctx.tick()
        ctx.set(dut.start, 0)
        latency += 1
        assert latency < 100

    for position in range(max(map(len, case.parents))):
        ctx.set(dut.carrying, 1)
        ctx.set(dut.position, position)
        for port, path in zip(dut.waypoints, case.parents, strict=True):
            ctx.set(port, path[position] if position < len(path) else 0)
        await ctx.tick()
    ctx.set(dut.carrying, 0)
    for port in dut.waypoints:
        ctx.set(port, 0)

    ctx.set(dut.on, 1)
    cycles = 0
    done = False
    while not done:
        done = ctx.get(dut.done)
        results = [ctx.get(mutation) for mutation in dut.results]
        await ctx.tick()
        cycles += 1
    ctx.set(dut.on, 0)
    assert [ctx.get(mutation) for mutation in dut.mutations] == results
    return latency, cycles


def check(ctx, dut, case):
    for mutation, mutated in zip(dut.mutations, case.expected, strict=True):
        done = ctx.get(mutation)
        assert (done.applied, done.child, done.index) == (
            mutated.applied,
            mutated.child,
            mutated.index,
        )
    assert [ctx.get(patch) for patch in dut.patches] == [
        mutated.waypoint for mutated in case.expected if mutated.kind is not MutationKind.DELETE
    ]
    assert ctx.get(dut.refused) == sum(not mutated.applied for mutated in case.expected)


def run_bench(config, bench):
    dut = shared(Mutation, config)

    async def testbench(ctx):
        await bench(ctx, dut)

    simulate(dut, testbench)


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
def test_matches_model(config):
    async def bench(ctx, dut):
        rng = random.Random(3)
        refused = set()
        for _ in range(12):
            case = Case(config, rng)
            latency, cycles = await run(ctx, dut, case)
            check(ctx, dut, case)
            assert latency == dut.latency == config.mutators + 8
            assert cycles == 2
            refused |= {mutated.kind for mutated in case.expected if not mutated.applied}
        assert MutationKind.PERTURB not in refused

    run_bench(config, bench)


@pytest.mark.parametrize(
    ("length", "kind"),
    [(SMALL.MIN_WAYPOINTS, MutationKind.DELETE), (SMALL.max_waypoints, MutationKind.INSERT)],
)
@as_test(partial(run_bench, SMALL))
async def test_limits_on_the_length(ctx, dut, length, kind):
    """Parents of equal length have children of that length: every such mutation is refused."""
    case = Case(SMALL, random.Random(4), length=length)
    await run(ctx, dut, case)
    check(ctx, dut, case)
    applied = [bool(ctx.get(mutation.applied)) for mutation in dut.mutations]
    assert applied == [other is not kind for other in SMALL.mutations]
    assert ctx.get(dut.refused) == 2


@as_test(partial(run_bench, SMALL))
async def test_clear_stops_a_plan(ctx, dut):
    case = Case(SMALL, random.Random(5))
    for cycles in range(dut.latency):
        ctx.set(dut.start, 1)
        for _ in range(cycles):
            await ctx.tick()
            ctx.set(dut.start, 0)
        ctx.set(dut.clear, 1)
        await ctx.tick()
        ctx.set(dut.start, 0)
        ctx.set(dut.clear, 0)
        for _ in range(dut.latency + 2):
            assert not ctx.get(dut.planned)
            await ctx.tick()
    latency, _ = await run(ctx, dut, case)
    assert latency == dut.latency
    check(ctx, dut, case)


@as_test(partial(run_bench, SMALL))
async def test_results_stay_while_the_next_are_planned(ctx, dut):
    rng = random.Random(6)
    case, following = Case(SMALL, rng), Case(SMALL, rng)
    await run(ctx, dut, case)
    ctx.set(dut.children, list(following.draws.children))
    ctx.set(dut.draws, list(following.draws.waypoints))
    ctx.set(dut.start, 1)
    for _ in range(dut.latency + 2):
        await ctx.tick()
        ctx.set(dut.start, 0)
        check(ctx, dut, case)
