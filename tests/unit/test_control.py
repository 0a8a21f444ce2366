"""The control unit: order of the units, hand-overs without an idle cycle, and counters."""

import random
from functools import partial

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.control import Control
from pathgene.hdl.protocol.codes import ChipState, Counter
from tests.support.gateware.streams import as_test, simulate


LISTEN, RECEIVE, CROSSOVER, MUTATE, UPDATE, TRANSMIT, CHECK = ChipState
#: Signals that turn the units on; the crossover begins by itself.
ON = {
    RECEIVE: lambda dut: dut.receive_on,
    MUTATE: lambda dut: dut.core.mutation_on,
    UPDATE: lambda dut: dut.core.update_on,
    CHECK: lambda dut: dut.check_on,
    TRANSMIT: lambda dut: dut.transmit_on,
}


class Bench:
    """A control unit whose units take given numbers of cycles.

    A receiving unit that asks for a generation takes one more.
    """

    def __init__(self, ctx, dut):
        self.ctx, self.dut = ctx, dut
        self.cycles = 0
        absent = () if dut.config.paper_core else (MUTATE, UPDATE)
        if not dut.config.checks_paths:
            absent = *absent, CHECK
        self.on = {unit: on(dut) for unit, on in ON.items() if unit not in absent}

    async def tick(self):
        self.cycles += 1
        await self.ctx.tick()

    def check(self, state):
        assert self.ctx.get(self.dut.state) == state
        for unit, on in self.on.items():
            assert self.ctx.get(on) == (unit == state), (state, unit)

    async def stay(self, state, cycles, done):
        """Stay in ``state`` for ``cycles``, and end it with ``done``."""
        for cycle in range(cycles):
            self.ctx.set(done, cycle == cycles - 1)
            self.check(state)
            await self.tick()
        self.ctx.set(done, 0)

    async def command(self, cycles, *, generate=True, refused=0, redrawn=0, left_out=0):
        """Take one command whose units take ``cycles``, from RECEIVE to TRANSMIT."""
        ctx, dut = self.ctx, self.dut
        self.check(LISTEN)
        ctx.set(dut.pending, 1)
        await self.tick()
        ctx.set(dut.pending, 0)
        ctx.set(dut.generate, generate)
        ctx.set(dut.core.refused, refused)
        ctx.set(dut.core.redrawn, redrawn)
        ctx.set(dut.core.left_out, left_out)
        await self.stay(RECEIVE, cycles[0], dut.receive_done)
        if generate:
            await self.begin()
            await self.stay(CROSSOVER, cycles[1], dut.core.crossover_done)
            await self.stay(MUTATE, cycles[2], dut.core.mutation_done)
            await self.stay(UPDATE, cycles[3], dut.core.update_done)
        await self.stay(TRANSMIT, cycles[4], dut.transmit_done)
        self.check(LISTEN)
        # The last cycle is counted in this one.
        await self.tick()

    async def begin(self):
        """Advance through the last cycle of a receiving unit that has asked for a generation."""
        self.ctx.set(self.dut.receive_done, 1)
        assert self.ctx.get(self.dut.core.begin)
        self.check(RECEIVE)
        await self.tick()
        self.ctx.set(self.dut.receive_done, 0)
        self.ctx.set(self.dut.generate, 0)

    async def check_paths(self, cycles, *, check=True):
        """Take one command to check paths, or one that is answered immediately."""
        ctx, dut = self.ctx, self.dut
        self.check(LISTEN)
        ctx.set(dut.pending, 1)
        await self.tick()
        ctx.set(dut.pending, 0)
        ctx.set(dut.check, check)
        await self.stay(RECEIVE, cycles[0], dut.receive_done)
        ctx.set(dut.check, 0)
        if check:
            await self.stay(CHECK, cycles[1], dut.check_done)
        await self.stay(TRANSMIT, cycles[2], dut.transmit_done)
        self.check(LISTEN)
        await self.tick()

    def counters(self):
        counters = self.ctx.get(self.dut.counters)
        return {name: counters[name] for name, _ in self.dut.counters.shape()}


def run_bench(bench, config=None):
    dut = Control(config or Config(checker=CheckerBuild.PARALLEL))

    async def testbench(ctx):
        if dut.config.paper_core:
            ctx.set(dut.core.ready, 1)
        await bench(Bench(ctx, dut), ctx, dut)

    simulate(dut, testbench)


