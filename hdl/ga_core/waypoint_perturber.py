"""Perturber of a waypoint that passes, on a chip without a map."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.mutation_plan import plan_layout
from pathgene.hdl.primitives.multiplexer import multiplex
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["WaypointPerturber", "within"]


def within(m: Module, total: Value, limit: Value) -> Signal:
    """Return ``total`` limited to 0..``limit``. Combinational."""
    value = Signal(limit.shape(), name="within")
    with m.If(total < 0):
        m.d.comb += value.eq(0)
    with m.Elif(total > limit):
        m.d.comb += value.eq(limit)
    with m.Else():
        m.d.comb += value.eq(total)
    return value


class WaypointPerturber(Unit):
    """Takes the waypoint of a mutator while it passes the port of its parent, and moves it.

    ``moved`` follows 2 cycles later: the waypoint is registered in the first and moved in the
    second. The limits apply without a register.

    Source: *allaire-2008*, section 4.6.

    Members
    -------
    plan : In(plan_layout)
        Must stay until ``moved`` is used.
    offset : In(offset_layout)
    limits : In(limits_layout)
    carrying : In(1)
    position : In(range(max_waypoints))
    waypoints : In(waypoint_bits).array(crossovers)
        While ``carrying``: waypoint of each parent at ``position``.
    moved : Out(waypoint_bits)
        A waypoint has the width of ``limits_layout``.
    """

    crossovers: Count(2, text="Crossover modules. Each has a parent.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    limits_layout: Given(
        "StructLayout",
        "With ``x``, ``y`` and ``altitude``: see :mod:`pathgene.hdl.ga_core.layouts`.",
    )
    offset_layout: Given(
        "StructLayout",
        "With ``x``, ``y`` and ``altitude``: see :mod:`pathgene.hdl.ga_core.layouts`.",
    )

    def interface(self):
        return {
            "plan": In(plan_layout(self.crossovers, self.max_waypoints)),
            "offset": In(self.offset_layout),
            "limits": In(self.limits_layout),
            "carrying": In(1),
            "position": In(range(self.max_waypoints)),
            "waypoints": In(self.limits_layout.size).array(self.crossovers),
            "moved": Out(self.limits_layout.size),
        }

    def elaborate(self, platform):
        m = Module()

        passed = Signal(self.limits_layout, reset_less=True)
        with m.If(self.carrying & (self.position == self.plan.position)):
            m.d.sync += passed.eq(multiplex(self.plan.parent, self.waypoints))

        moved = Signal(self.limits_layout)
        m.d.comb += self.moved.eq(moved)
        for axis in ("x", "y", "altitude"):
            total = passed[axis] + self.offset[axis]
            far = Signal(total.shape(), name=f"far_{axis}", reset_less=True)
            m.d.sync += far.eq(total)
            m.d.comb += moved[axis].eq(within(m, far, self.limits[axis]))

        return m
