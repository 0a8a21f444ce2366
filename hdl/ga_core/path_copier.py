"""Copier of a path that is kept."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.chromosome import half_signature
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["PathCopier"]


class PathCopier(Unit):
    """Writes a path that passes through a port to a slot, in order.

    ``valid`` and ``at`` belong to the next waypoint and depend only on ``on``, ``position`` and
    ``length``; ``waypoint`` is the one that passes now.

    Members
    -------
    on : In(1)
        Waypoints pass starting in the next cycle.
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
