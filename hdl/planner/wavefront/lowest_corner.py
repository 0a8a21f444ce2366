"""Lowest corner of a few neighbours."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width


__all__ = ["LowestCorner", "lowest_layout"]


def lowest_layout(lanes, altitude_bits):
    """Return the layout of the lowest corner: its lane and altitude; ``blocked``: any corner is."""
    return data.StructLayout(
        {"lane": exact_log2(lanes), "altitude": altitude_bits, "none": 1, "blocked": 1}
    )


class LowestCorner(Unit):
    """First of the lowest corners in a row, by halving the row in every cycle.

    ``lowest`` follows :attr:`latency` cycles after the corners. Its ``none`` is high if no corner
    qualifies.

    Attributes
    ----------
    latency : int

    Members
    -------
    corners : In(altitude_bits).array(lanes)
    counts : In(lanes)
        Lanes that have a corner to be counted.
    lowest : Out(lowest_layout)
    """

    lanes: PowerOfTwo(1, 64, "Corners in a row.")
    altitude_bits: Width(1, text="The top value marks a blocked corner.")

    def interface(self):
        self.latency = 1 + exact_log2(self.lanes)
        return {
            "corners": In(self.altitude_bits).array(self.lanes),
            "counts": In(self.lanes),
            "lowest": Out(lowest_layout(self.lanes, self.altitude_bits)),
        }

    def elaborate(self, platform):
        m = Module()

        # Above an altitude, the highest bit flags a missing corner. Lanes grow by a bit a level.
        left = []
        for lane, (corner, counts) in enumerate(zip(self.corners, self.counts, strict=True)):
            key = delay_line(m, Cat(corner, ~counts), 1, f"key_0_{lane}")
            blocked = delay_line(m, counts & corner.all(), 1, f"blocked_0_{lane}")
            left.append((key, None, blocked))
        level = 0
        while len(left) > 1:
            level += 1
            halved = []
            for pair, (a, b) in enumerate(zip(left[::2], left[1::2], strict=True)):
                name = f"{level}_{pair}"
                second = b[0] < a[0]
                lane = second if a[1] is None else Cat(Mux(second, b[1], a[1]), second)
                halved.append(
                    (
                        delay_line(m, Mux(second, b[0], a[0]), 1, f"key_{name}"),
                        delay_line(m, lane, 1, f"lane_{name}"),
                        delay_line(m, a[2] | b[2], 1, f"blocked_{name}"),
                    )
                )
            left = halved
        ((key, lane, blocked),) = left
        if lane is not None:
            m.d.comb += self.lowest.lane.eq(lane)
        m.d.comb += [
            self.lowest.altitude.eq(key[:-1]),
            self.lowest.none.eq(key[-1]),
            self.lowest.blocked.eq(blocked),
        ]

        return m
