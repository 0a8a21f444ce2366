"""Corner of the map nearest to an end."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.population_layouts import corner_layout
from pathgene.hdl.primitives.arguments import check_integer
from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION


__all__ = ["NearestCorner"]


class NearestCorner(wiring.Component):
    """Gives the corner nearest to a position, and the step at or below it.

    The corner is within the limits. It follows position and limits by a cycle. Equals
    :func:`pathgene.sim.model.planner.definition.score.corner_of`.

    Parameters
    ----------
    coordinate_bits, altitude_bits : int
        Widths of a coordinate and of an altitude, 1 or more.

    Members
    -------
    position : In(position_layout)
        ``x``, ``y`` and ``altitude``, as a problem has them.
    limits : In(corner_layout)
        The altitude means nothing.
    corner : Out(corner_layout)

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, coordinate_bits: int, altitude_bits: int):
        check_integer("Coordinate width", coordinate_bits, 1)
        check_integer("Altitude width", altitude_bits, 1)

        self.coordinate_bits = coordinate_bits
        self.altitude_bits = altitude_bits
        corner = corner_layout(coordinate_bits, altitude_bits)
        self.position_layout = data.StructLayout(
            {
                "x": coordinate_bits + POSITION_FRACTION,
                "y": coordinate_bits + POSITION_FRACTION,
                "altitude": altitude_bits + ALTITUDE_FRACTION,
            }
        )
        super().__init__(
            {"position": In(self.position_layout), "limits": In(corner), "corner": Out(corner)}
        )

    def elaborate(self, platform):
        m = Module()

        position = self.position
        m.d.sync += self.corner.altitude.eq(position.altitude >> ALTITUDE_FRACTION)
        for axis in "xy":
            limit = self.limits[axis]
            nearest = (position[axis] + (1 << POSITION_FRACTION - 1)) >> POSITION_FRACTION
            m.d.sync += self.corner[axis].eq(Mux(nearest > limit, limit, nearest))

        return m
