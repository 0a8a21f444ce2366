"""The exported control unit: states that follow without an idle cycle, and counters."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.control import counters_layout, cycles_layout
from pathgene.hdl.protocol import ChipState, Counter


TOP = "control"
CONFIG = Config(checker=CheckerBuild.PARALLEL)

GENERATION = {
    ChipState.CROSSOVER: Counter.CROSSOVER,
    ChipState.MUTATE: Counter.MUTATION,
    ChipState.UPDATE: Counter.UPDATE,
}
UNITS = {
    ChipState.RECEIVE: "receive",
    ChipState.CROSSOVER: "crossover",
    ChipState.MUTATE: "mutation",
    ChipState.UPDATE: "update",
    ChipState.CHECK: "check",
    ChipState.TRANSMIT: "transmit",
}
INPUTS = (
    "pending",
    "generate",
    "check",
    "core__ready",
    "line_busy",
    "line_sending",
    "core__refused",
    "core__redrawn",
    "core__left_out",
    "core__restart",
)


def port(unit, name):
    """Return the name of a unit's port; ports of a generation's units are the core's."""
    prefix = "core__" if unit in ("crossover", "mutation", "update") else ""
    return f"{prefix}{unit}_{name}"


class Bench:
    """Driver in place of all units, with a model of the counters."""

    def __init__(self, dut):
        self.dut = dut
        self.counters = dict.fromkeys((name for name, _ in counters_layout(CONFIG)), 0)
        #: Counts that appear in the counters a cycle later.
        self.late = {}
        self.history = self.entered = ChipState.LISTEN.value
        self.state = ChipState.LISTEN
        for name in (*INPUTS, *(port(unit, "done") for unit in UNITS.values())):
            dut[name].value = 0

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, 10, unit="ns").start()
        await FallingEdge(self.dut.clk)
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0

    async def cycle(self, *, busy=False, sending=False):
        """Pass a cycle, with or without bytes on the line, and compare state and counters.

        All counters except the count of cycles lag by a cycle, and so does the history of states.
        """
        dut = self.dut
        dut.line_busy.value = busy
        dut.line_sending.value = sending
        assert dut.state.value.to_unsigned() == self.state
        for state, unit in UNITS.items():
            if state is not ChipState.CROSSOVER:  # Its unit starts on its own request.
                assert int(dut[port(unit, "on")].value) == (state is self.state)
        counters = counters_layout(CONFIG).from_bits(dut.counters.value.to_unsigned())
        assert {name: counters[name] for name in self.counters} == self.counters
        assert dut.history.value.to_unsigned() == self.history
        self.history = self.entered
        self.counters[Counter.CYCLES] += 1
        for counter, count in self.late.items():
            self.counters[counter] += count
        self.late = {
            Counter.RECEIVE: self.state is ChipState.RECEIVE or busy,
            Counter.TRANSMIT: self.state is ChipState.TRANSMIT or sending,
        }
        if self.state in GENERATION:
            self.late[GENERATION[self.state]] = 1
        await FallingEdge(dut.clk)

    def enter(self, state):
        self.state = state
        self.entered = (self.entered << 4 | state) & 0xFFFFFFFF

    async def run(self, state, cycles):
        """Stay in ``state`` for ``cycles``; its unit is done in the last."""
        self.enter(state)
        done = self.dut[port(UNITS[state], "done")]
        for left in range(cycles, 0, -1):
            done.value = left == 1
            await self.cycle()
        done.value = 0

    async def begin(self):
        """Pass the cycle between a command that requests a generation and the generation."""
        dut = self.dut
        dut.receive_done.value = 1
        assert dut.core__begin.value
        await self.cycle()
        assert not dut.core__begin.value
        dut.receive_done.value = 0


@cocotb.test()
async def random_commands(dut):
    """Run units of random durations, with frames on the line and new seeds."""
    rng = random.Random(6)
    bench = Bench(dut)
    await bench.reset()
    dut.core__ready.value = 1
    generation = 0
    for _ in range(120):
        for _ in range(rng.randrange(3)):
            if rng.random() < 0.1:
                dut.core__restart.value = 1
                generation = 0
            await bench.cycle(busy=rng.random() < 0.5, sending=rng.random() < 0.5)
            if dut.core__restart.value:
                bench.late[Counter.LONGEST] = -bench.counters[Counter.LONGEST]
            dut.core__restart.value = 0
        dut.pending.value = 1
        await bench.cycle()
        dut.pending.value = 0

        order = rng.choices(("generate", "check", None), (6, 2, 2))[0]
        if order:
            dut[order].value = 1
        await bench.run(ChipState.RECEIVE, rng.randint(1, 9))
        if order == "generate":
            await bench.begin()
        if order:
            dut[order].value = 0
        if order == "check":
            await bench.run(ChipState.CHECK, rng.randint(1, 30))
        if order == "generate":
            cycles = [rng.randint(1, 30) for _ in GENERATION]
            told = {
                Counter.REFUSED_MUTATIONS: (dut.core__refused, rng.randrange(CONFIG.mutators + 1)),
                Counter.REDRAWN: (
                    dut.core__redrawn,
                    rng.randrange(CONFIG.patches * CONFIG.redraws + 1),
                ),
                Counter.LEFT_OUT: (dut.core__left_out, rng.randrange(CONFIG.patches + 1)),
            }
            for port, count in told.values():
                port.value = count
            for state, length in zip(GENERATION, cycles, strict=True):
                await bench.run(state, length)
            generation += 1
            bench.late |= {counter: count for counter, (_, count) in told.items()}
            bench.late[Counter.GENERATIONS] = 1
            bench.late[Counter.LONGEST] = max(0, sum(cycles) - bench.counters[Counter.LONGEST])
            latest = cycles_layout(CONFIG).from_bits(dut.cycles.value.to_unsigned())
            assert [latest.crossover, latest.mutation, latest.update] == cycles
        await bench.run(ChipState.TRANSMIT, rng.randint(1, 9))
        bench.enter(ChipState.LISTEN)
        assert dut.generation.value.to_unsigned() == generation
    await bench.cycle()


@cocotb.test()
async def waits_for_the_draws(dut):
    """Start a generation two cycles after its draws are ready; the wait counts as RECEIVE."""
    bench = Bench(dut)
    await bench.reset()
    dut.pending.value = 1
    await bench.cycle()
    dut.pending.value = 0
    bench.enter(ChipState.RECEIVE)
    dut["generate"].value = 1
    dut.receive_done.value = 1
    for _ in range(20):
        await bench.cycle()
    dut.core__ready.value = 1
    await bench.cycle()
    await bench.begin()
    bench.enter(ChipState.CROSSOVER)
    await bench.cycle()
    assert bench.counters[Counter.RECEIVE] == 22
