"""The control unit always returns to listening, one unit on at a time."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from hdl.config import Config
from hdl.control import Control
from hdl.protocol import ChipState
from tests.formal.parts import Opened, any_constant, comes_back, free
from tools.formal import Proof


#: The unit of each state, and how many units have been on before it, at most. The receiving unit
#: stays on for a clock more before a generation.
UNITS = {
    ChipState.RECEIVE: ("receive", 0),
    ChipState.CROSSOVER: ("crossover", 1),
    ChipState.MUTATE: ("mutation", 2),
    ChipState.UPDATE: ("update", 3),
    ChipState.CHECK: ("check", 1),
    ChipState.TRANSMIT: ("transmit", 4),
}

#: The state after that of a unit, but for the receiving one.
NEXT = {
    ChipState.CROSSOVER: ChipState.MUTATE,
    ChipState.MUTATE: ChipState.UPDATE,
    ChipState.UPDATE: ChipState.TRANSMIT,
    ChipState.CHECK: ChipState.TRANSMIT,
    ChipState.TRANSMIT: ChipState.LISTEN,
}


def _side(control, state):
    """Return the interface that has the hand-over with the unit of a state."""
    generation = (ChipState.CROSSOVER, ChipState.MUTATE, ChipState.UPDATE)
    return control.core if state in generation else control


class Returns(Elaboratable):
    """Proved for all time, by induction, for the chip of the default configuration.

    Assumed: a unit says that it is over in one of the first ``limit`` clocks in which it is on, for
    any ``limit`` from 1 to 255; the receiving unit, if it asks for a generation, is over and the
    chip ``ready`` in one of them, and it never asks for a generation and a check at once. All else
    is as it likes in every clock, ``over`` of units that are off included.

    - After it has left LISTEN, the state is LISTEN again at most ``5 * limit + 1`` clocks later.
    - It leaves LISTEN in the clock after ``pending``, for RECEIVE, and not otherwise.
    - The unit of the state is on and no other; in LISTEN none is.
    - A unit is off in the clock after it is done, and not earlier; the unit that is on then is the
      next one of its kind of command: crossover, mutation, update and answer of a generation, check
      and answer, or the answer alone. A generation starts only when ``ready``, of which
      ``begin`` tells in the clock between; the receiving unit is on in that, too.
    """

    def __init__(self, unit):
        self.dut = unit(Control)(Config())

    def elaborate(self, platform):
        m = Module()
        control = self.dut
        state = control.state
        m.submodules.dut = opened = Opened(control)
        sequencer = opened.open("sequencer")
        listening = sequencer.signal("listen")
        limit = any_constant(m, 8, "limit")
        m.d.comb += Assume(limit != 0)
        on = {
            at: getattr(_side(control, at), f"{name}_on")
            for at, (name, _) in UNITS.items()
            if at is not ChipState.CROSSOVER
        }
        # No unit but the population, which `launch` starts, takes part in the crossover.
        on[ChipState.CROSSOVER] = sequencer.signal("crossover")
        done = {at: getattr(_side(control, at), f"{name}_done") for at, (name, _) in UNITS.items()}
        free(
            m, *done.values(), control.pending, control.generate, control.check, control.core.ready
        )
        free(m, control.line_busy, control.line_sending, control.core.restart)
        free(m, control.core.refused, control.core.redrawn, control.core.left_out)

        # The receiving unit has asked for a generation, and it was ready.
        asked = Signal()
        m.d.sync += asked.eq(
            (state == ChipState.RECEIVE)
            & done[ChipState.RECEIVE]
            & control.generate
            & control.core.ready
            & ~asked
        )
        m.d.comb += Assert(control.core.begin == asked)

        # Clocks in the state and out of LISTEN, the present one not counted, nor that of `asked`.
        before, stays = Signal.like(state), Signal()
        age, age_before = Signal(9), Signal(9)
        away, away_before = Signal(12), Signal(12)
        m.d.comb += [
            stays.eq(state == before),
            age.eq(Mux(stays, age_before + ~asked, 0)),
            away.eq(Mux(before == ChipState.LISTEN, 0, away_before + ~asked)),
        ]
        m.d.sync += [before.eq(state), age_before.eq(age), away_before.eq(away)]

        # What the state has to be in the next clock.
        expected = Signal.like(state)
        following = Signal.like(state)
        m.d.sync += expected.eq(following)
        m.d.comb += [following.eq(state), Assert(state == expected)]
        in_time = Signal()
        with m.Switch(state):
            with m.Case(ChipState.LISTEN):
                m.d.comb += in_time.eq(1)
                with m.If(control.pending):
                    m.d.comb += following.eq(ChipState.RECEIVE)
            with m.Case(ChipState.RECEIVE):
                finished = done[ChipState.RECEIVE] & (control.core.ready | ~control.generate)
                m.d.comb += in_time.eq(finished | asked)
                with m.If(asked):
                    m.d.comb += following.eq(ChipState.CROSSOVER)
                with m.Elif(finished & ~control.generate & control.check):
                    m.d.comb += following.eq(ChipState.CHECK)
                with m.Elif(finished & ~control.generate):
                    m.d.comb += following.eq(ChipState.TRANSMIT)
            for at, then in NEXT.items():
                with m.Case(at):
                    m.d.comb += in_time.eq(done[at])
                    with m.If(done[at]):
                        m.d.comb += following.eq(then)
        m.d.comb += [
            Assume(~(control.generate & control.check)),
            Assume(in_time | (age + 1 < limit)),
        ]

        m.d.comb += [
            Assert(Cat(on[at] == (state == at) for at in on).all()),
            Assert(listening == (state == ChipState.LISTEN)),
            Assert(~asked | (state == ChipState.RECEIVE)),
        ]
        earlier = {at: count for at, (_, count) in UNITS.items()}
        comes_back(m, (before, state), earlier, age, away, limit, most=5)
        seen = Signal()
        with m.If(state == ChipState.CHECK):
            m.d.sync += seen.eq(1)
        m.d.comb += Cover(seen & (state == ChipState.LISTEN))
        return m


PROOF = Proof(
    claim=Returns,
    depth=2,
    reached=14,
    induction=2,
    faults={
        "the update does not end": (
            Control,
            (
                "TRANSMIT): self.core.update_done,",
                "TRANSMIT): self.core.update_done & self.line_busy,",
            ),
        ),
        "no update": (
            Control,
            ("(ChipState.MUTATE, ChipState.UPDATE)", "(ChipState.MUTATE, ChipState.TRANSMIT)"),
        ),
        "a generation does not wait": (
            Control,
            ("self.generate & core.ready", "self.generate"),
        ),
        "two units on": (
            Control,
            ("core.mutation_on.eq(on.mutate)", "core.mutation_on.eq(on.mutate | on.check)"),
        ),
    },
)
