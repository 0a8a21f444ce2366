"""The plans of the mutators: child, waypoint, its place in a parent, and their cycles."""

import random

from pathgene.hdl.ga_core.crossover import parents_of
from pathgene.hdl.ga_core.mutator import MutationPlan
from tests.support.gateware.streams import simulate


MUTATORS, CROSSOVERS, MAX_WAYPOINTS = 5, 3, 9
SIZES = {"mutators": MUTATORS, "crossovers": CROSSOVERS, "max_waypoints": MAX_WAYPOINTS}


def expected(child, draw, lengths):
    """Return the plan for one mutator from the definition of a child."""
    first, second = parents_of(child, CROSSOVERS)
    path = [(first, at) for at in range(lengths[first] // 2)]
    path += [(second, at) for at in range(lengths[second] // 2, lengths[second])]
    index = draw * len(path) >> 16
    parent, position = path[index]
    return {
        "child": child, "length": len(path), "index": index, "parent": parent, "position": position
    }  # fmt: skip


def test_plans_follow_one_per_cycle():
    """The plan of mutator ``i`` is valid ``i + 8`` cycles after ``start``."""
    dut = MutationPlan(**SIZES)

    async def bench(ctx):
        rng = random.Random(1)
        for _ in range(60):
            children = rng.sample(range(2 * CROSSOVERS), MUTATORS)
            draws = [rng.choice((0, 0xFFFF, rng.getrandbits(16))) for _ in range(MUTATORS)]
            lengths = [rng.randint(2, MAX_WAYPOINTS) for _ in range(CROSSOVERS)]
            ctx.set(dut.children, children)
            ctx.set(dut.draws, draws)
            for port, length in zip(dut.lengths, lengths, strict=True):
                ctx.set(port, length)
            ctx.set(dut.start, 1)
            seen = {}
            for cycle in range(MutationPlan.latency_of(MUTATORS) + 4):
                if ctx.get(dut.valid):
                    plan = ctx.get(dut.plan)
                    fields = ("child", "length", "index", "parent", "position")
                    seen[cycle] = ctx.get(dut.number), {name: plan[name] for name in fields}
                await ctx.tick()
                ctx.set(dut.start, 0)
            assert seen == {
                number + 8: (number, expected(child, draw, lengths))
                for number, (child, draw) in enumerate(zip(children, draws, strict=True))
            }
            assert max(seen) == MutationPlan.latency_of(MUTATORS)

    simulate(dut, bench)


def test_clear_in_every_cycle():
    dut = MutationPlan(**SIZES)

    async def bench(ctx):
        for cycles in range(MutationPlan.latency_of(MUTATORS)):
            ctx.set(dut.start, 1)
            for _ in range(cycles):
                await ctx.tick()
                ctx.set(dut.start, 0)
            ctx.set(dut.clear, 1)
            await ctx.tick()
            ctx.set(dut.start, 0)
            ctx.set(dut.clear, 0)
            for _ in range(MutationPlan.latency_of(MUTATORS) + 1):
                assert not ctx.get(dut.valid)
                await ctx.tick()

    simulate(dut, bench)
