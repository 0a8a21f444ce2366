"""Fit of the arcs of a path: whether tangents leave enough of each segment."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.unit import Choice, InstanceOf, Unit


__all__ = ["ArcFitter", "fitted_layout", "turn_layout"]


def turn_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a segment and of the turn into it.

    ``first``, ``last`` (the slot of a path's first point, which has no segment, or of its last
    point), ``length``, ``steep`` and ``excess`` (of the segment), ``half_turn``, ``tangent``.
    """
    return data.StructLayout(
        {
            "first": 1,
            "last": 1,
            "steep": 1,
            "excess": widths.excess,
            "length": widths.length,
            "half_turn": widths.half_turn,
            "tangent": widths.tangent,
        }
    )


def fitted_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a segment and of the arc at its end.

    ``first``, ``last`` (segment of its path), ``steep``, ``excess``, ``length`` (of the segment),
    ``next_length`` (of the next one), ``fits`` (there is an arc and it fits), ``half_turn``,
    ``tangent`` (of the arc; 0 if it does not fit).
    """
    return data.StructLayout(
        {
            "first": 1,
            "last": 1,
            "steep": 1,
            "excess": widths.excess,
            "length": widths.length,
            "next_length": widths.length,
            "fits": 1,
            "half_turn": widths.half_turn,
            "tangent": widths.length,
        }
    )


class ArcFitter(Unit):
    """Finds the arcs that fit.

    An arc fits if its tangent and the tangents of its neighbours leave each of its two segments a
    length of 0 or more. Therefore a segment, with the arc at its end, leaves when the second slot
    after its own enters, or, at the end of a path, in the two slots after the last, whatever they
    contain. That never collides, because the first two slots of a path have nothing to send.

    Slots without ``valid`` do not advance the contents, which move on with the next valid slot. The
    second slot of a path must follow the first immediately. Inputs are steady in all cycles of a
    slot.

    Source: step 2 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a slot to the slot of the segment that it sends: 2.

    Members
    -------
    phase : In(1)
    valid : In(1)
    turn : In(turn_layout)
        The tangent belongs to the turn into the segment; 0 in the first two slots of a path.
    moves : Out(1)
        The window moves on at the end of this slot of the input, and the points of
        :class:`pathgene.hdl.planner.scorer.arcs.ArcPlacer` move with it.
    fitted_valid : Out(1)
    fitted : Out(fitted_layout)
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    latency = 2

    def interface(self):
        widths = self.widths
        return {
            "phase": In(1),
            "valid": In(1),
            "turn": In(turn_layout(widths)),
            "moves": Out(1),
            "fitted_valid": Out(1),
            "fitted": Out(fitted_layout(widths)),
        }

    def elaborate(self, platform):
        m = Module()

        turn, length_bits = self.turn, self.widths.length
        # The slots one and two steps ago, and whether the slot before these began its path.
        before = Signal(turn_layout(self.widths), reset_less=True)
        second = Signal(turn_layout(self.widths), reset_less=True)
        opens = Signal(reset_less=True)
        sends, follows = Signal(), Signal()  # `second` is a segment; `before` is a slot.
        draining = Signal(2)

        # After the last point, and at the first point of the next path, there is no tangent.
        tangent = Signal(self.widths.tangent)
        # Length of the previous segment minus the tangent of the turn into it.
        left = Signal(signed(self.widths.tangent + 1), reset_less=True)
        # Whether that leaves enough: computed in the first cycle of a slot, for the next cycle.
        room, room_before = Signal(reset_less=True), Signal(reset_less=True)
        fits = Signal()
        # The segment to send, in the cycle after the comparison.
        sent = Signal(fitted_layout(self.widths), reset_less=True)
        sent_valid, sent_moves = Signal(), Signal()
        fitted = Signal(fitted_layout(self.widths), reset_less=True)
        m.d.comb += [
            self.fitted.eq(fitted),
            self.moves.eq(self.valid | draining.any()),
            tangent.eq(Mux(self.valid, turn.tangent, 0)),
            fits.eq(room & room_before & ~sent.last),
        ]
        m.d.sync += room.eq(tangent <= left)
        m.d["comb" if self.point_cycles == 2 else "sync"] += [
            sent_moves.eq(self.moves),
            sent_valid.eq(self.moves & sends),
            sent.first.eq(opens),
            sent.last.eq(second.last),
            sent.steep.eq(second.steep),
            sent.excess.eq(second.excess),
            sent.length.eq(second.length),
            sent.next_length.eq(before.length),
            sent.half_turn.eq(before.half_turn),
            sent.tangent.eq(before.tangent[:length_bits]),
        ]
        with m.If(self.phase):
            with m.If(self.valid & turn.last):
                m.d.sync += draining.eq(2)
            with m.Elif(draining.any()):
                m.d.sync += draining.eq(draining - 1)
            m.d.sync += [
                self.fitted_valid.eq(sent_valid),
                fitted.eq(sent),
                fitted.fits.eq(fits),
                fitted.tangent.eq(Mux(fits, sent.tangent, 0)),
            ]
            with m.If(sent_moves):
                m.d.sync += room_before.eq(room)
            with m.If(self.moves):
                m.d.sync += [
                    before.eq(turn),
                    before.tangent.eq(tangent),
                    left.eq(turn.length - tangent),
                    follows.eq(self.valid),
                    second.eq(before),
                    sends.eq(follows & ~before.first),
                    opens.eq(second.first),
                ]

        return m
