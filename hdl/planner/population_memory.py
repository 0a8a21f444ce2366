"""Memory of the waypoints of all paths."""

from amaranth import *
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.planner.population_layouts import corner_layout, waypoint_layout
from hdl.primitives.arguments import check_integer


__all__ = ["PopulationMemory", "margin_layout", "place_layout", "write_layout"]


class PopulationMemory(wiring.Component):
    """Waypoints by slot and place, with the least margin of the segments at each.

    Corners and margins are two memories of the same rows: a write of a waypoint goes to both, and a
    margin alone is written in a cycle without. With ``corners_only`` writes leave the margins as
    they are, and the two do not meet. Each memory has one port for writes and one for reads, so
    block RAMs take all of it. A row must not be read in the cycle in which it is written.

    Parameters
    ----------
    slots : int
        Paths, 2 or more.
    max_waypoints : int
        Waypoints of the longest path, 2 or more.
    coordinate_bits, altitude_bits : int
        Widths of a coordinate and of an altitude, 1 or more.

    Members
    -------
    read : In(place_layout)
        ``slot`` and ``index`` of a waypoint. Read in every cycle.
    waypoint : Out(waypoint_layout)
        The waypoint there, 2 cycles later. A register.
    corners_only : In(1)
        A write leaves the margin as it is.
    write : In(write_layout)
        ``valid``: write ``waypoint`` to ``place``.
    margins : In(stream.Signature(margin_layout))
        Margins to be written: ``place`` and ``margin``. Not ready in a cycle with a write of both.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, slots, max_waypoints, coordinate_bits, altitude_bits):
        check_integer("Slots", slots, 2)
        check_integer("Max waypoints", max_waypoints, 2)
        check_integer("Coordinate width", coordinate_bits, 1)
        check_integer("Altitude width", altitude_bits, 1)

        self.slots = slots
        self.max_waypoints = max_waypoints
        self.coordinate_bits = coordinate_bits
        self.altitude_bits = altitude_bits
        self.corner_layout = corner_layout(coordinate_bits, altitude_bits)
        self.waypoint_layout = waypoint_layout(coordinate_bits, altitude_bits)
        self.place_layout = place_layout(slots, max_waypoints)
        self.write_layout = write_layout(slots, max_waypoints, self.waypoint_layout)
        self.margin_layout = margin_layout(slots, max_waypoints, altitude_bits)
        super().__init__(
            {
                "read": In(self.place_layout),
                "waypoint": Out(self.waypoint_layout),
                "corners_only": In(1),
                "write": In(self.write_layout),
                "margins": In(stream.Signature(self.margin_layout)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        index_bits = len(self.read.index)
        rows = self.slots << index_bits

        def memory_of(shape):
            return memory.Memory(shape=shape, depth=rows, init=[], attrs={"no_rw_check": 1})

        m.submodules.corners = corners = memory_of(self.corner_layout)
        m.submodules.margin_rows = margin_rows = memory_of(self.waypoint_layout["margin"].shape)

        def row_of(place):
            return Cat(place.index, place.slot)

        write, margin = self.write, self.margins
        corner_write, corner_read = corners.write_port(), corners.read_port()
        margin_write, margin_read = margin_rows.write_port(), margin_rows.read_port()
        writes_both = Signal()
        m.d.comb += [
            corner_read.addr.eq(row_of(self.read)),
            corner_write.addr.eq(row_of(write.place)),
            corner_write.en.eq(write.valid),
            *(corner_write.data[axis].eq(write.waypoint[axis]) for axis in ("x", "y", "altitude")),
            margin_read.addr.eq(row_of(self.read)),
            writes_both.eq(write.valid & ~self.corners_only),
            margin_write.addr.eq(Mux(writes_both, row_of(write.place), row_of(margin.p.place))),
            margin_write.en.eq(writes_both | margin.valid),
            margin_write.data.eq(Mux(writes_both, write.waypoint.margin, margin.p.margin)),
            margin.ready.eq(~writes_both),
        ]
        waypoint = Signal(self.waypoint_layout, reset_less=True)
        m.d.comb += self.waypoint.eq(waypoint)
        m.d.sync += [
            *(waypoint[axis].eq(corner_read.data[axis]) for axis in ("x", "y", "altitude")),
            waypoint.margin.eq(margin_read.data),
        ]

        return m


def place_layout(slots, max_waypoints):
    """Return the layout of the place of a waypoint: its path's slot, and its index there."""
    return data.StructLayout({"slot": range(slots), "index": range(max_waypoints)})


def margin_layout(slots, max_waypoints, altitude_bits):
    """Return the layout of a margin and the place of its waypoint."""
    return data.StructLayout(
        {"place": place_layout(slots, max_waypoints), "margin": signed(altitude_bits + 1)}
    )


def write_layout(slots, max_waypoints, waypoint):
    """Return the layout of a write of a ``waypoint`` to a place."""
    return data.StructLayout(
        {"valid": 1, "place": place_layout(slots, max_waypoints), "waypoint": waypoint}
    )
