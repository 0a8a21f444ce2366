"""Makes the new waypoint of a mutator out of one that passes by."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.ga_core.layouts import limits_layout, offset_layout
from hdl.ga_core.mutation_plan import plan_layout
from hdl.primitives.multiplexer import multiplex


__all__ = ["WaypointPerturber", "within"]


def within(m: Module, total: Value, limit: Value) -> Signal:
    """Return ``total`` limited to 0..``limit``, at once."""
    value = Signal(limit.shape(), name="within")
    with m.If(total < 0):
        m.d.comb += value.eq(0)
    with m.Elif(total > limit):
        m.d.comb += value.eq(limit)
    with m.Else():
        m.d.comb += value.eq(total)
    return value


class WaypointPerturber(wiring.Component):
    """Takes the waypoint that a mutator works on as it passes through the port of its parent.

    ``moved`` is there two clocks later: it is moved in the first, and kept within the limits in
    the second.

    Source: *allaire-2008*, section 4.6.

    Parameters
    ----------
    config : Config

    Members
    -------
    plan : In(plan_layout)
        Must stay until ``moved`` is used.
    offset : In(offset_layout)
    limits : In(limits_layout)
    carrying : In(1)
    position : In(index_bits)
    waypoints : In(waypoint_bits).array(crossovers)
        While ``carrying``: waypoint of each parent at ``position``.
    moved : Out(waypoint_bits)
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        super().__init__(
            {
                "plan": In(plan_layout(config)),
                "offset": In(offset_layout(config)),
                "limits": In(limits_layout(config)),
                "carrying": In(1),
                "position": In(config.index_bits),
                "waypoints": In(config.waypoint_bits).array(config.crossovers),
                "moved": Out(config.waypoint_bits),
            }
        )

    def elaborate(self, platform):
        m = Module()

        axes = limits_layout(self.config)
        passed = Signal(axes, reset_less=True)
        with m.If(self.carrying & (self.position == self.plan.position)):
            m.d.sync += passed.eq(multiplex(self.plan.parent, self.waypoints))

        moved = Signal(axes)
        m.d.comb += self.moved.eq(moved)
        for axis in ("x", "y", "altitude"):
            total = passed[axis] + self.offset[axis]
            far = Signal(total.shape(), name=f"far_{axis}", reset_less=True)
            m.d.sync += far.eq(total)
            m.d.comb += moved[axis].eq(within(m, far, self.limits[axis]))

        return m
