"""Map corner nearest to an end."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.layouts import corner_layout
from pathgene.hdl.primitives.unit import Unit, Width
from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION


__all__ = ["NearestCorner"]


class NearestCorner(Unit):
    """Outputs the corner nearest to a position, and the altitude step at or below it.

    The corner is within the limits. It follows position and limits by one cycle. Equals
    :func:`pathgene.sim.model.planner.definition.score.corner_of`.

    Members
    -------
    position : In(position_layout)
        ``x``, ``y`` and ``altitude``, as in a problem.
    limits : In(corner_layout)
        The altitude is ignored.
    corner : Out(corner_layout)
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        corner = corner_layout(self.coordinate_bits, self.altitude_bits)
        self.position_layout = data.StructLayout(
            {
                "x": self.coordinate_bits + POSITION_FRACTION,
                "y": self.coordinate_bits + POSITION_FRACTION,
                "altitude": self.altitude_bits + ALTITUDE_FRACTION,
            }
        )
        return {"position": In(self.position_layout), "limits": In(corner), "corner": Out(corner)}

    def elaborate(self, platform):
        m = Module()

        position = self.position
        m.d.sync += self.corner.altitude.eq(position.altitude >> ALTITUDE_FRACTION)
        for axis in "xy":
            limit = self.limits[axis]
            nearest = (position[axis] + (1 << POSITION_FRACTION - 1)) >> POSITION_FRACTION
            m.d.sync += self.corner[axis].eq(Mux(nearest > limit, limit, nearest))

        return m
