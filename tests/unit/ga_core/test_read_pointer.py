# amaranth: UnusedElaboratable=no
"""Positions read in lock step, followed through the registers after them."""

import random

import pytest

from pathgene.hdl.ga_core.read_ports import PEEK_LATENCY, ReadPointer
from tests.support.gateware.streams import simulate


MAX_WAYPOINTS = 16
SIZES = {"max_waypoints": MAX_WAYPOINTS, "parts": 3, "peeks": True}
#: Maximum cycles from a change of the population to its first waypoints.
SETTLING = 4


class Registers:
    """Model of the index, the slots and the ports; each holds a position."""

    def __init__(self, ctx, dut):
        self.ctx, self.dut = ctx, dut
        self.index = self.slot = self.port = None

    async def tick(self, *names):
        """Raise inputs for a cycle."""
        ctx, dut = self.ctx, self.dut
        for name in names:
            for port in dut.begin if name == "begin" else [getattr(dut, name)]:
                ctx.set(port, 1)
        advance = {ctx.get(part) for part in dut.advance}
        assert len(advance) == 1
        step, ahead = ctx.get(dut.step), ctx.get(dut.ahead)
        await ctx.tick()
        if step:
            self.port = self.slot
        if advance.pop():
            self.slot, self.index = self.index, ahead
        for name in names:
            for port in dut.begin if name == "begin" else [getattr(dut, name)]:
                ctx.set(port, 0)

    async def settle(self, most=SETTLING):
        """Wait for the first waypoints; return the cycles."""
        for cycles in range(most + 1):
            if self.ctx.get(self.dut.primed):
                assert (self.slot, self.index, self.ctx.get(self.dut.ahead)) == (0, 1, 2)
                return cycles
            await self.tick()
        raise TimeoutError("The first waypoints are not read")


@pytest.mark.parametrize("cause", ["rewinds", "update", "taken"])
def test_the_first_waypoints_are_read_again(cause):
    dut = ReadPointer(**SIZES)

    async def bench(ctx):
        rng = random.Random(1)
        registers = Registers(ctx, dut)
        await registers.settle()
        for _ in range(30):
            for _ in range(rng.randrange(MAX_WAYPOINTS)):
                await registers.tick("passes")
            await registers.tick(cause)
            # Waypoints read before the length and the index have changed are useless.
            assert not ctx.get(dut.primed)
            if cause == "taken":
                await registers.tick("writing")
            await registers.tick()
            await registers.settle()

    simulate(dut, bench)


def test_a_crossover_takes_one_position_per_cycle():
    dut = ReadPointer(**SIZES)

    async def bench(ctx):
        rng = random.Random(2)
        registers = Registers(ctx, dut)
        for _ in range(20):
            await registers.settle()
            longest = rng.randint(2, MAX_WAYPOINTS)
            await registers.tick("begin")
            for position in range(longest):
                await registers.tick(*["passes"] * (position < longest - 1))
                assert registers.port == position
            for _ in range(rng.randrange(3)):
                await registers.tick()
                assert registers.port == longest - 1
            await registers.tick("update")

    simulate(dut, bench)


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_peeks(count):
    dut = ReadPointer(**SIZES)

    async def bench(ctx):
        rng = random.Random(count)
        registers = Registers(ctx, dut)
        for _ in range(20):
            await registers.settle()
            positions = [rng.randrange(MAX_WAYPOINTS) for _ in range(count)]
            seen = []
            for cycle in range(count + PEEK_LATENCY - 1):
                if cycle < count:
                    ctx.set(dut.peek_position, positions[cycle])
                assert ctx.get(dut.peeking) == (cycle > 0)
                await registers.tick(*["peek"] * (cycle < count))
                assert not ctx.get(dut.primed)
                if cycle >= PEEK_LATENCY - 1:
                    seen.append(registers.port)
            assert seen == positions
            assert not ctx.get(dut.peeking)
            assert await registers.settle() <= 6 - PEEK_LATENCY + 1

    simulate(dut, bench)


def test_members_for_peeks():
    assert hasattr(ReadPointer(**SIZES), "peek")
    assert not hasattr(ReadPointer(**{**SIZES, "peeks": False}), "peek")
