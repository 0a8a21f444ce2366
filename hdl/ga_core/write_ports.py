"""Write ports of the population: the host's writes, and copies of paths."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from pathgene.hdl.ga_core.chromosome import half_signature, place_shape
from pathgene.hdl.layouts import write_layout
from pathgene.hdl.primitives.logic import fanout
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["PathCopier", "WriteDecoder"]


class WriteDecoder(Unit):
    """Accepts waypoints for the population, one per cycle, and decodes the place of each.

    All outputs except ``taken`` are registers, because they reach all slots. They belong to the
    waypoint taken in the previous cycle.

    Members
    -------
    writes : In(stream.Signature(write_layout))
        Waypoints, each with its slot and its index.
    allow : In(1)
        Waypoints are accepted.
    taken : Out(1)
        A waypoint is accepted in this cycle. Combinational.
    writing : Out(1).array(parts)
        A waypoint was accepted in the previous cycle. All bits are equal.
    waypoint : Out(waypoint_bits)
    slots : Out(population)
        The slot, decoded, one-hot.
    completed : Out(population)
        ``slots`` if the waypoint ends its path, otherwise 0.
    in_tail : Out(1)
        The waypoint belongs to the tail of the slot.
    at : Out(place_shape(max_waypoints))
        Place of the waypoint in its half.
    length : Out(range(max_waypoints + 1))
        Waypoints of the path if this one ends it.
    """

    population: Count(2, text="Slots.")
    waypoint_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    parts: Count(1, text="Parts of the chip that get ``writing``, each from a register.")

    def interface(self):
        write = write_layout(
            ceil_log2(self.population), ceil_log2(self.max_waypoints), self.waypoint_bits
        )
        return {
            "writes": In(stream.Signature(write)),
            "allow": In(1),
            "taken": Out(1),
            "writing": Out(1).array(self.parts),
            "waypoint": Out(self.waypoint_bits),
            "slots": Out(self.population),
            "completed": Out(self.population),
            "in_tail": Out(1),
            "at": Out(place_shape(self.max_waypoints)),
            "length": Out(range(self.max_waypoints + 1)),
        }

    def elaborate(self, platform):
        m = Module()
        write = self.writes.p
        head_size = self.max_waypoints // 2

        written = Signal.like(write, reset_less=True)  # Synthesis drops its unused fields.
        slots = Signal.like(self.slots, reset_less=True)
        length = Signal.like(self.length, reset_less=True)
        last = Signal()
        writing = fanout(m, *[self.taken] * self.parts, name="writing")
        m.d.comb += [
            self.writes.ready.eq(self.allow),
            self.taken.eq(self.writes.valid & self.allow),
            *(part.eq(register) for part, register in zip(self.writing, writing, strict=True)),
            self.waypoint.eq(written.waypoint),
            self.slots.eq(slots),
            self.completed.eq(Cat(last & slot for slot in slots)),
            self.length.eq(length),
        ]

        in_tail = write.index >= head_size
        m.d.sync += [
            last.eq(self.taken & write.last),
            written.eq(write),
            slots.eq(1 << write.slot),
            length.eq(write.index + 1),
            self.in_tail.eq(in_tail),
            self.at.eq(Mux(in_tail, write.index - head_size, write.index)),
        ]

        return m


class PathCopier(Unit):
    """Writes a path that passes through a port to a slot, in order of its waypoints.

    ``valid`` and ``at`` belong to the next waypoint and depend only on ``on``, ``position`` and
    ``length``; ``waypoint`` is the waypoint that passes now.

    Members
    -------
    on : In(1)
        Waypoints pass from the next cycle on.
    position : In(range(max_waypoints))
        Position of the waypoint of the next cycle in its path.
    length : In(range(max_waypoints + 1))
        Length of the path.
    waypoint : In(waypoint_bits)
    head, tail : Out(half_signature)
        Combinational.
    """

    waypoint_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        half = half_signature(self.waypoint_bits, self.max_waypoints)
        return {
            "on": In(1),
            "position": In(range(self.max_waypoints)),
            "length": In(range(self.max_waypoints + 1)),
            "waypoint": In(self.waypoint_bits),
            "head": Out(half),
            "tail": Out(half),
        }

    def elaborate(self, platform):
        m = Module()
        head_size = self.max_waypoints // 2

        inside = Signal()
        m.d.comb += [
            inside.eq(self.on & (self.position < self.length)),
            self.head.valid.eq(inside & (self.position < head_size)),
            self.head.at.eq(self.position),
            self.head.waypoint.eq(self.waypoint),
            self.tail.valid.eq(inside & (self.position >= head_size)),
            self.tail.at.eq(self.position - head_size),
            self.tail.waypoint.eq(self.waypoint),
        ]

        return m
