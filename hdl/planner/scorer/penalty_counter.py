"""Penalty of a path by its score."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import POSITION_FRACTION, STEEP, VALUE_BITS


__all__ = ["PenaltyCounter", "judged_layout"]

#: A length of one cell: the minimum that counts for an arc that is too steep.
_CELL = 1 << POSITION_FRACTION

#: A missing arc counts as an eighth of the path.
_SHARE_SHIFT = 3


def judged_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a segment and the arc at its end, with their faults.

    ``first``, ``last`` (segment of its path), ``steep`` (the segment is), ``excess`` (of a steep
    one), ``sharp`` (the arc does not fit), ``steep_arc`` (the arc is), ``length``, ``arc_length``.
    """
    return data.StructLayout(
        {
            "first": 1,
            "last": 1,
            "steep": 1,
            "excess": widths.excess,
            "sharp": 1,
            "steep_arc": 1,
            "length": widths.length,
            "arc_length": widths.arc,
        }
    )


class PenaltyCounter(Unit):
    """Adds up a path's penalty.

    A quarter of a cell and the excess count for each steep segment, an eighth of the path for each
    missing arc, and the length of each steep arc, at least a cell.

    Source: step 5 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from the slot of a path's last segment to the slot of its penalty.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    valid : In(1)
    judged : In(judged_layout)
    penalty : Out(VALUE_BITS)
        Saturates at its maximum value.
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        self.sharp = WideMultiplier(widths.total, widths.count, _SHARE_SHIFT)
        self.latency = (2 + 3 + self.sharp.latency | 1) + 1
        return {
            "phase": In(1),
            "valid": In(1),
            "judged": In(judged_layout(widths)),
            "penalty": Out(VALUE_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        judged, widths = self.judged, self.widths
        stages = Schedule(m, self.phase)
        added = {
            "total": (widths.total, judged.length),
            "steep": (widths.steep, Mux(judged.steep, judged.excess + STEEP, 0)),
            "sharp": (widths.count, judged.sharp),
            "steep_arcs": (
                widths.steep_arcs,
                Mux(judged.steep_arc, _at_least_a_cell(judged.arc_length), 0),
            ),
        }
        sums = {}
        for name, (width, value) in added.items():
            total = Signal(width, name=f"{name}_sum", reset_less=True)
            with m.If(self.phase & self.valid):
                m.d.sync += total.eq(Mux(judged.first, 0, total) + value)
            sums[name] = Timed(total, 2)

        product = stages.through(
            "sharp", self.sharp, "product", first=sums["total"], second=sums["sharp"]
        )
        penalty = stages.compute(
            "steep_or_sharp", lambda product, steep: product + steep, product, sums["steep"]
        )
        whole = stages.compute(
            "whole", lambda penalty, arcs: penalty + arcs, penalty, sums["steep_arcs"]
        )
        limit = (1 << VALUE_BITS) - 1
        ended = stages.compute(
            "ended",
            lambda whole: Mux(whole[VALUE_BITS:].any(), limit, whole[:VALUE_BITS]),
            whole,
        )
        penalty = stages.hold("penalty_held", ended)
        assert penalty.time == self.latency
        m.d.comb += self.penalty.eq(penalty.value)

        return m


def _at_least_a_cell(length):
    """Return a length, or one cell if the length is shorter."""
    return Mux(length[POSITION_FRACTION:].any(), length, _CELL)
