"""A run ends once it must stop breeding, and it must stop at some time."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from pathgene.hdl.planner.run_control import RunControl, RunLimits
from tests.formal.parts import Opened, any_constant, free, made_of
from tests.support.planner.cases import SMALL
from tools.formal import Proof


#: Maximum number of states of a run, each entered once, if nothing is bred.
MOST = 90
#: Maximum number of these after the end of the first populations.
TAIL = 20
#: Remaining states, including this one, of the first population being filled.
FIRST = {
    "SCAN": 7,
    "ROUTE": 6,
    "ROUTED": 5,
    "PATHS": 4,
    "EVALUATED": 3,
    "STORE": 2,
    "STORED": 1,
}


class Ends(Elaboratable):
    """Proved for all time, by induction, for counters of 4 bits and any options.

    Assumed: each state waits at most ``limit`` cycles, for any ``limit`` from 8 to 255. Apart from
    that, units answer anything in every cycle, and ``stop`` arrives at any time.

    - No state except IDLE lasts ``limit`` cycles.
    - While first populations are being filled, each state leaves fewer states than the previous
      one, starting from 90. The same holds from the second cycle after a stop, or after the count
      of cycles has reached its maximum. So first populations take less than ``90 * limit`` cycles,
      and a run ends within the same number of cycles after a stop or after that maximum.
    - The cycles of a run are counted, up to the maximum.
    - Nothing is bred while first populations are being filled.
    """

    COUNTER_BITS = 4

    def __init__(self, unit):
        control, limits = unit(RunControl), unit(RunLimits)
        if limits is not RunLimits:
            control = made_of(RunControl, RunLimits=limits)

        class Small(control):
            COUNTER_BITS = self.COUNTER_BITS

        self.dut = Small(SMALL)

    def elaborate(self, platform):
        m = Module()
        control = self.dut
        m.submodules.dut = dut = Opened(control)
        limits = dut.open("limits")
        state, settled, pending, is_final, lifts, last_island = (
            dut.signal(name)
            for name in ("fsm_state", "settled", "pending", "is_final", "lifts", "last_island")
        )
        stopped, splitting = limits.signal("stopped"), limits.signal("splitting")
        reached, number = limits.signal("reached"), limits.signal("number")
        free(m, control.runs.valid, control.runs.payload, control.stop, control.source_ready)
        free(m, control.memo_busy, control.seeds_busy, control.paths_busy)
        free(m, control.evaluator_idle, control.evolver_ready, control.feasible)

        names = [state.decoder(code).partition("/")[0] for code in range(_STATES)]
        codes = {name: code for code, name in enumerate(names)}

        # The event that each state waits for, and its remaining cycles.
        goes = Signal()
        m.d.comb += goes.eq(1)
        for name, condition in {
            "SCAN": control.source_ready & ~control.memo_busy & ~control.seeds_busy,
            "ROUTED": ~control.seeds_busy,
            "EVALUATED": ~control.paths_busy & control.evaluator_idle,
            "STORED": control.evolver_ready,
            "EVOLVE": control.evolver_ready,
        }.items():
            with m.If(state == codes[name]):
                m.d.comb += goes.eq(condition & settled)
        limit = any_constant(m, 8, "limit")
        before = Signal.like(state)
        age_before, age = Signal(9), Signal(9)
        idle, launching = state == codes["IDLE"], state == codes["START"]
        waits = Cat(state == codes[name] for name in (*_WAITS,)).any()
        m.d.sync += [before.eq(state), age_before.eq(age)]
        m.d.comb += [
            Assume(limit >= 8),
            age.eq(Mux(state == before, age_before + 1, 0)),
            Assume(~waits | goes | (age + 1 < limit)),
            Assert(idle | (age < limit)),
            Assert((state != codes["SPLITTING"]) | (age + number <= RunControl.SHARE_BITS)),
            Assert(waits | idle | (state == codes["SPLITTING"]) | (age == 0)),
            Assert(splitting == (number != 0)),
            Assert((number == 0) | (state == codes["SPLITTING"])),
            Assert(number <= RunControl.SHARE_BITS),
        ]

        # Remaining states, including this one, if breeding has stopped.
        rank, rank_before = Signal(range(MOST + 1)), Signal(range(MOST + 1))
        each = control.options.lifts
        islands_left = last_island & ~control.island
        populations = Signal(range(MOST + 1))
        m.d.comb += populations.eq(4 * lifts + Mux(islands_left, 6 + 4 * each, 0))
        after = Signal(range(TAIL))
        m.d.comb += after.eq(Mux(is_final, 2, Mux(control.island, 8, 13)))
        with m.Switch(state):
            for name, left in FIRST.items():
                with m.Case(codes[name]):
                    m.d.comb += rank.eq(left + populations + TAIL)
            for name, left in {
                "START": MOST,
                "SPLIT": 7 + after,
                "SPLITTING": 6 + after,
                "AIM": 5 + after,
                "EVOLVE": Mux(pending, 4, 2) + after,
                "DECIDE": Mux(pending, 3, 1) + after,
                "MERGE": 8,
                "END": 1,
            }.items():
                with m.Case(codes[name]):
                    m.d.comb += rank.eq(left)

        # Breeding had to stop since the previous cycle, and its state knew then.
        decided, knew = Signal(), Signal()
        first = Cat(state == codes[name] for name in ("START", *FIRST)).any()
        first_before = Signal()
        falls = Signal()
        m.d.sync += [
            decided.eq(~idle & (stopped | control.cycles.all())),
            knew.eq(decided & ~idle),
            first_before.eq(first),
            rank_before.eq(rank),
        ]
        m.d.comb += [
            falls.eq((knew | first_before) & (state != before)),
            Assert(state < _STATES),
            Assert(~decided | idle | reached),
            Assert(~falls | (rank < rank_before)),
            Assert(~first | ~control.begin),
            Assert(launching | ~first | control.fills),
            Assert(launching | ~first | (control.island <= last_island)),
            Assert(first | idle | ~control.fills),
            Assert(first | idle | ~control.store),
            Assert(control.running == ~idle),
        ]

        # Cycles, up to the maximum, and whether there was a stop.
        count = Signal(self.COUNTER_BITS)
        asked = Signal()
        m.d.sync += [
            count.eq(Mux(idle, 0, count + ~count.all())),
            asked.eq(~idle & (asked | control.stop)),
        ]
        m.d.comb += [
            Assert(idle | (control.cycles == count)),
            Assert(idle | (stopped == asked)),
            Assert(~launching | ((count == 0) & ~stopped)),
            Cover(control.ends & (control.generations == 1)),
            Cover(control.merge),
        ]
        return m


#: States, and states that wait for a unit.
_STATES = 16
_WAITS = ("SCAN", "ROUTED", "EVALUATED", "STORED", "EVOLVE")

PROOF = Proof(
    claim=Ends,
    depth=12,
    reached=40,
    induction=2,
    long=("reached", "the share is taken for ever"),
    faults={
        "a lift is not counted": (RunControl, ("lifts.eq(lifts - 1)", "lifts.eq(lifts)")),
        "the second island comes again": (
            RunControl,
            ("self.island.eq(1),\n                        self.kind", "self.kind"),
        ),
        "what is collected stays pending": (
            RunControl,
            (
                "self.finish.eq(1)\n                m.d.sync += pending.eq(0)",
                "self.finish.eq(1)",
            ),
        ),
        "a stop is forgotten": (
            RunLimits,
            ("stopped.eq(stopped | self.stop)", "stopped.eq(self.stop)"),
        ),
        "cycles start again": (RunLimits, ("self.cycles + ~self.cycles.all()", "self.cycles + 1")),
        "the share is taken for ever": (RunLimits, ("number.eq(number - 1)", "number.eq(number)")),
    },
)
