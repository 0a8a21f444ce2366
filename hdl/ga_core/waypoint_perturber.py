"""Perturber of a waypoint that passes, on a chip without a map."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.mutation_plan import plan_layout
from pathgene.hdl.primitives.arguments import check_integer
from pathgene.hdl.primitives.multiplexer import multiplex


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


class WaypointPerturber(wiring.Component):
    """Takes the waypoint of a mutator while it passes the port of its parent, and moves it.

    ``moved`` follows 2 cycles later: the waypoint is registered in the first and moved in the
    second. The limits apply without a register.

    Source: *allaire-2008*, section 4.6.

    Parameters
    ----------
    crossovers : int
        Crossover modules, 2 or more. Each has a parent.
    max_waypoints : int
        Waypoints of the longest path, 3 or more.
    limits_layout, offset_layout : StructLayout
        With ``x``, ``y`` and ``altitude``: see :mod:`pathgene.hdl.ga_core.layouts`.

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

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, *, crossovers, max_waypoints, limits_layout, offset_layout):
        check_integer("Crossovers", crossovers, 2)
        check_integer("Max waypoints", max_waypoints, 3)

        self.crossovers = crossovers
        self.max_waypoints = max_waypoints
        self.limits_layout = limits_layout
        self.offset_layout = offset_layout
        super().__init__(
            {
                "plan": In(plan_layout(crossovers, max_waypoints)),
                "offset": In(offset_layout),
                "limits": In(limits_layout),
                "carrying": In(1),
                "position": In(range(max_waypoints)),
                "waypoints": In(limits_layout.size).array(crossovers),
                "moved": Out(limits_layout.size),
            }
        )

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
