"""The control unit always returns to listening, with one unit on at a time."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.control import Control
from pathgene.hdl.protocol.codes import ChipState
from tests.formal.parts import Opened, any_constant, comes_back, free
from tools.formal import Proof


#: Units of a generation by their states, each with the number of units on before it.
GENERATION = {
    ChipState.CROSSOVER: ("crossover", 1),
    ChipState.MUTATE: ("mutation", 2),
    ChipState.UPDATE: ("update", 3),
}

#: State that follows the state of each unit, except the receiver.
NEXT = {
    ChipState.CROSSOVER: ChipState.MUTATE,
    ChipState.MUTATE: ChipState.UPDATE,
    ChipState.UPDATE: ChipState.TRANSMIT,
    ChipState.CHECK: ChipState.TRANSMIT,
    ChipState.TRANSMIT: ChipState.LISTEN,
}


class Returns(Elaboratable):
    """Proved for all time, by induction, for the chip with the default configuration.

    (For a chip that only checks paths, see ``check_control``.)

    Assumed: a unit is done in one of the first ``limit`` cycles in which it is on, for any
    ``limit`` from 1 to 255; the receiving unit, if it asks for a generation, is done and the chip
    ``ready`` in one of them, and it never asks for a generation and a check at once. All other
    inputs have any value in every cycle, including ``done`` of units that are off.

    - The state returns to LISTEN at most ``5 * limit + 1`` cycles after leaving it.
    - It leaves LISTEN in the cycle after ``pending``, for RECEIVE, and never otherwise.
    - Only the unit of the state is on; in LISTEN none is.
    - A unit turns off in the cycle after it is done, and not earlier; the unit that is on then is
      the next one of its kind of command: crossover, mutation, update and answer of a generation,
      check and answer, or only the answer. A generation only starts when ``ready``, and ``begin``
      announces it in the cycle in between, in which the receiving unit is still on.
    """

    CONFIG = Config()
    #: Maximum number of units that a command turns on.
    MOST_UNITS = 5

    def __init__(self, unit):
        self.dut = unit(Control)(self.CONFIG)

    def elaborate(self, platform):
        m = Module()
        control, has_core = self.dut, self.CONFIG.paper_core
        units = {
            ChipState.RECEIVE: ("receive", 0),
            **(GENERATION if has_core else {}),
            ChipState.CHECK: ("check", 1),
            ChipState.TRANSMIT: ("transmit", self.MOST_UNITS - 1),
        }
        state = control.state
        m.submodules.dut = opened = Opened(control)
        sequencer = opened.open("sequencer")
        listening = sequencer.signal("listen")
        limit = any_constant(m, 8, "limit")
        m.d.comb += Assume(limit != 0)

        def member(at, suffix):
            side = control.core if at in GENERATION else control
            return getattr(side, f"{units[at][0]}_{suffix}")

        # Only the population, which `launch` starts, takes part in the crossover.
        on = {
            at: sequencer.signal("crossover") if at is ChipState.CROSSOVER else member(at, "on")
            for at in units
        }
        done = {at: member(at, "done") for at in units}
        free(m, *done.values(), control.pending, control.check)
        free(m, control.line_busy, control.line_sending)
        generate, ready = C(0), C(1)
        if has_core:
            core = control.core
            generate, ready = control.generate, core.ready
            free(m, generate, ready, core.restart, core.refused, core.redrawn, core.left_out)

        # The receiving unit has asked for a generation, and it was ready.
        asked = Signal()
        m.d.sync += asked.eq(
            (state == ChipState.RECEIVE) & done[ChipState.RECEIVE] & generate & ready & ~asked
        )
        if has_core:
            m.d.comb += Assert(core.begin == asked)

        # Cycles in the state and outside LISTEN, without the current cycle and the cycle of
        # `asked`.
        before, stays = Signal.like(state), Signal()
        age, age_before = Signal(9), Signal(9)
        away, away_before = Signal(12), Signal(12)
        m.d.comb += [
            stays.eq(state == before),
            age.eq(Mux(stays, age_before + ~asked, 0)),
            away.eq(Mux(before == ChipState.LISTEN, 0, away_before + ~asked)),
        ]
        m.d.sync += [before.eq(state), age_before.eq(age), away_before.eq(away)]

        # State required in the next cycle.
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
                finished = done[ChipState.RECEIVE] & (ready | ~generate)
                m.d.comb += in_time.eq(finished | asked)
                with m.If(asked):
                    m.d.comb += following.eq(ChipState.CROSSOVER)
                with m.Elif(finished & ~generate & control.check):
                    m.d.comb += following.eq(ChipState.CHECK)
                with m.Elif(finished & ~generate):
                    m.d.comb += following.eq(ChipState.TRANSMIT)
            for at, then in NEXT.items():
                if at in units:
                    with m.Case(at):
                        m.d.comb += in_time.eq(done[at])
                        with m.If(done[at]):
                            m.d.comb += following.eq(then)
        m.d.comb += [
            Assume(~(generate & control.check)),
            Assume(in_time | (age + 1 < limit)),
        ]

        m.d.comb += [
            Assert(Cat(on[at] == (state == at) for at in on).all()),
            Assert(listening == (state == ChipState.LISTEN)),
            Assert(~asked | (state == ChipState.RECEIVE)),
        ]
        earlier = {at: count for at, (_, count) in units.items()}
        comes_back(m, (before, state), earlier, age, away, limit, most=self.MOST_UNITS)
        seen = Signal()
        with m.If(state == ChipState.CHECK):
            m.d.sync += seen.eq(1)
        m.d.comb += Cover(seen & (state == ChipState.LISTEN))
        return m


CONTROL = Proof(
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


class ReturnsFromChecks(Returns):
    """Proved for all time, by induction, as there, for a chip without a core.

    After the receiving unit come the check, if the command asks for one, and the answer; the state
    returns to LISTEN at most ``3 * limit`` cycles after leaving it.
    """

    CONFIG = Config(core="none", checker=CheckerBuild.TWO_TIER, lanes=1)
    MOST_UNITS = 3


CHECK_CONTROL = Proof(
    claim=ReturnsFromChecks,
    depth=2,
    reached=10,
    induction=2,
    faults={
        "the answer does not end": (
            Control,
            ("LISTEN] = self.transmit_done", "LISTEN] = self.transmit_done & self.line_busy"),
        ),
        "no answer after a check": (
            Control,
            ("[ChipState.CHECK, ChipState.TRANSMIT]", "[ChipState.CHECK, ChipState.LISTEN]"),
        ),
        "a check that nobody asked for": (
            Control,
            ("= received & self.check", "= received"),
        ),
        "two units on": (
            Control,
            (
                "self.check_on.eq(on.check)",
                "self.check_on.eq(on.check | self.pending)",
            ),
        ),
    },
)


PROOFS = {"control": CONTROL, "check_control": CHECK_CONTROL}
