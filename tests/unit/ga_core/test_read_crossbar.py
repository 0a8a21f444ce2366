# amaranth: UnusedElaboratable=no
"""The read ports of the population: choice of a slot, its delay, and writes of the host."""

import random

import pytest

from pathgene.hdl.ga_core.read_ports import ReadCrossbar
from tests.support.gateware.streams import simulate


POPULATION, WAYPOINT_BITS = 8, 13
SIZES = {"ports": 6, "population": POPULATION, "waypoint_bits": WAYPOINT_BITS}


async def pass_new(ctx, dut, rng):
    """Give every slot another waypoint, pass a cycle, and return these waypoints."""
    given = [rng.getrandbits(WAYPOINT_BITS) for _ in dut.slots]
    for slot, waypoint in zip(dut.slots, given, strict=True):
        ctx.set(slot, waypoint)
    await ctx.tick()
    return given


def test_waypoints_follow_the_choice_a_cycle_later():
    dut = ReadCrossbar(**SIZES)

    async def bench(ctx):
        rng = random.Random(1)
        ctx.set(dut.step, 1)
        chosen = {}
        for _ in range(40):
            chosen, before = [rng.randrange(POPULATION) for _ in dut.selects], chosen
            for select, slot in zip(dut.selects, chosen, strict=True):
                ctx.set(select, 1 << slot)
            for cycle in range(3):
                given = await pass_new(ctx, dut, rng)
                slots = before if cycle == 0 else chosen
                for port, slot in zip(dut.waypoints, slots, strict=bool(slots)):
                    assert ctx.get(port) == given[slot]

    simulate(dut, bench)


def test_a_port_without_a_choice_passes_0():
    dut = ReadCrossbar(**SIZES)

    async def bench(ctx):
        rng = random.Random(2)
        ctx.set(dut.step, 1)
        for _ in range(5):
            await pass_new(ctx, dut, rng)
            assert not any(ctx.get(port) for port in dut.waypoints)

    simulate(dut, bench)


@pytest.mark.parametrize("step", [0, 1])
def test_the_first_port_waits_for_a_step_and_all_take_writes(step):
    dut = ReadCrossbar(**SIZES)

    async def bench(ctx):
        rng = random.Random(3)
        ctx.set(dut.step, 1)
        for number, select in enumerate(dut.selects):
            ctx.set(select, 1 << number)
        for _ in range(4):
            await pass_new(ctx, dut, rng)
        held = ctx.get(dut.waypoints[0])
        ctx.set(dut.step, step)
        for _ in range(3):
            given = await pass_new(ctx, dut, rng)
            assert ctx.get(dut.waypoints[0]) == (given[0] if step else held)
            assert [ctx.get(port) for port in dut.waypoints[1:]] == given[1 : len(dut.waypoints)]

        for part in dut.writing:
            ctx.set(part, 1)
        ctx.set(dut.written, 0x123)
        await pass_new(ctx, dut, rng)
        assert {ctx.get(port) for port in dut.waypoints} == {0x123}

    simulate(dut, bench)


@pytest.mark.parametrize(("ports", "parts"), [(1, 1), (3, 1), (4, 2), (6, 2), (20, 7)])
def test_three_ports_share_a_register(ports, parts):
    assert ReadCrossbar.parts_of(ports) == parts
    assert len(ReadCrossbar(**{**SIZES, "ports": ports}).writing) == parts
