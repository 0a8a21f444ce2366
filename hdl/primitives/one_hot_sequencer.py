"""State of the chip, one register for each: hands over from unit to unit."""

from collections.abc import Iterable
from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.protocol import ChipState, status_reply


__all__ = ["OneHotSequencer"]


class OneHotSequencer(wiring.Component):
    """Leaves a state as soon as it is told to, for the one that is next.

    Each state is a register of its own, which sees only what leads into it and out of it: nothing
    is decided by all units at once.

    Parameters
    ----------
    config : Config
    steps : iterable of (ChipState, ChipState)
        Which states follow which.

    Members
    -------
    take : In(len(steps))
        Take that step: from its first state to its second with the next clock. Ignored in other
        states; at most one of those out of a state may be high.
    on : Out(len(ChipState))
        The bit of the state is set, of LISTEN at first.
    state : Out(ChipState)
    history : Out(32)
        The eight states entered last, 4 bits each, the latest lowest; LISTEN before the first. A
        clock late.
    """

    def __init__(self, config: Config, steps: Iterable[tuple[ChipState, ChipState]]):
        self.steps = tuple(steps)
        super().__init__(
            {
                "take": In(len(self.steps)),
                "on": Out(len(ChipState)),
                "state": Out(ChipState),
                "history": Out(dict(status_reply(config).fields)["history"]),
            }
        )

    def elaborate(self, platform):
        m = Module()

        on = {
            state: Signal(name=state.name.lower(), init=int(state is ChipState.LISTEN))
            for state in ChipState
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
            m.d.sync += self.history.eq(Cat(self.state, C(0, 4 - len(self.state)), self.history))

        return m
