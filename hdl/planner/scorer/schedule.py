"""Timing of values in a pipeline that takes a segment in every slot of one or two cycles.

The scorer has no stalls: a value leaves a stage a fixed number of cycles after it enters. A segment
enters in every *slot*. There are four kinds of values:

- *steady* throughout a run: the fields of the problem's record;
- *held* for all cycles of a slot;
- *single*, available in one cycle;
- a *pair*: if a slot is two cycles, one value in a cycle and its twin in the next, so that one
  multiplier serves both; if it is one cycle, both values in the same cycle, each with a multiplier
  of its own.

:class:`Schedule` keeps the time of each value, counted from the unit's input slot, whose first
cycle is 0, and inserts registers where values with different times meet. The stages of a unit are
the same for both sizes of a slot.
"""

import enum
from dataclasses import dataclass

from amaranth import *

from pathgene.hdl.primitives.storage import MemoryDelay


__all__ = ["Kind", "Schedule", "Timed", "slot_after"]

#: Numbers of steps and bits from which a delay is cheaper in a memory than in registers.
MEMORY_STEPS, MEMORY_BITS = 6, 8


def slot_after(time: int, cycles: int) -> int:
    """Return the first cycle in which a single value of ``time`` is held, with ``cycles`` a slot.

    See :meth:`Schedule.hold`.
    """
    return time if cycles == 1 else (time | 1) + 1


class Kind(enum.Enum):
    """Cycles in which a value is available."""

    STEADY = enum.auto()
    HELD = enum.auto()
    SINGLE = enum.auto()
    PAIR = enum.auto()


@dataclass(frozen=True)
class Timed:
    """A value and its time.

    Attributes
    ----------
    value : Value
    time : int
        First cycle in which the value is available: for held values the first of a slot, 0 for
        steady values.
    kind : Kind
    twin : Value or None
        Second value of a pair whose values are available in the same cycle.
    """

    value: Value
    time: int
    kind: Kind = Kind.HELD
    twin: Value | None = None


