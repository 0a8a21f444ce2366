"""Pool of the slots that hold no path."""

from amaranth import *
from amaranth.lib import memory, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer


__all__ = ["SlotPool"]


class SlotPool(wiring.Component):
    """Hands out free slots, one per cycle: those put back, the oldest first, then unused ones.

    After ``clear`` all slots are unused, and handed out from 0 on. So no slot has to be written to
    start with. A slot put back is offered 2 cycles later.

    Parameters
    ----------
    total : int
        Slots, 2 or more.
    depth : int
        Slots that have been put back and not handed out again, at most; 1 or more.

    Members
    -------
    clear : In(1)
        All slots are unused. Overrides the rest.
    put : In(1)
        Put ``slot`` back.
    slot : In(range(total))
    slots : Out(stream.Signature(range(total)))
        Free slots, to be taken.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, total, depth):
        check_integer("Slots", total, 2)
        check_integer("Depth", depth, 1)

        self.total = total
        self.depth = depth
        super().__init__(
            {
                "clear": In(1),
                "put": In(1),
                "slot": In(range(total)),
                "slots": Out(stream.Signature(range(total))),
            }
        )

    def elaborate(self, platform):
        m = Module()

        # A queue in a memory, and a number from which on all slots are unused. Both pass through
        # the register of the slot on offer.
        m.submodules.rows = rows = memory.Memory(shape=self.slot.shape(), depth=self.depth, init=[])
        write, read = rows.write_port(), rows.read_port(domain="comb")
        held = Signal(range(self.depth + 1))
        unused = Signal(range(self.total + 1))
        offered = Signal(self.slot.shape(), reset_less=True)
        moves = Signal()
        gives = Signal()
        m.d.comb += [
            self.slots.p.eq(offered),
            moves.eq(~self.slots.valid | self.slots.ready),
            gives.eq(moves & (held != 0)),
            write.data.eq(self.slot),
            write.en.eq(self.put),
        ]
        with m.If(moves):
            m.d.sync += [
                self.slots.valid.eq((held != 0) | (unused != self.total)),
                offered.eq(Mux(held != 0, read.data, unused)),
            ]
            with m.If((held == 0) & (unused != self.total)):
                m.d.sync += unused.eq(unused + 1)
        m.d.sync += held.eq(held + self.put - gives)
        for port, moved in ((write, self.put), (read, gives)):
            with m.If(moved):
                m.d.sync += port.addr.eq(Mux(port.addr == self.depth - 1, 0, port.addr + 1))
        with m.If(self.clear):
            m.d.sync += [
                self.slots.valid.eq(0),
                unused.eq(0),
                held.eq(0),
                write.addr.eq(0),
                read.addr.eq(0),
            ]

        return m
