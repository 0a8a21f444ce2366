"""Queue of chords in a block RAM."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.primitives.arguments import check_power_of_two
from hdl.primitives.commit_ring import CommitRing


__all__ = ["ChordQueue", "chord_layout"]


def chord_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of an arc's chord: ``exists``, and its ``ends``, each x, y, altitude."""
    end = data.StructLayout({"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits})
    return data.StructLayout({"exists": 1, "ends": data.ArrayLayout(end, 2)})


class ChordQueue(wiring.Component):
    """First-in, first-out queue of the chords of waypoints.

    The two ends of a chord are two rows, one written in each cycle of a slot; a chord is read in
    two cycles. It is offered 5 cycles after its slot.

    Parameters
    ----------
    coordinate_bits, altitude_bits : int
        Widths of a point.
    depth : int
        Chords that fit, a power of two from 2 on. Further ones are lost.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    put : In(1)
        Put ``chord`` in, in this slot.
    chord : In(chord_layout)
    chords : Out(stream.Signature(chord_layout))

    Raises
    ------
    TypeError, ValueError
        If the depth is not such a power.
    """

    def __init__(self, coordinate_bits: int, altitude_bits: int, depth: int):
        check_power_of_two("Chords", depth, 2, 1 << 15)
        self.depth = depth
        self.layout = chord_layout(coordinate_bits, altitude_bits)
        end = self.layout["ends"].shape.elem_shape
        self.row_layout = data.StructLayout({"exists": 1, "corner": end})
        super().__init__(
            {
                "phase": In(1),
                "put": In(1),
                "chord": In(self.layout),
                "chords": Out(stream.Signature(self.layout)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.ring = rows = CommitRing(self.row_layout, 2 * self.depth)
        written = Signal(exact_log2(self.depth) + 1)
        m.d.comb += [
            rows.write_enable.eq(self.put),
            rows.write_row.eq(Cat(self.phase, written)),
            rows.write_data.exists.eq(self.chord.exists),
            rows.write_data.corner.eq(
                Mux(
                    self.phase,
                    self.chord.ends[1].as_value(),
                    self.chord.ends[0].as_value(),
                )
            ),
            rows.committed.eq(Cat(C(0, 1), written)),
        ]
        with m.If(self.put & self.phase):
            m.d.sync += written.eq(written + 1)

        # The first end waits for the second.
        kept, full = Signal(self.row_layout, reset_less=True), Signal()
        m.d.comb += [
            rows.words.ready.eq(~full | self.chords.ready),
            self.chords.valid.eq(full & rows.words.valid),
            self.chords.p.exists.eq(kept.exists),
            self.chords.p.ends[0].eq(kept.corner),
            self.chords.p.ends[1].eq(rows.words.p.corner),
        ]
        with m.If(rows.words.valid & rows.words.ready):
            m.d.sync += [full.eq(~full), kept.eq(rows.words.payload)]

        return m