class Schedule:
    """Stages of one module.

    Parameters
    ----------
    m : Module
    phase : Value
        1 in the last cycle of every slot of two cycles.
    cycles : int
        Cycles of a slot, 1 or 2.

    Attributes
    ----------
    begins, ends : Value
        1 in the first and in the last cycle of every slot.
    """

    def __init__(self, m: Module, phase: Value, cycles: int):
        self._m = m
        self._cycles = cycles
        self.begins, self.ends = (~phase, phase) if cycles == 2 else (Const(1), Const(1))
        self._delayed: dict[tuple[int, int], tuple[Value, Value]] = {}
        self._delays = 0

    def slots(self, time: int) -> int:
        """Return the number of slots in ``time`` cycles."""
        return time // self._cycles

    def at(self, timed: Timed, time: int) -> Value:
        """Return a value delayed to ``time``."""
        assert timed.twin is None
        if timed.kind is Kind.STEADY:
            return timed.value
        held = timed.kind is Kind.HELD
        steps = self.slots(time - timed.time) if held else time - timed.time
        assert steps >= 0
        step = self.ends if held else Const(1)
        return self._delay(timed.value, steps, step) if steps else timed.value

    def together(self, time: int, *held: Timed) -> list[Timed]:
        """Return held values in the slot at ``time``, delayed in a common memory."""
        assert time % self._cycles == 0
        assert all(each.kind is Kind.HELD for each in held)
        latest = max(each.time for each in held)
        joined = Cat(self.at(each, latest) for each in held)
        joined = self.at(Timed(joined, latest), time)
        parts, low = [], 0
        for each in held:
            part = joined[low : low + len(each.value)]
            low += len(part)
            parts.append(Timed(part.as_signed() if each.value.shape().signed else part, time))
        return parts

    def compute(self, name, function, *inputs: Timed) -> Timed:
        """Return a register of ``function(*inputs)``: single, or a pair if an input is a pair."""
        time, kind = self._meet(inputs)
        registers = []
        for title, each in self._sides(name, kind, inputs):
            value = Value.cast(function(*(self.at(timed, time) for timed in each)))
            registers.append(Signal(value.shape(), name=title, reset_less=True))
            self._m.d.sync += registers[-1].eq(value)
        return self._timed(registers, time + 1, kind)

    def compute_held(self, name, function, *inputs: Timed) -> Timed:
        """Return a register of ``function(*inputs)``, all held, for the next slot."""
        assert {each.kind for each in inputs} == {Kind.HELD}
        time, _ = self._meet(inputs)
        value = function(*(self.at(each, time) for each in inputs))
        return self._held(name, value, time)

    def mux(self, first: Timed, second: Timed) -> Timed:
        """Return two held values as a pair, through a multiplexer if they share a line."""
        assert first.kind is second.kind is Kind.HELD
        time, _ = self._meet((first, second))
        values = [self.at(each, time) for each in (first, second)]
        if self._cycles == 2:
            values = [Mux(self.ends, *reversed(values))]
        return self._timed(values, time, Kind.PAIR)

    def alternate(self, name, first: Timed, second: Timed) -> Timed:
        """Return two held values as a pair in a register."""
        return self.compute(name, lambda value: value, self.mux(first, second))

    def apart(self, pair: Timed) -> tuple[Timed, Timed]:
        """Return the two values of a pair, each single, at the time of the second."""
        assert pair.kind is Kind.PAIR
        if pair.twin is not None:
            return Timed(pair.value, pair.time, Kind.SINGLE), Timed(
                pair.twin, pair.time, Kind.SINGLE
            )
        return (
            Timed(self.at(pair, pair.time + 1), pair.time + 1, Kind.SINGLE),
            Timed(pair.value, pair.time + 1, Kind.SINGLE),
        )

    def hold(self, name, single: Timed) -> Timed:
        """Return a single value as a held value; in a slot of one cycle it is one already."""
        assert single.kind is Kind.SINGLE
        if self._cycles == 1:
            return Timed(single.value, single.time)
        time = single.time | 1
        return self._held(name, self.at(single, time), time - 1)

    def through(self, name, unit, output: str, **inputs: Timed) -> Timed:
        """Return the output of a pipeline that takes values in every cycle.

        ``unit`` has a ``latency`` and becomes the submodule ``name``; ``inputs`` are its ports. The
        second values of a pair go through another such unit if they come in the same cycle.
        """
        time, kind = self._meet(inputs.values())
        outputs = []
        for title, each in self._sides(name, kind, inputs.values()):
            own = unit.twin() if outputs else unit
            self._m.submodules[title] = own
            for port, timed in zip(inputs, each, strict=True):
                self._m.d.comb += getattr(own, port).eq(self.at(timed, time))
            outputs.append(getattr(own, output))
        return self._timed(outputs, time + unit.latency, kind)

    def _sides(self, name, kind: Kind, inputs):
        """Yield a name and the inputs for each value of a result that comes in the same cycle."""
        if kind is not Kind.PAIR or self._cycles == 2:
            yield name, inputs
            return
        for suffix, is_twin in (("", False), ("_twin", True)):
            yield (
                name + suffix,
                [
                    Timed(each.twin if is_twin else each.value, each.time, Kind.SINGLE)
                    if each.kind is Kind.PAIR
                    else each
                    for each in inputs
                ],
            )

    def _timed(self, values, time: int, kind: Kind) -> Timed:
        """Return one or two values that come in the same cycle."""
        value, *twins = values
        return Timed(value, time, kind, *twins)

    def _meet(self, inputs) -> tuple[int, Kind]:
        """Return the first time at which all inputs are available, and the kind of their result."""
        kinds = {each.kind for each in inputs}
        time = max(each.time for each in inputs)
        if Kind.PAIR not in kinds:
            return time, Kind.SINGLE
        # Both values of a pair meet the same slot.
        return time + (time % self._cycles if Kind.HELD in kinds else 0), Kind.PAIR

    def _held(self, name, value, time: int) -> Timed:
        """Return a register of ``value``, taken in the last cycle of the slot at ``time``."""
        register = Signal(value.shape(), name=name, reset_less=True)
        with self._m.If(self.ends):
            self._m.d.sync += register.eq(value)
        return Timed(register, time + self._cycles)

    def _delay(self, value: Value, steps: int, step: Value) -> Value:
        """Return ``value`` from ``steps`` steps ago; delays of a value share registers."""
        known = self._delayed.get((id(value), steps))
        if known is not None:
            return known[1]
        width = Shape.cast(value.shape()).width
        if steps >= MEMORY_STEPS and width >= MEMORY_BITS:
            self._delays += 1
            delay = MemoryDelay(value.shape(), steps)
            self._m.submodules[f"delay_{self._delays}"] = delay
            self._m.d.comb += [delay.word.eq(value), delay.step.eq(step)]
            delayed = delay.delayed
        else:
            earlier = self._delay(value, steps - 1, step) if steps > 1 else value
            self._delays += 1
            delayed = Signal(value.shape(), name=f"delayed_{self._delays}", reset_less=True)
            with self._m.If(step):
                self._m.d.sync += delayed.eq(earlier)
        # Keeps the value alive, because another object could otherwise get its identity.
        self._delayed[id(value), steps] = (value, delayed)
        return delayed
