"""First colliding cell of a group."""

from amaranth import *
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.lanes import group_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import lane_row_bits
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width


__all__ = ["HitLocator"]


class HitLocator(Unit):
    """Finds the first colliding cell of a group, and counts all colliding cells, one cycle later.

    Along a segment the lanes follow each other starting with the lane of the group's first cell,
    wrapping around to the lane before it, or in the opposite order if the segment descends.

    Members
    -------
    group : In(group_layout)
    hits, blocked : In(lanes)
        Lanes whose cells collide, and lanes whose cells are blocked, which also collide.
    hit : Out(1)
    until : Out(range(lanes + 1))
    x, y : Out(coordinate_bits)
    terrain, nofly : Out(range(lanes + 1))
        See :func:`pathgene.hdl.feasibility.walker_signature.step_layout`.
    """

    lanes: PowerOfTwo(1, "1 << coordinate_bits", "Cells of a group.")
    coordinate_bits: Width(1)

    def interface(self):
        return {
            "group": In(group_layout(self.lanes, self.coordinate_bits)),
            "hits": In(self.lanes),
            "blocked": In(self.lanes),
            "hit": Out(1),
            "until": Out(range(self.lanes + 1)),
            "x": Out(self.coordinate_bits),
            "y": Out(self.coordinate_bits),
            "terrain": Out(range(self.lanes + 1)),
            "nofly": Out(range(self.lanes + 1)),
        }

    def elaborate(self, platform):
        m = Module()
        group, lanes = self.group, self.lanes
        lane_bits = exact_log2(lanes)

        # Mirrored if the segment descends, lane numbers rise along it, except those that have
        # wrapped around: these come last.
        start = group.major[:lane_bits]
        mirrored, late = Signal(lanes), Signal(lanes)
        m.d.comb += mirrored.eq(Mux(group.descending, self.hits[::-1], self.hits))
        for number in range(lanes):
            opposite = lanes - 1 - number
            # Written without comparisons whose result is constant.
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
