"""Control unit: turns one unit on at a time, and counts what each of them takes."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.primitives.one_hot_sequencer import OneHotSequencer
from hdl.protocol import ChipState, Counter, counters_reply, status_reply


__all__ = ["Control", "clocks_layout", "counters_layout"]

# Which unit's clocks go to which counter and which field of the status.
_GENERATION = {
    ChipState.CROSSOVER: Counter.CROSSOVER,
    ChipState.MUTATE: Counter.MUTATION,
    ChipState.UPDATE: Counter.UPDATE,
}
_COUNTED = (
    Counter.CYCLES,
    Counter.RECEIVE,
    *_GENERATION.values(),
    Counter.TRANSMIT,
    Counter.LONGEST,
    Counter.GENERATIONS,
    Counter.REFUSED_MUTATIONS,
    Counter.REDRAWN,
    Counter.LEFT_OUT,
)


def clocks_layout(config: Config) -> data.StructLayout:
    """Return the layout of the clocks of each unit in the latest generation."""
    widths = dict(status_reply(config).fields)
    return data.StructLayout({counter.value: widths[counter] for counter in _GENERATION.values()})


def counters_layout(config: Config) -> data.StructLayout:
    """Return the layout of all counters but those of the line and of the checker."""
    widths = dict(counters_reply(config).fields)
    return data.StructLayout({counter.value: widths[counter] for counter in _COUNTED})


class Control(wiring.Component):
    """Control unit of the chip.

    Listens until a command is ``pending``, turns the receiving unit on to take it, then, for a
    command to run a generation, the crossover, mutation and update units, or, for one to check
    paths, the checking unit, and at last the transmitting unit, which answers. A unit is on from
    its state's first clock to the clock in which it says that it is over, both included; the next
    unit is on in the clock after that: no hand-over takes a clock of its own, but for that to the
    crossover.

    A generation starts only when ``ready``: until it does the receiving unit stays on and must hold
    ``receive_over`` and ``generate``, at least for two clocks: the first of them decides that it
    starts, in the second, with ``begin``, all that takes part knows. What is ``ready`` then stays
    so.

    Source: *allaire-2008*, section 4.2. Differs in that the update has a state of its own, and that
    a command may ask for something else than a generation.

    Parameters
    ----------
    config : Config
        Sizes of the chip.

    Members
    -------
    pending : In(1)
        A command waits to be received.
    receive_on : Out(1)
    receive_over : In(1)
        The command has been taken. Ignored unless ``receive_on``.
    generate : In(1)
    check : In(1)
        With ``receive_over``: the command is to run a generation, or to check paths; not both.
    ready : In(1)
        Everything that a generation needs is there.
    starts : Out(1)
        Pulse, in the clock before ``begin``.
    begin : Out(1)
        Pulse, in the clock before ``crossover_on`` rises.
    crossover_on, mutation_on, update_on, check_on, transmit_on : Out(1)
    crossover_over, mutation_over, update_over, check_over, transmit_over : In(1)
        Each ignored unless its unit is on.
    generating : Out(1)
        From ``begin`` to the last clock of the update.
    line_busy : In(1)
        A frame is coming in; such clocks count as receiving.
    line_sending : In(1)
        An answer is going out; such clocks count as transmitting.
    refused : In(range(mutators + 1))
        Mutations that a limit on the length forbade.
    redrawn : In(range(patches * candidates))
        Candidates that took the place of one in the ground.
    left_out : In(range(patches + 1))
        Mutations that had no candidate above the ground. These three are those of the present
        generation, and read in the last clock of the update.
    restart : In(1)
        Set ``generation`` and the counter of the longest generation to 0, a clock later than other
        inputs act.
    state : Out(ChipState)
    history : Out(32)
        The eight states entered last, 4 bits each, the latest lowest; LISTEN before the first. A
        clock late.
    generation : Out(32)
        Generations since reset or ``restart``; modulo 2**32.
    clocks : Out(StructLayout({"crossover": 16, "mutation": 16, "update": 16}))
        Clocks of each unit in the latest generation; growing while it runs, without those of the
        generation before.
    counters : Out(StructLayout({counter: 48, ...}))
        Every :class:`hdl.protocol.Counter` but those of the line and of the checker, since reset,
        the longest generation since ``restart``. That of all clocks shows the clocks before the
        present one. The others are a clock late: those of a generation are complete from the second
        clock after it on, before an answer is put together.
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        status = dict(status_reply(config).fields)
        super().__init__(
            {
                "pending": In(1),
                "receive_on": Out(1),
                "receive_over": In(1),
                "generate": In(1),
                "check": In(1),
                "ready": In(1),
                "starts": Out(1),
                "begin": Out(1),
                "crossover_on": Out(1),
                "crossover_over": In(1),
                "mutation_on": Out(1),
                "mutation_over": In(1),
                "update_on": Out(1),
                "update_over": In(1),
                "check_on": Out(1),
                "check_over": In(1),
                "transmit_on": Out(1),
                "transmit_over": In(1),
                "generating": Out(1),
                "line_busy": In(1),
                "line_sending": In(1),
                "refused": In(range(config.mutators + 1)),
                "redrawn": In(range(config.patches * config.candidates)),
                "left_out": In(range(config.patches + 1)),
                "restart": In(1),
                "state": Out(ChipState),
                "history": Out(status["history"]),
                "generation": Out(status["generation"]),
                "clocks": Out(clocks_layout(config)),
                "counters": Out(counters_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        done = Signal()
        received = Signal()
        m.d.comb += [
            self.starts.eq(
                self.receive_on & self.receive_over & self.generate & self.ready & ~self.begin
            ),
            done.eq(self.update_on & self.update_over),
            received.eq(self.receive_over & ~self.generate & ~self.begin),
        ]
        m.d.sync += [
            self.begin.eq(self.starts),
            self.generating.eq(self.starts | (self.generating & ~done)),
        ]

        steps = {
            (ChipState.LISTEN, ChipState.RECEIVE): self.pending,
            (ChipState.RECEIVE, ChipState.CROSSOVER): self.begin,
            (ChipState.RECEIVE, ChipState.CHECK): received & self.check,
            (ChipState.RECEIVE, ChipState.TRANSMIT): received & ~self.check,
            (ChipState.CROSSOVER, ChipState.MUTATE): self.crossover_over,
            (ChipState.MUTATE, ChipState.UPDATE): self.mutation_over,
            (ChipState.UPDATE, ChipState.TRANSMIT): self.update_over,
            (ChipState.CHECK, ChipState.TRANSMIT): self.check_over,
            (ChipState.TRANSMIT, ChipState.LISTEN): self.transmit_over,
        }
        units = {
            ChipState.RECEIVE: self.receive_on,
            ChipState.CROSSOVER: self.crossover_on,
            ChipState.MUTATE: self.mutation_on,
            ChipState.UPDATE: self.update_on,
            ChipState.CHECK: self.check_on,
            ChipState.TRANSMIT: self.transmit_on,
        }
        m.submodules.states = states = OneHotSequencer(self.config, steps)
        m.d.comb += [
            states.take.eq(Cat(steps.values())),
            *(on.eq(states.on[state]) for state, on in units.items()),
            self.state.eq(states.state),
            self.history.eq(states.history),
        ]

        # After a reset, too, for which there is no time besides.
        forgotten = Signal(init=1)
        generation = Signal.like(self.generation, reset_less=True)
        m.d.sync += forgotten.eq(self.restart)
        m.d.comb += self.generation.eq(generation)
        with m.If(forgotten):
            m.d.sync += generation.eq(0)
        with m.Elif(done):
            m.d.sync += generation.eq(generation + 1)

        counters = self.counters
        m.d.sync += counters[Counter.CYCLES].eq(counters[Counter.CYCLES] + 1)
        for state, counter in _GENERATION.items():
            with m.If(self.begin):
                m.d.sync += self.clocks[counter].eq(0)
            with m.Elif(units[state]):
                m.d.sync += self.clocks[counter].eq(self.clocks[counter] + 1)

        # Ahead by one: in the last clock of a generation it has that clock counted already.
        elapsed = Signal.like(self.clocks.crossover)
        lasted = Signal.like(elapsed, reset_less=True)
        longer = Signal()
        longest = Signal(elapsed.shape(), reset_less=True)
        with m.If(self.generating):
            m.d.sync += elapsed.eq(elapsed + 1)
        with m.Else():
            m.d.sync += elapsed.eq(0)
        m.d.sync += [
            lasted.eq(elapsed),
            longer.eq(done & (elapsed > longest)),
        ]
        with m.If(forgotten):
            m.d.sync += longest.eq(0)
        with m.Elif(longer):
            m.d.sync += longest.eq(lasted)

        # What there is to count, then so long a carry: a clock each.
        for counter, count in (
            (Counter.RECEIVE, self.receive_on | self.line_busy),
            (Counter.TRANSMIT, self.transmit_on | self.line_sending),
            *((counter, units[state]) for state, counter in _GENERATION.items()),
            (Counter.GENERATIONS, done),
            (Counter.REFUSED_MUTATIONS, Mux(done, self.refused, 0)),
            (Counter.REDRAWN, Mux(done, self.redrawn, 0)),
            (Counter.LEFT_OUT, Mux(done, self.left_out, 0)),
        ):
            added = Signal(Value.cast(count).shape(), name=f"added_{counter.value}")
            m.d.sync += [added.eq(count), counters[counter].eq(counters[counter] + added)]
        m.d.comb += counters[Counter.LONGEST].eq(longest)

        return m
