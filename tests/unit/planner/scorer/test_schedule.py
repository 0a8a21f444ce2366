"""The schedule: values of different times and kinds meet after a fixed number of cycles."""

import pytest
from amaranth.hdl import Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed, slot_after
from pathgene.hdl.primitives.arithmetic import WideMultiplier
from tests.support.gateware.streams import simulate


class Meeting(wiring.Component):
    """Products and sums of values that meet at different times, in slots of some ``cycles``.

    ``both`` and ``twin`` are the pair ``a * factor`` and ``b * factor``: one after another in
    ``both`` if a slot is two cycles, otherwise both at once; ``sums`` is their sum with ``a`` of
    that slot; ``late`` has the values of ``a`` and ``b`` from nine slots earlier.
    """

    def __init__(self, cycles):
        self.cycles = cycles
        super().__init__(
            {
                "phase": In(1),
                "a": In(signed(5)),
                "b": In(7),
                "factor": In(4),
                "both": Out(signed(12)),
                "twin": Out(signed(12)),
                "sums": Out(signed(14)),
                "late_a": Out(signed(5)),
                "late_b": Out(7),
            }
        )

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase, self.cycles)
        a, b = Timed(self.a, 0), Timed(self.b, 0)
        factor = Timed(self.factor, 0, Kind.STEADY)
        unit = WideMultiplier(signed(8), 4)
        both = stages.through(
            "product", unit, "product", first=stages.alternate("ab", a, b), second=factor
        )
        total = stages.compute("total", lambda x, y, a: x + y + a, *stages.apart(both), a)
        held = stages.hold("held", total)
        late_a, late_b = stages.together(9 * self.cycles, a, b)
        self.times = both.time, total.time, held.time
        m.d.comb += [
            self.both.eq(both.value),
            self.twin.eq(0 if both.twin is None else both.twin),
            self.sums.eq(held.value),
            self.late_a.eq(late_a.value),
            self.late_b.eq(late_b.value),
        ]
        return m


def seen_of(dut, slots):
    """Return the outputs in each cycle."""
    outputs = dut.both, dut.twin, dut.sums, dut.late_a, dut.late_b
    seen = []

    async def bench(ctx):
        ctx.set(dut.factor, 13)
        for a, b in slots:
            ctx.set(dut.a, a)
            ctx.set(dut.b, b)
            for phase in range(dut.cycles):
                ctx.set(dut.phase, phase)
                seen.append([ctx.get(each) for each in outputs])
                await ctx.tick()

    simulate(dut, bench)
    return seen


SLOTS = [(-16 + n % 32, (n * 29) % 128) for n in range(60)]


def test_values_meet_in_slots_of_two_cycles():
    dut = Meeting(2)
    seen = seen_of(dut, SLOTS)
    assert dut.times == (2, 4, 6)
    for slot, (a, b) in enumerate(SLOTS[:-9]):
        now = 2 * slot
        assert [seen[now + 2][0], seen[now + 3][0]] == [13 * a, 13 * b]
        # Held through both cycles of a slot.
        assert seen[now + 6][2] == seen[now + 7][2] == 13 * (a + b) + a
        assert seen[now + 18][3:] == seen[now + 19][3:] == [a, b]


def test_values_meet_in_slots_of_one_cycle():
    """The values of a pair come together, each from a multiplier of its own."""
    dut = Meeting(1)
    seen = seen_of(dut, SLOTS)
    # A single value is held without another register.
    assert dut.times == (2, 3, 3)
    for now, (a, b) in enumerate(SLOTS[:-9]):
        assert seen[now + 2][:2] == [13 * a, 13 * b]
        assert seen[now + 3][2] == 13 * (a + b) + a
        assert seen[now + 9][3:] == [a, b]


@pytest.mark.parametrize(("cycles", "times"), [(1, [3, 4, 5]), (2, [4, 6, 6])])
def test_slots_after_a_time(cycles, times):
    """They are the times of held values."""
    assert [slot_after(time, cycles) for time in (3, 4, 5)] == times
    stages = Schedule(Module(), Meeting(cycles).phase, cycles)
    singles = [Timed(Meeting(cycles).a, time, Kind.SINGLE) for time in (3, 4, 5)]
    assert [stages.hold("held", single).time for single in singles] == times


@pytest.mark.parametrize("cycles", [1, 2])
def test_what_is_not_there_yet_cannot_be_used(cycles):
    dut = Meeting(cycles)
    stages = Schedule(Module(), dut.phase, cycles)
    single = Timed(dut.a, 4, Kind.SINGLE)
    with pytest.raises(AssertionError):
        stages.at(single, 3)
    with pytest.raises(AssertionError):
        stages.mux(single, Timed(dut.b, 4))
