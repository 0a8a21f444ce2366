# amaranth: UnusedElaboratable=no
"""One mutator: its plan, the limits on the length, its record and its patch."""

import itertools

import pytest

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.mutator import Mutator
from tests.support.gateware.streams import simulate


SIZES = {
    "kind": MutationKind.INSERT,
    "crossovers": 3,
    "waypoint_bits": 12,
    "min_waypoints": 2,
    "max_waypoints": 5,
}
FORBIDDEN = {MutationKind.PERTURB: None, MutationKind.INSERT: 5, MutationKind.DELETE: 2}


@pytest.mark.parametrize("kind", MutationKind)
def test_records_with_store_alone(kind):
    """Every length, with and without a new waypoint."""
    dut = Mutator(**{**SIZES, "kind": kind})
    makes = kind is not MutationKind.DELETE

    async def bench(ctx):
        before = (0, 0, 0)
        for length, made in itertools.product(range(2, 6), range(2)):
            allowed = length != FORBIDDEN[kind]
            applied = allowed and bool(made or not makes)
            ctx.set(dut.plan, {"child": length, "length": length, "index": 1})
            ctx.set(dut.planned, 1)
            await ctx.tick()
            ctx.set(dut.planned, 0)
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
            ctx.set(dut.store, 1)
            await ctx.tick()
            ctx.set(dut.store, 0)
            record = ctx.get(dut.record)
            before = (record.applied, record.child, record.index)
            assert before == (applied, length, 1)
            if makes:
                assert ctx.get(dut.patch) == (100 + length if applied else 0)

    simulate(dut, bench)


@pytest.mark.parametrize("kind", MutationKind)
def test_only_a_deleting_mutator_makes_no_waypoint(kind):
    dut = Mutator(**{**SIZES, "kind": kind})
    for name in ("made", "waypoint", "patch"):
        assert hasattr(dut, name) == (kind is not MutationKind.DELETE)
