"""Control unit of every chip: runs one unit at a time, and counts the cycles of each."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import generation_signature
from pathgene.hdl.primitives.one_hot_sequencer import OneHotSequencer
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.codes import COUNTER_BITS, ChipState, Counter
from pathgene.hdl.protocol.messages import status_reply


__all__ = ["Control", "counters_layout", "cycles_layout"]

#: For each unit, the counter and the status field of its cycles in a generation.
_GENERATION = {
    ChipState.CROSSOVER: Counter.CROSSOVER,
    ChipState.MUTATE: Counter.MUTATION,
    ChipState.UPDATE: Counter.UPDATE,
}
#: Width of one state in the status's history.
_HISTORY_ENTRY_BITS = 4


def cycles_layout(config: Config) -> data.StructLayout:
    """Return the layout of the cycles of each unit in the latest generation."""
    widths = dict(status_reply(config).fields)
    return data.StructLayout({counter.value: widths[counter] for counter in _GENERATION.values()})


def counters_layout(config: Config) -> data.StructLayout:
    """Return the layout of the counters that the control unit keeps."""
    counted = [Counter.CYCLES, Counter.RECEIVE]
    if config.paper_core:
        counted += _GENERATION.values()
    counted.append(Counter.TRANSMIT)
    if config.planner_core:
        counted.append(Counter.GENERATIONS)
    if config.paper_core:
        counted += [Counter.LONGEST, Counter.GENERATIONS, Counter.REFUSED_MUTATIONS]
        if config.checks_paths:
            counted += [Counter.REDRAWN, Counter.LEFT_OUT]
    return data.StructLayout({counter.value: COUNTER_BITS for counter in counted})


class Control(Unit):
    """Control unit of the chip.

    The control unit listens until a command is ``pending``, then turns on the receiving unit to
    take it. A command to run a generation turns the crossover, mutation and update units on in
    turn; a command to check paths turns the checker on. Finally, the transmitting unit answers. A
    unit is on from the first cycle of its state up to and including the cycle in which it is done;
    the next unit is on in the following cycle. Only the handover to the crossover takes one more
    cycle. A planner core runs by itself, and its generations are counted.

    A generation starts only when the core is ``ready``. Until then the receiving unit stays on and
    holds ``receive_done`` and ``generate`` for at least two cycles: in the first, the control unit
    decides to start and pulses ``launch``; in the second, ``begin`` informs all participating
    units. The core stays ``ready`` in between.

    Without a genetic core, or without a checker of the paths of commands, the control unit lacks
    the corresponding states, counters and members.

    Source: *allaire-2008*, section 4.2. Differences: the update is a separate state, and there are
    commands other than a generation.

    Members
    -------
    pending : In(1)
        A command is waiting to be received.
    receive_on, transmit_on : Out(1)
        The unit is on.
    receive_done, transmit_done : In(1)
        The command has been taken; the answer has been sent. Each is ignored unless its unit is on.
    line_busy : In(1)
        A frame is being received; such cycles count as receiving.
    line_sending : In(1)
        An answer is being sent; such cycles count as transmitting.
    state : Out(ChipState)
    history : Out(32)
        The last eight states entered, 4 bits each, the latest lowest; LISTEN before the first.
        Updated one cycle late.
    counters : Out(StructLayout({counter: 48, ...}))
        Every :class:`pathgene.hdl.protocol.codes.Counter` of the chip's units since reset, except
        the counters of the line and of the checker. The longest generation counts since the latest
        ``restart``. The count of all cycles excludes the current cycle; all other counters are
        updated one cycle late. The counters of a generation are complete from the second cycle
        after it, before an answer is made.

    With a checker of the paths of commands:

    check : In(1)
        With ``receive_done``: the command checks paths.
    check_on : Out(1)
    check_done : In(1)
        Ignored unless the checker is on.

    With the planner core:

    bred : In(1)
        Pulse: a generation has been bred.

    With the paper core:

    generate : In(1)
        With ``receive_done``: the command runs a generation. Excludes ``check``.
    core : Out(generation_signature)
        ``restart`` sets ``generation`` and the counter of the longest generation to 0, one cycle
        later than other inputs take effect.
    generation : Out(32)
        Generations since reset or ``restart``; modulo 2**32.
    cycles : Out(StructLayout({"crossover": 16, "mutation": 16, "update": 16}))
        Cycles of each unit in the latest generation, which they count while it runs.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.checks_paths = config.checks_paths
        status = dict(status_reply(config).fields)
        self.history_length = status["history"] // _HISTORY_ENTRY_BITS
        members = {
            "pending": In(1),
            "receive_on": Out(1),
            "receive_done": In(1),
            "transmit_on": Out(1),
            "transmit_done": In(1),
            "line_busy": In(1),
            "line_sending": In(1),
            "state": Out(ChipState),
            "history": Out(status["history"]),
            "counters": Out(counters_layout(config)),
        }
        if self.checks_paths:
            members |= {"check": In(1), "check_on": Out(1), "check_done": In(1)}
        if config.planner_core:
            members["bred"] = In(1)
        if config.paper_core:
            members |= {
                "generate": In(1),
                "core": Out(generation_signature(config)),
                "generation": Out(status["generation"]),
                "cycles": Out(cycles_layout(config)),
            }
        return members

    def elaborate(self, platform):
        m = Module()

        steps = self._steps(m)
        m.submodules.sequencer = sequencer = OneHotSequencer(
            ChipState.LISTEN,
            steps,
            history_length=self.history_length,
            history_entry_bits=_HISTORY_ENTRY_BITS,
        )
        on = sequencer.on
        m.d.comb += [
            sequencer.take.eq(Cat(steps.values())),
            self.state.eq(sequencer.state),
            self.history.eq(sequencer.history),
            self.receive_on.eq(on.receive),
            self.transmit_on.eq(on.transmit),
        ]
        if self.checks_paths:
            m.d.comb += self.check_on.eq(on.check)

        counts = {
            Counter.RECEIVE: self.receive_on | self.line_busy,
            Counter.TRANSMIT: self.transmit_on | self.line_sending,
        }
        if self.config.paper_core:
            m.d.comb += [self.core.mutation_on.eq(on.mutate), self.core.update_on.eq(on.update)]
            counts |= self._generation(m, on)
        if self.config.planner_core:
            counts[Counter.GENERATIONS] = self.bred
        self._count(m, counts)
        return m

    def _steps(self, m):
        """Return the steps from state to state, each with its condition."""
        received = self.receive_done
        if self.config.paper_core:
            # Not in the cycle of `begin`, in which the receiving unit is still on.
            received = Signal()
            m.d.comb += received.eq(self.receive_done & ~self.generate & ~self.core.begin)
        to_answer = received
        steps = {(ChipState.LISTEN, ChipState.RECEIVE): self.pending}
        if self.config.paper_core:
            steps[ChipState.RECEIVE, ChipState.CROSSOVER] = self.core.begin
        if self.checks_paths:
            steps[ChipState.RECEIVE, ChipState.CHECK] = received & self.check
            to_answer = received & ~self.check
        steps[ChipState.RECEIVE, ChipState.TRANSMIT] = to_answer
        if self.config.paper_core:
            steps |= {
                (ChipState.CROSSOVER, ChipState.MUTATE): self.core.crossover_done,
                (ChipState.MUTATE, ChipState.UPDATE): self.core.mutation_done,
                (ChipState.UPDATE, ChipState.TRANSMIT): self.core.update_done,
            }
        if self.checks_paths:
            steps[ChipState.CHECK, ChipState.TRANSMIT] = self.check_done
        steps[ChipState.TRANSMIT, ChipState.LISTEN] = self.transmit_done
        return steps

    def _generation(self, m, on):
        """Start and measure generations; return the increments of the counters."""
        core = self.core

        done = Signal()
        m.d.comb += [
            core.launch.eq(
                self.receive_on & self.receive_done & self.generate & core.ready & ~core.begin
            ),
            done.eq(core.update_on & core.update_done),
        ]
        m.d.sync += [
            core.begin.eq(core.launch),
            core.generating.eq(core.launch | (core.generating & ~done)),
        ]

        # Also high after a reset, because the registers cleared here have no reset.
        restarted = Signal(init=1)
        generation = Signal.like(self.generation, reset_less=True)
        m.d.sync += restarted.eq(core.restart)
        m.d.comb += self.generation.eq(generation)
        with m.If(restarted):
            m.d.sync += generation.eq(0)
        with m.Elif(done):
            m.d.sync += generation.eq(generation + 1)

        units = {counter: on[state.name.lower()] for state, counter in _GENERATION.items()}
        for counter, unit_on in units.items():
            with m.If(core.begin):
                m.d.sync += self.cycles[counter].eq(0)
            with m.Elif(unit_on):
                m.d.sync += self.cycles[counter].eq(self.cycles[counter] + 1)

        # One ahead, so that in the last cycle of a generation the count already includes it.
        elapsed = Signal.like(self.cycles.crossover)
        lasted = Signal.like(elapsed, reset_less=True)
        longer = Signal()
        longest = Signal(elapsed.shape(), reset_less=True)
        with m.If(core.generating):
            m.d.sync += elapsed.eq(elapsed + 1)
        with m.Else():
            m.d.sync += elapsed.eq(0)
        m.d.sync += [
            lasted.eq(elapsed),
            longer.eq(done & (elapsed > longest)),
        ]
        with m.If(restarted):
            m.d.sync += longest.eq(0)
        with m.Elif(longer):
            m.d.sync += longest.eq(lasted)
        m.d.comb += self.counters[Counter.LONGEST].eq(longest)

        counts = {
            **units,
            Counter.GENERATIONS: done,
            Counter.REFUSED_MUTATIONS: Mux(done, core.refused, 0),
        }
        if self.checks_paths:
            counts |= {
                Counter.REDRAWN: Mux(done, core.redrawn, 0),
                Counter.LEFT_OUT: Mux(done, core.left_out, 0),
            }
        return counts

    def _count(self, m, counts):
        """Count all cycles, and add ``counts`` to their counters."""
        counters = self.counters
        m.d.sync += counters[Counter.CYCLES].eq(counters[Counter.CYCLES] + 1)
        for counter, count in counts.items():
            # One cycle for the count, one for the long carry.
            added = Signal(Value.cast(count).shape(), name=f"added_{counter.value}")
            m.d.sync += [added.eq(count), counters[counter].eq(counters[counter] + added)]
