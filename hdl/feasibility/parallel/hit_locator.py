"""First colliding cell of a group."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.lanes import group_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import lane_row_bits
from pathgene.hdl.primitives.arguments import check_integer, check_power_of_two


__all__ = ["HitLocator"]


class HitLocator(wiring.Component):
    """Finds the first colliding cell of a group, and counts all that collide; one cycle later.

    Along a segment the lanes follow each other from that of the group's first cell on, wrapping
    around to the one before it, or in the opposite order if the segment descends.

    Parameters
    ----------
    lanes : int
        Cells of a group: a power of two, at most the cells along an edge of the map.
    coordinate_bits : int
        Width of a coordinate, 1 or more.

    Members
    -------
    group : In(group_layout)
    hits, blocked : In(lanes)
        Lanes whose cells collide, and those of them that are blocked.
    hit : Out(1)
    until : Out(range(lanes + 1))
    x, y : Out(coordinate_bits)
    terrain, nofly : Out(range(lanes + 1))
        See :func:`pathgene.hdl.feasibility.walker_signature.step_layout`.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, lanes: int, coordinate_bits: int):
        check_integer("Coordinate width", coordinate_bits, 1)
        check_power_of_two("Lanes", lanes, 1, 1 << coordinate_bits)
        self.lanes = lanes
        self.coordinate_bits = coordinate_bits
        super().__init__(
            {
                "group": In(group_layout(lanes, coordinate_bits)),
                "hits": In(lanes),
                "blocked": In(lanes),
                "hit": Out(1),
                "until": Out(range(lanes + 1)),
                "x": Out(coordinate_bits),
                "y": Out(coordinate_bits),
                "terrain": Out(range(lanes + 1)),
                "nofly": Out(range(lanes + 1)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        group, lanes = self.group, self.lanes
        lane_bits = exact_log2(lanes)

        # Mirrored if the segment descends, lane numbers rise along it, except those that have
        # wrapped around: these come later.
        start = group.major[:lane_bits]
        mirrored, late = Signal(lanes), Signal(lanes)
        m.d.comb += mirrored.eq(Mux(group.descending, self.hits[::-1], self.hits))
        for number in range(lanes):
            opposite = lanes - 1 - number
            # Written so that no number is compared with what it always is.
            m.d.comb += late[number].eq(
                Mux(
                    group.descending,
                    start < opposite if opposite else 0,
                    start > number if opposite else 0,
                )
            )
        chosen, gone = Signal(lanes), Signal()
        early = mirrored & ~late
        m.d.comb += [
            gone.eq(~early.any()),
            chosen.eq(Mux(gone, _lowest(mirrored & late), _lowest(early))),
        ]

        # All lanes that have wrapped around are in the same row.
        row = Signal(lane_row_bits(lanes, self.coordinate_bits), reset_less=True)
        here = group.major[lane_bits:]
        first = Signal(lanes, reset_less=True)
        places = [Signal.like(self.until, name=f"place_{n}", reset_less=True) for n in range(lanes)]
        now = Signal.like(group, reset_less=True)
        m.d.sync += [
            now.eq(group),
            row.eq(Mux(gone, Mux(group.descending, here - 1, here + 1), here)),
            first.eq(Mux(group.descending, chosen[::-1], chosen)),
            self.hit.eq(self.hits.any()),
            self.terrain.eq(sum(self.hits & ~self.blocked)),
            self.nofly.eq(sum(self.blocked)),
            *(
                place.eq(Mux(group.descending, start - number, number - start)[:lane_bits] + 1)
                for number, place in enumerate(places)
            ),
        ]

        major, minor = (Signal(self.coordinate_bits, name=n) for n in ("major", "minor"))
        m.d.comb += [
            self.until.eq(_selected(first, places)),
            minor.eq(_selected(first, now.minors)),
            major.eq(Cat(_selected(first, range(lanes))[:lane_bits], row)),
            self.x.eq(Mux(now.steep, minor, major)),
            self.y.eq(Mux(now.steep, major, minor)),
        ]

        return m


def _lowest(flags):
    return flags & (~flags + 1)[: len(flags)]


def _selected(flags, items):
    """Return the item of the flag that is set, 0 of none."""
    result = Const(0)
    for flag, item in zip(flags, items, strict=True):
        result |= Mux(flag, item, 0)
    return result
