"""State machine with one register per state."""

import enum
from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Count, Given, InstanceOf, Unit, Width


__all__ = ["OneHotSequencer"]


class OneHotSequencer(Unit):
    """State machine that performs the requested step in the next cycle.

    Each state is a register that only depends on the steps into and out of this state, so no signal
    is decoded from the registers of all states. States without a step in or out are omitted.

    Members
    -------
    take : In(len(steps))
        Take this step: the second state of the step follows the first in the next cycle. Ignored in
        any other state; at most one step out of a state may be high.
    on : Out(StructLayout({state: 1, ...}))
        The current state, one bit per state, by its name in lower case.
    state : Out(type(initial))
        The current state.
    history : Out(history_length * history_entry_bits)
        The last states entered, the latest lowest; 0 before the first. One cycle late.
    """

    initial: InstanceOf(
        enum.IntEnum,
        "State after reset, of the enumeration of all states.",
        name="Initial state",
        phrase="a member of an IntEnum",
    )
    steps: Given(
        "iterable of (enum.IntEnum, enum.IntEnum)",
        "Possible steps: a state, and one that may follow it.",
    )
    history_length: Count(1, text="Entered states to remember.", name="History")
    history_entry_bits: Width("max(type(initial)).bit_length()", text="Width of each of them.")

    def interface(self):
        kind = type(self.initial)
        self.steps = tuple(self.steps)
        for state in (state for step in self.steps for state in step):
            if not isinstance(state, kind):
                raise TypeError(f"State must be a member of {kind.__name__}, not {state!r}")
        present = {self.initial}.union(*self.steps)
        self.states = tuple(state for state in kind if state in present)
        return {
            "take": In(len(self.steps)),
            "on": Out(data.StructLayout({state.name.lower(): 1 for state in self.states})),
            "state": Out(kind),
            "history": Out(self.history_length * self.history_entry_bits),
        }

    def elaborate(self, platform):
        m = Module()

        on = {
            state: Signal(name=state.name.lower(), init=int(state is self.initial))
            for state in self.states
        }
        steps = list(zip(self.take, self.steps, strict=True))
        for state, register in on.items():
            leaves = Cat(take for take, (source, _) in steps if source is state).any()
            enters = Cat(on[source] & take for take, (source, to) in steps if to is state).any()
            m.d.sync += register.eq(register & ~leaves | enters)
        m.d.comb += [
            self.on.eq(Cat(on.values())),
            self.state.eq(reduce(or_, (Mux(bit, state.value, 0) for state, bit in on.items()))),
        ]

        before = Signal.like(self.state)
        m.d.sync += before.eq(self.state)
        with m.If(self.state != before):
            padding = C(0, self.history_entry_bits - len(self.state))
            m.d.sync += self.history.eq(Cat(self.state, padding, self.history))

        return m
