"""One mutator: its plan, its cycles, limits on the length, record, patch, perturbed waypoint."""

import itertools
import random

import pytest

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.crossover import parents_of
from pathgene.hdl.ga_core.layouts import limits_layout, offset_layout
from pathgene.hdl.ga_core.mutator import MutationPlan, Mutator, WaypointPerturber
from pathgene.sim.model.mutation import clamp
from tests.support.gateware.streams import on, pulse, shared, simulate


MUTATORS, CROSSOVERS, MAX_WAYPOINTS = 5, 3, 9
PLAN_SIZES = {"mutators": MUTATORS, "crossovers": CROSSOVERS, "max_waypoints": MAX_WAYPOINTS}


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


@on(lambda: MutationPlan(**PLAN_SIZES))
async def test_plans_follow_one_per_cycle(ctx, dut):
    """The plan of mutator ``i`` is valid ``i + 8`` cycles after ``start``."""
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


@on(lambda: MutationPlan(**PLAN_SIZES))
async def test_clear_in_every_cycle(ctx, dut):
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


MUTATOR_SIZES = {
    "kind": MutationKind.INSERT,
    "crossovers": 3,
    "waypoint_bits": 12,
    "min_waypoints": 2,
    "max_waypoints": 5,
}
FORBIDDEN = {MutationKind.PERTURB: None, MutationKind.INSERT: 5, MutationKind.DELETE: 2}


@pytest.mark.parametrize("kind", MutationKind)
def test_records_with_store_alone(kind):
    """Every length is tried, with and without a new waypoint."""
    dut = shared(Mutator, **{**MUTATOR_SIZES, "kind": kind})
    makes = kind is not MutationKind.DELETE

    async def bench(ctx):
        before = (0, 0, 0)
        for length, made in itertools.product(range(2, 6), range(2)):
            allowed = length != FORBIDDEN[kind]
            applied = allowed and bool(made or not makes)
            ctx.set(dut.plan, {"child": length, "length": length, "index": 1})
            await pulse(ctx, dut.planned)
            ctx.set(dut.plan, {"child": 0, "length": 3, "index": 0})
            assert ctx.get(dut.allowed) == allowed
            if makes:
                ctx.set(dut.made, made)
                ctx.set(dut.waypoint, 100 + length)
            await ctx.tick()
            result = ctx.get(dut.result)
            assert (result.applied, result.child, result.index) == (applied, length, 1)
            record = ctx.get(dut.record)
            assert (record.applied, record.child, record.index) == before
            await pulse(ctx, dut.store)
            record = ctx.get(dut.record)
            before = (record.applied, record.child, record.index)
            assert before == (applied, length, 1)
            if makes:
                assert ctx.get(dut.patch) == (100 + length if applied else 0)

    simulate(dut, bench)


@pytest.mark.parametrize("kind", MutationKind)
def test_only_a_deleting_mutator_makes_no_waypoint(kind):
    dut = shared(Mutator, **{**MUTATOR_SIZES, "kind": kind})
    for name in ("made", "waypoint", "patch"):
        assert hasattr(dut, name) == (kind is not MutationKind.DELETE)


AXES = ("x", "y", "altitude")
PERTURBER_SIZES = {
    "crossovers": 3,
    "max_waypoints": 5,
    "limits_layout": limits_layout(4, 5),
    "offset_layout": offset_layout(box_cells=6, box_steps=20),
}


def test_moves_the_waypoint_of_its_plan_within_the_limits():
    """Every parent and position is tried, at the earliest 2 cycles after the last waypoint."""
    dut = shared(WaypointPerturber, **PERTURBER_SIZES)
    axes = PERTURBER_SIZES["limits_layout"]

    async def bench(ctx):
        rng = random.Random(1)
        for parent, position in itertools.product(range(3), range(5)):
            limits = {"x": rng.randrange(16), "y": rng.randrange(16), "altitude": rng.randrange(32)}
            offset = {
                "x": rng.randint(-6, 6),
                "y": rng.randint(-6, 6),
                "altitude": rng.randint(-20, 20),
            }
            ctx.set(dut.plan, {"parent": parent, "position": position})
            ctx.set(dut.limits, limits)
            ctx.set(dut.offset, offset)
            paths = [[rng.getrandbits(axes.size) for _ in range(5)] for _ in range(3)]
            ctx.set(dut.carrying, 1)
            for passing in range(5):
                ctx.set(dut.position, passing)
                for port, path in zip(dut.waypoints, paths, strict=True):
                    ctx.set(port, path[passing])
                await ctx.tick()
            ctx.set(dut.carrying, 0)
            # Without `carrying`, nothing passes.
            ctx.set(dut.position, position)
            await ctx.tick()
            base = axes.from_bits(paths[parent][position])
            moved = axes.from_bits(ctx.get(dut.moved))
            for axis in AXES:
                assert moved[axis] == clamp(base[axis] + offset[axis], limits[axis])

    simulate(dut, bench)
