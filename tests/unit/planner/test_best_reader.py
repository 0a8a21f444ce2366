"""Best paths as bytes of the protocol, the first members of each key."""

import numpy as np
import pytest

from pathgene.hdl.planner.best_reader import BestReader
from pathgene.hdl.protocol.runs import RETURNED, pack_best
from tests.support.gateware.streams import collect, pulse, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.population import corner, population


def packed(config, waypoint):
    bits = config.coordinate_bits
    return waypoint.x | waypoint.y << bits | waypoint.z << 2 * bits


@pytest.mark.parametrize("pauses", [(0,), (0, 3, 1)], ids=["steady", "stalled"])
@pytest.mark.parametrize(
    ("config", "keys"),
    [(SMALL, 8), (SMALL, 3), (SMALL, 1), (USUAL, 20), (USUAL, 9), (USUAL, 8), (LARGE, 5)],
)
@pytest.mark.parametrize("count", [RETURNED, 2, 1])
def test_bytes_of_the_best(config, keys, pauses, count):
    """They are read twice, because reading changes nothing."""
    rng = np.random.default_rng(keys)
    slots = config.population + 5
    dut = BestReader(
        slots,
        config.population,
        config.max_waypoints,
        config.coordinate_bits,
        config.altitude_bits,
    )
    order = rng.permutation(slots)[: config.population].tolist()
    paths = population(config, rng)
    different = sorted(rng.choice(1 << 30, keys, replace=False).tolist())
    # Each occurs, the first and the last often more than once.
    ranks = sorted([*range(keys), *rng.integers(keys, size=config.population - keys).tolist()])
    firsts = [ranks.index(number) for number in range(keys)][:count]
    expected = pack_best(
        config,
        [[packed(config, waypoint) for waypoint in paths[rank]] for rank in firsts],
        different[:count],
    )
    rows = dict(zip(order, paths, strict=True))
    records, cycles = [], []

    async def memory(ctx):
        read = [(0, 0)] * 2
        async for _, _, rank, slot, index in ctx.tick().sample(
            dut.rank, dut.read.slot, dut.read.index
        ):
            member = {
                "key": different[ranks[rank]],
                "slot": order[rank],
                "length": len(paths[rank]),
            }
            ctx.set(dut.member, member)
            read.append((slot, index))
            slot, index = read[-2]
            if index < len(rows.get(slot, ())):
                each = rows[slot][index]
                ctx.set(dut.waypoint, {**corner(each[:3]), "margin": each.margin})

    async def bench(ctx):
        ctx.set(dut.count, count)
        await ctx.tick().repeat(3)
        for _ in range(2):
            records.clear()
            assert not ctx.get(dut.busy)
            assert ctx.get(dut.rank) == 0
            await pulse(ctx, dut.best)
            cycles.append(0)
            while ctx.get(dut.busy):
                await ctx.tick()
                cycles[-1] += 1
                assert cycles[-1] < 20_000
            await ctx.tick()
            assert bytes(record.data for record in records) == expected
            assert [record.last for record in records] == [0] * (len(expected) - 1) + [1]

    simulate(dut, bench, background=[memory, collect(dut.records, records, pauses)])
    if pauses == (0,):
        # All members are read, unless there are enough paths.
        seen = firsts[-1] if len(firsts) == count else config.population - 1
        waypoints = sum(len(paths[rank]) for rank in firsts)
        assert cycles == [len(expected) + len(firsts) + 3 * waypoints + 5 * seen + 2] * 2
