"""The schedule: values of different times and kinds meet after a fixed number of cycles."""

import pytest
from amaranth.hdl import Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed
from pathgene.hdl.primitives.arithmetic import WideMultiplier
from tests.support.gateware.streams import simulate


class Meeting(wiring.Component):
    """Products and sums of values that meet at different times.

    ``both`` is the pair ``a * factor`` and ``b * factor``; ``sums`` is their sum with ``a`` of that
    slot; ``late`` has the values of ``a`` and ``b`` from nine slots earlier.
    """

    def __init__(self):
        super().__init__(
            {
                "phase": In(1),
                "a": In(signed(5)),
                "b": In(7),
                "factor": In(4),
                "both": Out(signed(12)),
                "sums": Out(signed(14)),
                "late_a": Out(signed(5)),
                "late_b": Out(7),
            }
        )

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase)
        a, b = Timed(self.a, 0), Timed(self.b, 0)
        factor = Timed(self.factor, 0, Kind.STEADY)
        unit = WideMultiplier(signed(8), 4)
        both = stages.through(
            "product", unit, "product", first=stages.alternate("ab", a, b), second=factor
        )
        total = stages.compute("total", lambda x, y, a: x + y + a, *stages.apart(both), a)
        held = stages.hold("held", total)
        late_a, late_b = stages.together(18, a, b)
        self.times = both.time, total.time, held.time
        m.d.comb += [
            self.both.eq(both.value),
            self.sums.eq(held.value),
            self.late_a.eq(late_a.value),
            self.late_b.eq(late_b.value),
        ]
        return m


def test_values_meet():
    dut = Meeting()
    slots = [(-16 + n % 32, (n * 29) % 128) for n in range(60)]
    seen = []

    async def bench(ctx):
        ctx.set(dut.factor, 13)
        for a, b in slots:
            ctx.set(dut.a, a)
            ctx.set(dut.b, b)
            for phase in range(2):
                ctx.set(dut.phase, phase)
                seen.append(
                    [ctx.get(each) for each in (dut.both, dut.sums, dut.late_a, dut.late_b)]
                )
                await ctx.tick()

    simulate(dut, bench)
    assert dut.times == (2, 4, 6)
    for slot, (a, b) in enumerate(slots[:-9]):
        now = 2 * slot
        assert [seen[now + 2][0], seen[now + 3][0]] == [13 * a, 13 * b]
        # Held through both cycles of a slot.
        assert seen[now + 6][1] == seen[now + 7][1] == 13 * (a + b) + a
        assert seen[now + 18][2:] == seen[now + 19][2:] == [a, b]


def test_what_is_not_there_yet_cannot_be_used():
    m = Module()
    stages = Schedule(m, Meeting().phase)
    single = Timed(Meeting().a, 4, Kind.SINGLE)
    with pytest.raises(AssertionError):
        stages.at(single, 3)
    with pytest.raises(AssertionError):
        stages.mux(single, Timed(Meeting().b, 4))