@as_test(run_bench)
async def test_a_generation_goes_through_all_units(unit, ctx, dut):
    await unit.command([3, 17, 2, 1, 5], refused=2, redrawn=6, left_out=3)
    assert ctx.get(dut.history) == 0x00_123450
    assert ctx.get(dut.generation) == 1
    cycles = ctx.get(dut.cycles)
    assert (cycles.crossover, cycles.mutation, cycles.update) == (17, 2, 1)
    assert unit.counters() == {
        Counter.CYCLES: unit.cycles,
        Counter.RECEIVE: 3 + 1,
        Counter.CROSSOVER: 17,
        Counter.MUTATION: 2,
        Counter.UPDATE: 1,
        Counter.TRANSMIT: 5,
        Counter.LONGEST: 20,
        Counter.GENERATIONS: 1,
        Counter.REFUSED_MUTATIONS: 2,
        Counter.REDRAWN: 6,
        Counter.LEFT_OUT: 3,
    }


@as_test(run_bench)
async def test_another_command_goes_past_the_generation(unit, ctx, dut):
    await unit.command([2, 0, 0, 0, 4], generate=False, refused=5, redrawn=1, left_out=1)
    assert ctx.get(dut.history) == 0x00000_150
    assert ctx.get(dut.generation) == 0
    counters = unit.counters()
    assert counters.pop(Counter.CYCLES) == 7 + 1
    assert counters.pop(Counter.RECEIVE) == 2
    assert counters.pop(Counter.TRANSMIT) == 4
    assert set(counters.values()) == {0}


@as_test(run_bench)
async def test_a_check_goes_past_the_generation(unit, ctx, dut):
    await unit.check_paths([2, 30, 4])
    assert ctx.get(dut.history) == 0x0000_1650
    assert ctx.get(dut.generation) == 0
    counters = unit.counters()
    assert counters.pop(Counter.CYCLES) == 37 + 1
    assert counters.pop(Counter.RECEIVE) == 2
    assert counters.pop(Counter.TRANSMIT) == 4
    assert set(counters.values()) == {0}


@as_test(partial(run_bench, config=Config(core="none")))
async def test_a_chip_without_a_genetic_core(unit, ctx, dut):
    """A check, then another command: no unit waits for the next."""
    await unit.check_paths([3, 4, 2])
    await unit.check_paths([3, 0, 2], check=False)
    assert ctx.get(dut.history) == 0x0165_0150
    assert unit.counters() == {
        Counter.CYCLES: unit.cycles,
        Counter.RECEIVE: 3 + 3,
        Counter.TRANSMIT: 2 + 2,
    }


@as_test(partial(run_bench, config=Config(core="planner")))
async def test_a_chip_with_a_streaming_core(unit, ctx, dut):
    """Every command is answered immediately; generations count while commands are accepted."""
    for number in range(2):
        ctx.set(dut.pending, 1)
        await unit.tick()
        ctx.set(dut.pending, 0)
        ctx.set(dut.bred, number == 1)
        await unit.stay(RECEIVE, 3, dut.receive_done)
        ctx.set(dut.bred, 0)
        await unit.stay(TRANSMIT, 2, dut.transmit_done)
        unit.check(LISTEN)
        await unit.tick()
    assert ctx.get(dut.history) == 0x00_150150
    assert unit.counters() == {
        Counter.CYCLES: unit.cycles,
        Counter.RECEIVE: 3 + 3,
        Counter.TRANSMIT: 2 + 2,
        Counter.GENERATIONS: 3,
    }


