"""A design of your own with the gateware of pathgene: bytes come in a frame and go back sorted.

docs/own_design.md explains it. ``python examples/sorting_service.py FILE.v`` writes its Verilog.
"""

import sys
from pathlib import Path

from amaranth import *
from amaranth.lib.wiring import In, Out, connect

from pathgene.hdl.link.line import Line
from pathgene.hdl.planner.sorter import Sorter
from pathgene.hdl.primitives.buffers import MemoryQueue, SkidBuffer
from pathgene.hdl.primitives.unit import Count, Unit


__all__ = ["SortingService"]


class SortingService(Unit):
    """Answers each frame on a UART with its bytes in ascending order.

    A frame has a body of 3 to ``capacity`` bytes; of a longer one, the lowest ``capacity`` bytes
    come back. A frame with a wrong checksum has no answer.

    Members
    -------
    rx : In(1)
    tx : Out(1)
        The line, 8N1.
    """

    clocks_per_bit: Count(4, 65535, "Divisor of the clock.")
    capacity: Count(3, 250, "Bytes that are sorted.")

    rx: In(1, init=1)
    tx: Out(1, init=1)

    def elaborate(self, platform):
        m = Module()

        m.submodules.line = line = Line(self.clocks_per_bit, receive_buffer=512)
        m.submodules.skid = skid = SkidBuffer(line.requests.payload.shape())
        m.submodules.sorter = sorter = Sorter(self.capacity, key_bits=8, tag_bits=1)
        m.submodules.queue = queue = MemoryQueue(8, self.capacity)

        connect(m, line.requests, skid.words)
        requests, replies, members = skid.passed, line.replies, sorter.members

        full = Signal()
        inside = Signal(range(self.capacity + 1))  # Members, those that fill up included.
        length = Signal(range(self.capacity + 1))  # Bytes of the answer.
        sent = Signal(range(self.capacity + 1))
        m.d.comb += [
            line.rx.eq(self.rx),
            self.tx.eq(line.tx),
            full.eq(inside == self.capacity),
            replies.p.data.eq(queue.words.p),
            replies.p.last.eq(sent + 1 == length),
            replies.p.plain.eq(1),
        ]
        with m.If(members.valid & members.ready & ~full):
            m.d.sync += inside.eq(inside + 1)

        with m.FSM():
            with m.State("TAKE"):
                m.d.comb += [
                    members.valid.eq(requests.valid),
                    members.p.key.eq(requests.p.data),
                    requests.ready.eq(members.ready),
                ]
                with m.If(requests.valid & requests.ready):
                    m.d.sync += length.eq(Mux(full, length, length + 1))
                    with m.If(requests.p.last):
                        m.next = "FILL"
            with m.State("FILL"):
                # The sorter empties when it is full: late members fill it up, after the bytes.
                m.d.comb += [members.p.key.eq(0xFF), members.p.late.eq(1)]
                with m.If(full):
                    m.d.comb += sorter.empty.eq(1)
                    m.next = "SEND"
                with m.Else():
                    m.d.comb += members.valid.eq(1)
            with m.State("SEND"):
                m.d.comb += [
                    queue.put.eq(sorter.left.valid & (sorter.left.rank < length)),
                    queue.word.eq(sorter.left.key),
                    replies.valid.eq(queue.words.valid),
                    queue.words.ready.eq(replies.ready),
                ]
                with m.If(replies.valid & replies.ready):
                    m.d.sync += sent.eq(sent + 1)
                    with m.If(replies.p.last):
                        m.d.sync += [sent.eq(0), inside.eq(0), length.eq(0)]
                        m.next = "TAKE"

        return m


if __name__ == "__main__":
    from pathgene.hdl.verilog import convert

    service = SortingService(clocks_per_bit=100, capacity=64)
    Path(sys.argv[1]).write_text(convert(service, "sorting_service"), encoding="utf-8")
