"""Pool of the slots without a path."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.buffers import MemoryQueue
from pathgene.hdl.primitives.unit import Count, Unit


__all__ = ["SlotPool"]


class SlotPool(Unit):
    """Hands out free slots: unused slots first, then returned slots, oldest first.

    After ``clear``, all slots are unused and are handed out starting with 0, so no slot has to be
    written initially. A returned slot is handed out as late as possible, and may be read until
    then. A slot is offered 2 cycles after the previous one is taken, and at least 2 cycles after it
    is put back.

    Members
    -------
    clear : In(1)
        Make all slots unused. Overrides the rest.
    put : In(1)
        Put ``slot`` back.
    slot : In(range(total))
    slots : Out(stream.Signature(range(total)))
        Free slots, to be taken.
    """

    total: Count(2, name="Slots")
    depth: Count(
        1, text="Maximum number of slots that have been put back and not handed out again."
    )

    def interface(self):
        return {
            "clear": In(1),
            "put": In(1),
            "slot": In(range(self.total)),
            "slots": Out(stream.Signature(range(self.total))),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.queue = queue = MemoryQueue(self.slot.shape(), self.depth)
        # All slots from this number on are unused.
        unused = Signal(range(self.total + 1))
        is_unused = Signal()
        offered = Signal(self.slot.shape(), reset_less=True)
        m.d.comb += [
            self.slots.p.eq(offered),
            queue.clear.eq(self.clear),
            queue.put.eq(self.put),
            queue.word.eq(self.slot),
            is_unused.eq(unused != self.total),
            # `ready` arrives late, so the next slot follows one cycle later.
            queue.words.ready.eq(~self.slots.valid & ~is_unused),
        ]
        with m.If(self.slots.ready):
            m.d.sync += self.slots.valid.eq(0)
        with m.If(~self.slots.valid):
            m.d.sync += [
                self.slots.valid.eq(is_unused | queue.words.valid),
                offered.eq(Mux(is_unused, unused, queue.words.p)),
            ]
            with m.If(is_unused):
                m.d.sync += unused.eq(unused + 1)
        with m.If(self.clear):
            m.d.sync += [self.slots.valid.eq(0), unused.eq(0)]

        return m
