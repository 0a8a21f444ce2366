"""The read ports of the population: positions, choice of a slot, delays, paths as streams."""

import random

import pytest

from pathgene.hdl.ga_core.read_ports import (
    PEEK_LATENCY,
    PathReader,
    PositionCounter,
    ReadCrossbar,
    ReadPointer,
)
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import on, shared, simulate


@pytest.mark.parametrize("most", [3, 6, 16, 20])
def test_as_many_cycles_as_the_longest_path_has_waypoints(most):
    dut = shared(PositionCounter, ports=21, max_waypoints=most)

    async def bench(ctx):
        rng = random.Random(most)
        for longest in [2, most, 2, *range(2, most + 1)]:
            lengths = [rng.randint(2, longest) for _ in dut.lengths]
            lengths[rng.randrange(len(lengths))] = longest
            for port, length in zip(dut.lengths, lengths, strict=True):
                ctx.set(port, length)
            # Nothing is read before `begin`.
            for _ in range(rng.randint(1, 3)):
                assert not ctx.get(dut.goes_on)
                await ctx.tick()
                assert not ctx.get(dut.running)
                assert not ctx.get(dut.done)
            ctx.set(dut.begin, 1)
            assert not ctx.get(dut.goes_on)
            await ctx.tick()
            ctx.set(dut.begin, 0)
            for cycle in range(longest):
                assert ctx.get(dut.running)
                assert ctx.get(dut.following) == cycle
                assert ctx.get(dut.carrying) == (cycle > 0)
                assert ctx.get(dut.position) == max(0, cycle - 1)
                assert ctx.get(dut.goes_on) == (cycle < longest - 1)
                assert not ctx.get(dut.done)
                await ctx.tick()
            assert not ctx.get(dut.running)
            assert ctx.get(dut.carrying)
            assert ctx.get(dut.position) == longest - 1
            assert ctx.get(dut.done)
            await ctx.tick()

    simulate(dut, bench)


MAX_WAYPOINTS = 16
POINTER_SIZES = {"max_waypoints": MAX_WAYPOINTS, "parts": 3, "peeks": True}
#: Maximum cycles from a change of the population to its first waypoints.
SETTLING = 4


class Registers:
    """Model of the index, the slots and the ports; each holds a position."""

    def __init__(self, ctx, dut):
        self.ctx, self.dut = ctx, dut
        self.index = self.slot = self.port = None

    async def tick(self, *names):
        """Raise inputs for one cycle."""
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
@on(lambda: ReadPointer(**POINTER_SIZES))
async def test_the_first_waypoints_are_read_again(ctx, dut, cause):
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


@on(lambda: ReadPointer(**POINTER_SIZES))
async def test_a_crossover_takes_one_position_per_cycle(ctx, dut):
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


@pytest.mark.parametrize("count", [1, 2, 3, 7])
@on(lambda: ReadPointer(**POINTER_SIZES))
async def test_peeks(ctx, dut, count):
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


def test_members_for_peeks():
    assert hasattr(ReadPointer(**POINTER_SIZES), "peek")
    assert not hasattr(ReadPointer(**{**POINTER_SIZES, "peeks": False}), "peek")


POPULATION, WAYPOINT_BITS = 8, 13
CROSSBAR_SIZES = {"ports": 6, "population": POPULATION, "waypoint_bits": WAYPOINT_BITS}


async def pass_new(ctx, dut, rng):
    """Give every slot a new waypoint, advance one cycle, and return these waypoints."""
    given = [rng.getrandbits(WAYPOINT_BITS) for _ in dut.slots]
    for slot, waypoint in zip(dut.slots, given, strict=True):
        ctx.set(slot, waypoint)
    await ctx.tick()
    return given


@on(lambda: ReadCrossbar(**CROSSBAR_SIZES))
async def test_waypoints_follow_the_choice_a_cycle_later(ctx, dut):
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


@on(lambda: ReadCrossbar(**CROSSBAR_SIZES))
async def test_a_port_without_a_choice_passes_0(ctx, dut):
    rng = random.Random(2)
    ctx.set(dut.step, 1)
    for _ in range(5):
        await pass_new(ctx, dut, rng)
        assert not any(ctx.get(port) for port in dut.waypoints)


@pytest.mark.parametrize("step", [0, 1])
@on(lambda: ReadCrossbar(**CROSSBAR_SIZES))
async def test_the_first_port_waits_for_a_step_and_all_take_writes(ctx, dut, step):
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


@pytest.mark.parametrize(("ports", "parts"), [(1, 1), (3, 1), (4, 2), (6, 2), (20, 7)])
def test_three_ports_share_a_register(ports, parts):
    assert ReadCrossbar.parts_of(ports) == parts
    assert len(ReadCrossbar(**{**CROSSBAR_SIZES, "ports": ports}).writing) == parts


