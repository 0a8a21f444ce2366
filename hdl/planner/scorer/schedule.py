"""Timing of values in a pipeline that takes a segment every two cycles.

The scorer has no stalls: a value leaves a stage a fixed number of cycles after it enters. A *slot*
is two cycles, distinguished by ``phase``, and a segment enters in every slot. There are four kinds
of values:

- *steady* throughout a run: the fields of the problem's record;
- *held* for both cycles of a slot;
- *single*, available in one cycle;
- a *pair*: one value in a cycle and its twin in the next, so that one multiplier serves both.

:class:`Schedule` keeps the time of each value, counted from the unit's input slot, whose cycles are
0 and 1, and inserts registers where values with different times meet.
"""

import enum
from dataclasses import dataclass

from amaranth import *

from pathgene.hdl.primitives.storage import MemoryDelay


__all__ = ["Kind", "Schedule", "Timed"]

#: Numbers of steps and bits from which a delay is cheaper in a memory than in registers.
MEMORY_STEPS, MEMORY_BITS = 6, 8


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
        First cycle in which the value is available; even for held values, 0 for steady values.
    kind : Kind
    """

    value: Value
    time: int
    kind: Kind = Kind.HELD


class Schedule:
    """Stages of one module.

    Parameters
    ----------
    m : Module
    phase : Value
        1 in the second cycle of every slot.
    """

    def __init__(self, m: Module, phase: Value):
        self._m = m
        self._phase = phase
        self._delayed: dict[tuple[int, int], tuple[Value, Value]] = {}
        self._delays = 0

    def at(self, timed: Timed, time: int) -> Value:
        """Return a value delayed to ``time``."""
        if timed.kind is Kind.STEADY:
            return timed.value
        held = timed.kind is Kind.HELD
        steps = (time - timed.time) // 2 if held else time - timed.time
        assert steps >= 0
        step = self._phase if held else Const(1)
        return self._delay(timed.value, steps, step) if steps else timed.value

    def together(self, time: int, *held: Timed) -> list[Timed]:
        """Return held values in the slot at ``time``, delayed in a common memory."""
        assert time % 2 == 0
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
        value = Value.cast(function(*(self.at(each, time) for each in inputs)))
        register = Signal(value.shape(), name=name, reset_less=True)
        self._m.d.sync += register.eq(value)
        return Timed(register, time + 1, kind)

    def compute_held(self, name, function, *inputs: Timed) -> Timed:
        """Return a register of ``function(*inputs)``, all held, for the next slot."""
        assert {each.kind for each in inputs} == {Kind.HELD}
        time, _ = self._meet(inputs)
        value = function(*(self.at(each, time) for each in inputs))
        return self._held(name, value, time)

    def mux(self, first: Timed, second: Timed) -> Timed:
        """Return two held values as a pair, through a multiplexer."""
        assert first.kind is second.kind is Kind.HELD
        time, _ = self._meet((first, second))
        value = Mux(self._phase, self.at(second, time), self.at(first, time))
        return Timed(value, time, Kind.PAIR)

    def alternate(self, name, first: Timed, second: Timed) -> Timed:
        """Return two held values as a pair in a register."""
        return self.compute(name, lambda value: value, self.mux(first, second))

    def apart(self, pair: Timed) -> tuple[Timed, Timed]:
        """Return the two values of a pair, each single, at the time of the second."""
        assert pair.kind is Kind.PAIR
        return (
            Timed(self.at(pair, pair.time + 1), pair.time + 1, Kind.SINGLE),
            Timed(pair.value, pair.time + 1, Kind.SINGLE),
        )

    def hold(self, name, single: Timed) -> Timed:
        """Return a single value as a held value."""
        assert single.kind is Kind.SINGLE
        time = single.time | 1
        return self._held(name, self.at(single, time), time - 1)

    def through(self, name, unit, output: str, **inputs: Timed) -> Timed:
        """Return the output of a pipeline that takes values in every cycle.

        ``unit`` has a ``latency`` and becomes the submodule ``name``; ``inputs`` are its ports.
        """
        time, kind = self._meet(inputs.values())
        self._m.submodules[name] = unit
        for port, each in inputs.items():
            self._m.d.comb += getattr(unit, port).eq(self.at(each, time))
        return Timed(getattr(unit, output), time + unit.latency, kind)

    def _meet(self, inputs) -> tuple[int, Kind]:
        """Return the first time at which all inputs are available, and the kind of their result."""
        kinds = {each.kind for each in inputs}
        time = max(each.time for each in inputs)
        if Kind.PAIR not in kinds:
            return time, Kind.SINGLE
        # Both values of a pair meet the same slot.
        return time + (time % 2 if Kind.HELD in kinds else 0), Kind.PAIR

    def _held(self, name, value, time: int) -> Timed:
        """Return a register of ``value``, taken in the second cycle of the slot at ``time``."""
        register = Signal(value.shape(), name=name, reset_less=True)
        with self._m.If(self._phase):
            self._m.d.sync += register.eq(value)
        return Timed(register, time + 2)

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