@as_test(run_bench)
async def test_counters_of_random_commands(unit, ctx, dut):
    rng = random.Random(5)
    counters = dict.fromkeys(unit.counters(), 0)
    generations = 0
    for number in range(60):
        if number == 40:
            ctx.set(dut.core.restart, 1)
            await unit.tick()
            ctx.set(dut.core.restart, 0)
            generations = 0
            counters[Counter.LONGEST] = 0
        cycles = [rng.randint(1, 6) for _ in range(5)]
        generate = rng.random() < 0.7
        told = {
            Counter.REFUSED_MUTATIONS: ("refused", rng.randrange(6)),
            Counter.REDRAWN: ("redrawn", rng.randrange(7)),
            Counter.LEFT_OUT: ("left_out", rng.randrange(4)),
        }
        await unit.command(cycles, generate=generate, **dict(told.values()))
        counters[Counter.RECEIVE] += cycles[0] + generate
        counters[Counter.TRANSMIT] += cycles[4]
        if generate:
            generations += 1
            counters[Counter.CROSSOVER] += cycles[1]
            counters[Counter.MUTATION] += cycles[2]
            counters[Counter.UPDATE] += cycles[3]
            counters[Counter.GENERATIONS] += 1
            for counter, (_, count) in told.items():
                counters[counter] += count
            counters[Counter.LONGEST] = max(counters[Counter.LONGEST], sum(cycles[1:4]))
            latest = ctx.get(dut.cycles)
            assert [latest.crossover, latest.mutation, latest.update] == cycles[1:4]
        counters[Counter.CYCLES] = unit.cycles
        assert unit.counters() == counters
        assert ctx.get(dut.generation) == generations


@as_test(run_bench)
async def test_longest_generation_since_restart(unit, ctx, dut):
    for cycles, longest in (([1, 60, 2, 1, 1], 63), ([1, 9, 2, 1, 1], 63)):
        await unit.command(cycles)
        assert unit.counters()[Counter.LONGEST] == longest
    ctx.set(dut.core.restart, 1)
    await unit.tick()
    ctx.set(dut.core.restart, 0)
    await unit.tick()
    assert unit.counters()[Counter.LONGEST] == 0
    for cycles, longest in (([1, 5, 2, 1, 1], 8), ([1, 9, 2, 1, 1], 12)):
        await unit.command(cycles)
        assert unit.counters()[Counter.LONGEST] == longest
    # All remaining counters continue.
    assert unit.counters()[Counter.GENERATIONS] == 4


@as_test(run_bench)
async def test_generation_waits_until_ready(unit, ctx, dut):
    ctx.set(dut.core.ready, 0)
    ctx.set(dut.pending, 1)
    await unit.tick()
    ctx.set(dut.generate, 1)
    ctx.set(dut.receive_done, 1)
    for _ in range(9):
        unit.check(RECEIVE)
        await unit.tick()
    ctx.set(dut.core.ready, 1)
    assert not ctx.get(dut.core.begin)
    for _ in range(2):
        unit.check(RECEIVE)
        await unit.tick()
    unit.check(CROSSOVER)
    assert unit.counters()[Counter.CROSSOVER] == 0
    await unit.tick()
    # Waiting counts as receiving, not as part of the generation.
    assert unit.counters()[Counter.RECEIVE] == 11
    assert unit.counters()[Counter.CROSSOVER] == 0


@as_test(run_bench)
async def test_frame_coming_in_counts_as_receiving(unit, ctx, dut):
    ctx.set(dut.line_busy, 1)
    for _ in range(4):
        await unit.tick()
    await unit.command([3, 1, 1, 1, 2])
    ctx.set(dut.line_busy, 0)
    await unit.tick()
    assert unit.counters()[Counter.RECEIVE] == unit.cycles - 1


@as_test(run_bench)
async def test_answer_going_out_counts_as_transmitting(unit, ctx, dut):
    ctx.set(dut.line_sending, 1)
    for _ in range(7):
        await unit.tick()
    ctx.set(dut.line_sending, 0)
    await unit.tick()
    assert unit.counters()[Counter.TRANSMIT] == 7


@as_test(run_bench)
async def test_done_of_a_unit_that_is_off_does_nothing(unit, ctx, dut):
    dones = [
        dut.core.crossover_done,
        dut.core.mutation_done,
        dut.core.update_done,
        dut.check_done,
        dut.transmit_done,
    ]
    for done in (*dones, dut.receive_done, dut.generate):
        ctx.set(done, 1)
    for _ in range(5):
        unit.check(LISTEN)
        await unit.tick()
    ctx.set(dut.receive_done, 0)
    ctx.set(dut.pending, 1)
    await unit.tick()
    for _ in range(5):
        unit.check(RECEIVE)
        await unit.tick()
    assert ctx.get(dut.history) == 0x1
