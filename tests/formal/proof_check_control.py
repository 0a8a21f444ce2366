"""The control unit of a chip that only checks paths always returns to listening."""

from amaranth import *
from amaranth.hdl import Assert, Assume

from hdl.config import CheckerBuild, Config
from hdl.control import Control
from hdl.protocol import ChipState
from tests.formal.parts import Opened, any_constant, comes_back, free
from tools.formal import Proof


#: The unit of each state, and how many units have been on before it, at most.
UNITS = {
    ChipState.RECEIVE: ("receive", 0),
    ChipState.CHECK: ("check", 1),
    ChipState.TRANSMIT: ("transmit", 2),
}


class Returns(Elaboratable):
    """Proved for all time, by induction, for the iCEBreaker's kind of chip.

    Assumed: a unit says that it is over in one of the first ``limit`` clocks in which it is on, for
    any ``limit`` from 1 to 255. All else is as it likes in every clock, ``over`` of units that are
    off included.

    - After it has left LISTEN, the state is LISTEN again at most ``3 * limit`` clocks later.
    - It leaves LISTEN in the clock after ``pending``, for RECEIVE, and not otherwise.
    - The unit of the state is on and no other; in LISTEN none is.
    - A unit is off in the clock after it is done, and not earlier; after the receiving unit comes
      the check, if the command asks for one, and the answer.
    """

    def __init__(self, unit):
        self.dut = unit(Control)(Config(genetic=False, checker=CheckerBuild.TWO_TIER, lanes=1))

    def elaborate(self, platform):
        m = Module()
        control = self.dut
        state = control.state
        m.submodules.dut = opened = Opened(control)
        states = opened.open("sequencer")
        listening = states.signal("listen")
        limit = any_constant(m, 8, "limit")
        m.d.comb += Assume(limit != 0)
        on = {at: getattr(control, f"{name}_on") for at, (name, _) in UNITS.items()}
        done = {at: getattr(control, f"{name}_done") for at, (name, _) in UNITS.items()}
        free(m, *done.values(), control.pending, control.check)
        free(m, control.line_busy, control.line_sending)

        # Clocks in the state and out of LISTEN, the present one not counted.
        before = Signal.like(state)
        age, age_before = Signal(9), Signal(9)
        away, away_before = Signal(11), Signal(11)
        m.d.comb += [
            age.eq(Mux(state == before, age_before + 1, 0)),
            away.eq(Mux(before == ChipState.LISTEN, 0, away_before + 1)),
        ]
        m.d.sync += [before.eq(state), age_before.eq(age), away_before.eq(away)]

        # What the state has to be in the next clock.
        expected, following = Signal.like(state), Signal.like(state)
        in_time = Signal()
        m.d.sync += expected.eq(following)
        m.d.comb += [following.eq(state), Assert(state == expected)]
        with m.Switch(state):
            with m.Case(ChipState.LISTEN):
                m.d.comb += in_time.eq(1)
                with m.If(control.pending):
                    m.d.comb += following.eq(ChipState.RECEIVE)
            with m.Case(ChipState.RECEIVE):
                m.d.comb += in_time.eq(done[ChipState.RECEIVE])
                with m.If(in_time):
                    m.d.comb += following.eq(
                        Mux(control.check, ChipState.CHECK, ChipState.TRANSMIT)
                    )
            for at, then in (
                (ChipState.CHECK, ChipState.TRANSMIT),
                (ChipState.TRANSMIT, ChipState.LISTEN),
            ):
                with m.Case(at):
                    m.d.comb += in_time.eq(done[at])
                    with m.If(in_time):
                        m.d.comb += following.eq(then)
        m.d.comb += [
            Assume(in_time | (age + 1 < limit)),
            Assert(Cat(on[at] == (state == at) for at in on).all()),
            Assert(listening == (state == ChipState.LISTEN)),
        ]
        earlier = {at: count for at, (_, count) in UNITS.items()}
        comes_back(m, (before, state), earlier, age, away, limit, most=3)
        return m


PROOF = Proof(
    claim=Returns,
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
