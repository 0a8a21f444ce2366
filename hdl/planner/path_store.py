"""Store of the paths under evaluation, and the payloads of the evaluator."""

from amaranth import *
from amaranth.lib import data, memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import head_layout
from pathgene.hdl.planner.scorer.scorer import chord_record_layout
from pathgene.hdl.planner.walker.layouts import chord_layout
from pathgene.hdl.planner.walker.segment_source import read_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol.planner import VALUE_BITS


__all__ = [
    "PLACES",
    "PLACE_BITS",
    "PathStore",
    "decision_layout",
    "kept_layout",
    "row_bits_of",
    "stored_layout",
    "taken_layout",
]


#: Maximum number of paths inside, a power of two.
PLACES = 16
PLACE_BITS = 4


def row_bits_of(max_waypoints: int) -> int:
    """Return the width of a path's row number: points beginning with the start, and the exit."""
    return (max_waypoints + 2).bit_length()


def taken_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a point, which is ``valid`` in the cycle in which it is taken."""
    return data.StructLayout({"valid": 1, "point": point_layout(coordinate_bits, altitude_bits)})


def stored_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a row: a point, and the chord there."""
    sizes = (coordinate_bits, altitude_bits)
    return data.StructLayout({"point": point_layout(*sizes), "chord": chord_layout(*sizes)})


def kept_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a stored path: place, head, length, and ``enters``.

    ``enters``: there is a chord at the start.
    """
    return data.StructLayout(
        {
            "place": PLACE_BITS,
            "head": head_layout(slot_bits),
            "length": length_bits,
            "enters": 1,
        }
    )


def decision_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a decision on a path, which is ``valid`` for one cycle.

    ``walked``: the path is walked, and its key waits for that. ``infeasible`` and ``value`` are as
    in its score.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "walked": 1,
            "infeasible": 1,
            "value": VALUE_BITS,
            "path": kept_layout(slot_bits, length_bits),
        }
    )


class PathStore(Unit):
    """Keeps points, chords and heads of the paths inside, in 16 places used in turn.

    Points arrive as the scorer takes them, records of chords as it makes them. A place has a row
    for each point, with the start in row 0, and one more for the record of an exit. A record goes
    to the row of its point: the first record to row 1, or to row 0 with an entry.

    A place is used again 16 paths later. Until then its rows can be read, and its head too while
    the path is the next to be scored.

    On a target the rows are in block RAMs: with 512 rows and 30 bits per point, one for points and
    two for chords. They are read and written in the same cycle, but never in the same row.

    Members
    -------
    has_entry : In(1)
        The records of each path begin with the record of its start. Steady.
    head : In(head_layout)
        Head of the path whose first point was taken in the previous cycle.
    taken : In(taken_layout)
    record : In(chord_record_layout)
    path : Out(kept_layout)
        The next path to be scored, from the second cycle after its goal and after its first record
        until ``scored``.
    scored : In(1)
        The path has been scored, at least 2 cycles after the previous path.
    read : In(read_layout)
    row : Out(stored_layout)
        The row read last, starting in the cycle after ``read.enable``.
    """

    max_waypoints: Count(2, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    slot_bits: Width(1)

    def interface(self):
        self.row_bits = row_bits_of(self.max_waypoints)
        self.length_bits = self.max_waypoints.bit_length()
        sizes = (self.coordinate_bits, self.altitude_bits)
        return {
            "has_entry": In(1),
            "head": In(head_layout(self.slot_bits)),
            "taken": In(taken_layout(*sizes)),
            "record": In(chord_record_layout(*sizes)),
            "path": Out(kept_layout(self.slot_bits, self.length_bits)),
            "scored": In(1),
            "read": In(read_layout(PLACE_BITS, self.row_bits)),
            "row": Out(stored_layout(*sizes)),
        }

    def elaborate(self, platform):
        m = Module()
        taken, record = self.taken, self.record

        def rows_of(name, shape):
            m.submodules[name] = rows = memory.Memory(
                shape=shape,
                depth=PLACES << self.row_bits,
                init=[],
                attrs={"no_rw_check": 1},
            )
            read = rows.read_port()
            m.d.comb += [
                read.en.eq(self.read.enable),
                read.addr.eq(Cat(self.read.row, self.read.place)),
                self.row[name].eq(read.data),
            ]
            return rows.write_port()

        # Places of the next point and the next record; rows of a path are counted from 0.
        point = rows_of("point", taken.point.shape())
        place, index = Signal(PLACE_BITS), Signal(self.row_bits)
        m.d.comb += [
            point.en.eq(taken.valid),
            point.addr.eq(Cat(index, place)),
            point.data.eq(taken.point),
        ]
        with m.If(taken.valid):
            m.d.sync += [
                index.eq(Mux(taken.point.last, 0, index + 1)),
                place.eq(place + taken.point.last),
            ]
        chord = rows_of("chord", self.row.chord.shape())
        recorded, number = Signal(PLACE_BITS), Signal(self.row_bits)
        m.d.comb += [
            chord.en.eq(record.valid),
            chord.addr.eq(Cat((number + ~self.has_entry)[: self.row_bits], recorded)),
            *(chord.data[name].eq(record[name]) for name, _ in chord.data.shape()),
        ]
        with m.If(record.valid):
            m.d.sync += [
                number.eq(Mux(record.last, 0, number + 1)),
                recorded.eq(recorded + record.last),
            ]

        # For each place: head, length, and whether there is a chord at the start.
        scored = Signal(PLACE_BITS)
        path = Signal(self.path.shape(), reset_less=True)
        m.d.comb += self.path.eq(path)
        m.d.sync += [scored.eq(scored + self.scored), path.place.eq(scored)]
        # A path has at least two points, so its place stays for a cycle after the first.
        opened = Signal()
        m.d.sync += opened.eq(taken.valid & (index == 0))
        for name, enable, at, value in (
            ("head", opened, place, self.head),
            ("length", taken.valid & taken.point.last, place, index - 1),
            ("enters", record.valid & (number == 0), recorded, record.present & self.has_entry),
        ):
            m.submodules[name] = rows = memory.Memory(
                shape=path[name].shape(), depth=PLACES, init=[]
            )
            write, read = rows.write_port(), rows.read_port(domain="comb")
            m.d.comb += [
                write.en.eq(enable),
                write.addr.eq(at),
                write.data.eq(value),
                read.addr.eq(scored),
            ]
            m.d.sync += path[name].eq(read.data)

        return m
