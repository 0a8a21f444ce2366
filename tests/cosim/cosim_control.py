"""The exported control unit: hand-overs without a clock between, and counters."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from hdl.config import CheckerBuild, Config
from hdl.control import counters_layout, cycles_layout
from hdl.protocol import ChipState, Counter


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
    """Return the name of a unit's port; the core has those of the units of a generation."""
    prefix = "core__" if unit in ("crossover", "mutation", "update") else ""
    return f"{prefix}{unit}_{name}"


class Bench:
    """Plays all units, and counts beside the control unit."""

    def __init__(self, dut):
        self.dut = dut
        self.counters = dict.fromkeys((name for name, _ in counters_layout(CONFIG)), 0)
        #: What the next clock counts.
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

    async def clock(self, *, busy=False, sending=False):
        """Pass a clock, with bytes on the line or without; all before it must be counted.

        But for the clocks themselves, it is counted a clock late; and a state is noted so.
        """
        dut = self.dut
        dut.line_busy.value = busy
        dut.line_sending.value = sending
        assert dut.state.value.to_unsigned() == self.state
        for state, unit in UNITS.items():
            if state is not ChipState.CROSSOVER:  # It begins by itself.
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

    async def run(self, state, clocks):
        """Be in ``state`` for ``clocks``; its unit is over in the last."""
        self.enter(state)
        done = self.dut[port(UNITS[state], "done")]
        for left in range(clocks, 0, -1):
            done.value = left == 1
            await self.clock()
        done.value = 0

    async def begin(self):
        """Pass the clock between a command that asks for a generation and the generation."""
        dut = self.dut
        dut.receive_done.value = 1
        assert dut.core__begin.value
        await self.clock()
        assert not dut.core__begin.value
        dut.receive_done.value = 0


@cocotb.test()
async def random_commands(dut):
    """Units of random lengths, frames on the line meanwhile, and new seeds."""
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
            await bench.clock(busy=rng.random() < 0.5, sending=rng.random() < 0.5)
            if dut.core__restart.value:
                bench.late[Counter.LONGEST] = -bench.counters[Counter.LONGEST]
            dut.core__restart.value = 0
        dut.pending.value = 1
        await bench.clock()
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
            clocks = [rng.randint(1, 30) for _ in GENERATION]
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
            for state, length in zip(GENERATION, clocks, strict=True):
                await bench.run(state, length)
            generation += 1
            bench.late |= {counter: count for counter, (_, count) in told.items()}
            bench.late[Counter.GENERATIONS] = 1
            bench.late[Counter.LONGEST] = max(0, sum(clocks) - bench.counters[Counter.LONGEST])
            latest = cycles_layout(CONFIG).from_bits(dut.cycles.value.to_unsigned())
            assert [latest.crossover, latest.mutation, latest.update] == clocks
        await bench.run(ChipState.TRANSMIT, rng.randint(1, 9))
        bench.enter(ChipState.LISTEN)
        assert dut.generation.value.to_unsigned() == generation
    await bench.clock()


@cocotb.test()
async def waits_for_the_draws(dut):
    """A generation starts two clocks after its draws are there, and waiting is receiving."""
    bench = Bench(dut)
    await bench.reset()
    dut.pending.value = 1
    await bench.clock()
    dut.pending.value = 0
    bench.enter(ChipState.RECEIVE)
    dut["generate"].value = 1
    dut.receive_done.value = 1
    for _ in range(20):
        await bench.clock()
    dut.core__ready.value = 1
    await bench.clock()
    await bench.begin()
    bench.enter(ChipState.CROSSOVER)
    await bench.clock()
    assert bench.counters[Counter.RECEIVE] == 22
