"""The definition of the cells of a segment, as assertions without a division."""

from amaranth import *


__all__ = ["Segment"]


class Segment:
    """A segment between two points, with its cells.

    Cell k of 0..n, n the longer side, is ``start + floor((2 k d + n) / (2 n))`` along an axis on
    which it gains d; a quotient's floor q is checked as ``2 n q <= 2 k d + n < 2 n (q + 1)``.

    Parameters
    ----------
    m : Module
    start, stop : StructLayout with x, y and altitude
    """

    def __init__(self, m, start, stop):
        self.start, self.stop = start, stop
        xy = len(start.x)
        self.gain = {a: Signal(signed(xy + 1), name=f"gain_{a}") for a in "xy"}
        self.side = {a: Signal(xy, name=f"side_{a}") for a in "xy"}
        self.rise = Signal(signed(len(start.altitude) + 1))
        self.steep = Signal()
        self.length = Signal(xy)
        for a in "xy":
            gain = self.gain[a]
            m.d.comb += [
                gain.eq(stop[a] - start[a]),
                self.side[a].eq(Mux(gain < 0, -gain, gain)),
            ]
        m.d.comb += [
            self.rise.eq(stop.altitude - start.altitude),
            self.steep.eq(self.side["y"] > self.side["x"]),
            self.length.eq(Mux(self.steep, self.side["y"], self.side["x"])),
        ]

    def is_at(self, axis, k, coordinate):
        """Return whether cell ``k`` has this coordinate."""
        n = self.length
        steps = coordinate - self.start[axis]
        doubled = 2 * k * self.gain[axis] + n
        # A segment of one cell has n = 0, and its only cell is where it starts.
        inside = (2 * n * steps <= doubled) & (doubled < 2 * n * (steps + 1))
        return Mux(n == 0, steps == 0, inside)

    def lowest(self):
        """Return the lower of the altitudes of both ends."""
        return Mux(self.rise < 0, self.stop.altitude, self.start.altitude)

    def is_ceiling(self, k, altitude):
        """Return whether exactly the ground at or above ``altitude`` collides with cell ``k``."""
        n = self.length
        scaled = self.start.altitude * n + k * self.rise
        inside = (scaled <= altitude * n) & (scaled > altitude * n - n)
        return Mux(n == 0, altitude == self.lowest(), inside)