CONFIG = TINY.replace(max_waypoints=5, map_size=512, coarse_factor=16, altitude_bits=12)
SIZES = {
    "slot_bits": CONFIG.slot_bits,
    "waypoint_bits": CONFIG.waypoint_bits,
    "max_waypoints": CONFIG.max_waypoints,
}
#: Cycles from a rewind until the first waypoints are in the slots.
FILLING = 1


class Slots:
    """Rewinds and steps as the population does, and delays lengths as it does."""

    def __init__(self, ctx, dut, paths):
        self.ctx, self.dut, self.paths = ctx, dut, paths
        self.position = self.filling = self.slot = self.slot_before = 0
        self.steps = self.rewind = False

    async def tick(self):
        """Advance one cycle, and act on the outputs before its edge."""
        ctx, dut = self.ctx, self.dut
        steps, rewind, slot = ctx.get(dut.steps), ctx.get(dut.rewind), ctx.get(dut.slot)
        assert not (steps and self.filling), "a step before the first waypoints are there"
        await ctx.tick()
        if self.steps:
            # The slot may have changed with the last step of a path.
            path = self.paths[self.slot_before]
            assert self.position < len(path), "a step past the end"
            ctx.set(dut.waypoint, path[self.position])
            self.position += 1
        self.filling = max(0, self.filling - 1)
        if rewind:
            self.position, self.filling = 0, FILLING
        ctx.set(dut.primes, not self.filling)
        ctx.set(dut.length, len(self.paths[self.slot]))
        self.steps, self.slot, self.slot_before = steps, slot, self.slot


def random_paths(rng):
    return [
        [rng.getrandbits(CONFIG.waypoint_bits) for _ in range(rng.randint(2, CONFIG.max_waypoints))]
        for _ in range(CONFIG.population)
    ]


async def read(ctx, dut, slots, first, count, is_ready):
    """Read paths; return them, and the cycle of each waypoint after the read is accepted."""
    ctx.set(dut.allow, 1)
    ctx.set(dut.reads.payload, {"slot": first, "count": count})
    ctx.set(dut.reads.valid, 1)
    assert ctx.get(dut.reads.ready)
    await slots.tick()
    ctx.set(dut.reads.valid, 0)
    paths, cycles = [[]], []
    for cycle in range(1, 40 * count * CONFIG.max_waypoints):
        assert ctx.get(dut.active)
        assert not ctx.get(dut.reads.ready)
        ready = is_ready()
        ctx.set(dut.waypoints.ready, ready)
        if ready and ctx.get(dut.waypoints.valid):
            word = ctx.get(dut.waypoints.payload)
            paths[-1].append(word.waypoint)
            cycles.append(cycle)
            assert not word.final or word.last
            if word.final:
                await slots.tick()
                assert not ctx.get(dut.active)
                return paths, cycles
            if word.last:
                paths.append([])
        await slots.tick()
    raise TimeoutError("The last waypoint does not come")


@pytest.mark.parametrize("eagerness", [1, 0.6, 0.1])
@on(lambda: PathReader(**SIZES))
async def test_paths_come_in_order(ctx, dut, eagerness):
    rng = random.Random(1)
    slots = Slots(ctx, dut, random_paths(rng))
    for first, count in [(0, CONFIG.population), (3, 1), (5, 3), (0, 2), (7, 1)]:
        paths, _ = await read(ctx, dut, slots, first, count, lambda: rng.random() < eagerness)
        assert paths == slots.paths[first : first + count]
        slots.paths = random_paths(rng)
        for _ in range(rng.randrange(4)):
            await slots.tick()


@on(lambda: PathReader(**SIZES))
async def test_cycles(ctx, dut):
    """It takes 5 cycles to the first waypoint, then one per waypoint, and 3 between two paths."""
    rng = random.Random(2)
    slots = Slots(ctx, dut, random_paths(rng))
    paths, cycles = await read(ctx, dut, slots, 0, CONFIG.population, lambda: True)
    expected, now = [], 5
    for path in paths:
        expected += range(now, now + len(path))
        now += len(path) + 3
    assert cycles == expected


@on(lambda: PathReader(**SIZES))
async def test_no_read_is_accepted_unless_allowed(ctx, dut):
    ctx.set(dut.reads.payload, {"slot": 0, "count": 1})
    ctx.set(dut.reads.valid, 1)
    for _ in range(3):
        assert not ctx.get(dut.reads.ready)
        await ctx.tick()
        assert not ctx.get(dut.active)
        assert not ctx.get(dut.rewind)
