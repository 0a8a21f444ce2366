"""Control unit of a chip without a genetic core."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.primitives.one_hot_sequencer import OneHotSequencer
from hdl.protocol import ChipState, Counter, counters_reply, status_reply


__all__ = ["CheckControl"]


class CheckControl(wiring.Component):
    """Listens, has a command received, paths checked if it asks for that, and an answer sent.

    A unit is on from its state's first clock to the clock in which it says that it is over, both
    included; the next unit is on in the clock after that. It is what is left of
    :class:`hdl.control.Control` where no generation ever runs.

    Parameters
    ----------
    config : Config
        Has no genetic core.

    Members
    -------
    pending : In(1)
        A command waits to be received.
    receive_on, check_on, transmit_on : Out(1)
    receive_over, check_over, transmit_over : In(1)
        Each ignored unless its unit is on.
    check : In(1)
        With ``receive_over``: the command is to check paths.
    line_busy : In(1)
        A frame is coming in; such clocks count as receiving.
    line_sending : In(1)
        An answer is going out; such clocks count as transmitting.
    state : Out(ChipState)
    history : Out(32)
        The eight states entered last, 4 bits each, the latest lowest; LISTEN before the first. A
        clock late.
    counters : Out(StructLayout({counter: 48, ...}))
        Clocks in all, of receiving and of transmitting since reset, before the present one.
    """

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")
        self.config = config
        widths = dict(counters_reply(config).fields)
        counted = (Counter.CYCLES, Counter.RECEIVE, Counter.TRANSMIT)
        super().__init__(
            {
                "pending": In(1),
                "receive_on": Out(1),
                "receive_over": In(1),
                "check": In(1),
                "check_on": Out(1),
                "check_over": In(1),
                "transmit_on": Out(1),
                "transmit_over": In(1),
                "line_busy": In(1),
                "line_sending": In(1),
                "state": Out(ChipState),
                "history": Out(dict(status_reply(config).fields)["history"]),
                "counters": Out(
                    data.StructLayout({counter.value: widths[counter] for counter in counted})
                ),
            }
        )

    def elaborate(self, platform):
        m = Module()

        steps = {
            (ChipState.LISTEN, ChipState.RECEIVE): self.pending,
            (ChipState.RECEIVE, ChipState.CHECK): self.receive_over & self.check,
            (ChipState.RECEIVE, ChipState.TRANSMIT): self.receive_over & ~self.check,
            (ChipState.CHECK, ChipState.TRANSMIT): self.check_over,
            (ChipState.TRANSMIT, ChipState.LISTEN): self.transmit_over,
        }
        m.submodules.states = states = OneHotSequencer(self.config, steps)
        m.d.comb += [
            states.take.eq(Cat(steps.values())),
            self.receive_on.eq(states.on[ChipState.RECEIVE]),
            self.check_on.eq(states.on[ChipState.CHECK]),
            self.transmit_on.eq(states.on[ChipState.TRANSMIT]),
            self.state.eq(states.state),
            self.history.eq(states.history),
        ]

        counted = {
            Counter.CYCLES: 1,
            Counter.RECEIVE: self.receive_on | self.line_busy,
            Counter.TRANSMIT: self.transmit_on | self.line_sending,
        }
        for counter, on in counted.items():
            m.d.sync += self.counters[counter].eq(self.counters[counter] + on)

        return m
