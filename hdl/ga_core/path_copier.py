"""Copier of a path that is kept."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.chromosome import half_signature
from pathgene.hdl.primitives.arguments import check_integer


__all__ = ["PathCopier"]


class PathCopier(wiring.Component):
    """Writes a path that passes through a port to a slot, in order.

    ``valid`` and ``at`` belong to the next waypoint and depend on ``on``, ``position`` and
    ``length`` alone; ``waypoint`` is the one that passes now.

    Parameters
    ----------
    waypoint_bits : int
        Width of a waypoint.
    max_waypoints : int
        Waypoints of the longest path, 3 or more.

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

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, waypoint_bits, max_waypoints):
        check_integer("Waypoint width", waypoint_bits, 1)
        check_integer("Max waypoints", max_waypoints, 3)

        self.waypoint_bits = waypoint_bits
        self.max_waypoints = max_waypoints
        half = half_signature(waypoint_bits, max_waypoints)
        super().__init__(
            {
                "on": In(1),
                "position": In(range(max_waypoints)),
                "length": In(range(max_waypoints + 1)),
                "waypoint": In(waypoint_bits),
                "head": Out(half),
                "tail": Out(half),
            }
        )

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
