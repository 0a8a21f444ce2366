"""Crossover module: two parents swap their tails past the middle."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.chromosome import half_signature
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["Crossover", "parent_signature", "parents_of"]


def parent_signature(waypoint_bits: int, max_waypoints: int) -> wiring.Signature:
    """Return the signature of a parent at a port: its current waypoint and its length."""
    return wiring.Signature(
        {"waypoint": Out(waypoint_bits), "length": Out(range(max_waypoints + 1))}
    )


def parents_of(child: int, crossovers: int) -> tuple[int, int]:
    """Return the parents that supply a child's head and tail."""
    first = child // 2
    second = (first + 1) % crossovers
    return (second, first) if child % 2 else (first, second)


class Crossover(Unit):
    """Breeds two children from two parents.

    The parents pass in lockstep, one waypoint of each per cycle. The waypoints before the middle of
    a parent, rounded down, go to the head of one child, the rest to the tail of its sibling. The
    halves of a child are written separately, so both parents are accepted in every cycle and no
    half is written twice in a cycle. Children are written while the parents pass, without extra
    cycles.

    Source: *allaire-2008*, section 4.5.

    Members
    -------
    on : In(1)
        Waypoints pass.
    position : In(range(max_waypoints))
        Position of the waypoints in their paths.
    parents : In(parent_signature).array(2)
    heads, tails : Out(half_signature).array(2)
        Writes to each child. The first child gets the head of the first parent and the tail of the
        second; the second child gets the head of the second and the tail of the first.
        Combinational. ``valid`` and ``at`` depend only on ``on``, ``position`` and the lengths, so
        they can be computed before the waypoints arrive.
    """

    waypoint_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        parent = parent_signature(self.waypoint_bits, self.max_waypoints)
        half = half_signature(self.waypoint_bits, self.max_waypoints)
        return {
            "on": In(1),
            "position": In(range(self.max_waypoints)),
            "parents": In(parent).array(2),
            "heads": Out(half).array(2),
            "tails": Out(half).array(2),
        }

    def elaborate(self, platform):
        m = Module()

        for number in range(2):
            parent = self.parents[number]
            head = self.heads[number]
            tail = self.tails[1 - number]

            middle = Signal(range(self.max_waypoints // 2 + 1), name=f"middle_{number}")
            m.d.comb += [
                middle.eq(parent.length >> 1),
                head.valid.eq(self.on & (self.position < middle)),
                head.at.eq(self.position),
                head.waypoint.eq(parent.waypoint),
                tail.valid.eq(
                    self.on & (self.position >= middle) & (self.position < parent.length)
                ),
                tail.at.eq(self.position - middle),
                tail.waypoint.eq(parent.waypoint),
            ]

        return m
