"""Reciprocals of lengths, for slopes without a divider, and their required precision."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.unit import InstanceOf, Unit, Width


__all__ = ["Precision", "Reciprocals"]


@dataclass(frozen=True)
class Precision:
    """Fraction bits of slopes and positions, with a proof that they suffice.

    Let b be the bits of a coordinate and a the bits of an altitude; the map has at least L cells
    for L lanes. A segment of length n < 2^b has cells k = 0..n. With k = j + L g, j < L, cell k
    takes

        v(k) = v0 + floor(j d r) + g floor(L d r),   r = floor((2^F - 1) / n) / 2^F

    where d is the signed difference of a coordinate or altitude, and floor rounds down to a
    multiple of a unit u. So

    - r is below 1/n by more than 0 and at most 2^-F; k d r errs by less than E = 2^(c - F), where
      k |d| < 2^c: c = 2b for a coordinate, since |d| <= n, and c = a + b for an altitude.
    - Each floor removes less than u, and there are 1 + g <= 2^b / L of them: less than T in total.

    Coordinates. ``floor((2 k d + n) / (2 n))`` is ``floor(w)`` for every w from the exact
    ``k d / n + 1/2``, which is a multiple of 1/(2n), to less than 1/(2n) more. With e added to it,
    v(k) is off by more than e - E - T and less than e + E. With E = 2^-(b+3), T = 2^-(b+2) and
    e = E + T that is above 0 and below 2^-(b+1) < 1/(2n). So F = 3b + 3, and u = L 2^-(2b+2).

    Altitudes. ``ceil(z + k d / n)`` is ``floor(w)`` for every w less than z + 1 + k d / n by more
    than 0 and at most 1/n. With 1 - e added, v(k) is off by more than -E - T - e and less than
    E - e. With E = e = 2^-(b+2) and T = 2^-(b+1) that is below 0 and above -2^-b > -1/n. So
    F = a + 2b + 2, and u = L 2^-(2b+1).

    Altitudes with half steps. ``floor(z + k d / n - |d| / 2n)``, d the gain of the altitude, takes
    half of ``(2 j -+ 1) d r`` for j d r: 2k - 1 of a rising segment is at least -1, 2k + 1 of a
    falling one below 2^(b+1), so that c = a + b and E still hold, now to either side. The exact
    value is a multiple of 1/(2n), as for coordinates, and the same E, T and e suffice. So F = a +
    2b + 3, and u and e as for coordinates. Values below the lower end wrap around; they are never
    used.

    A map smaller than 2L is treated as if it had half as many lanes as cells along an edge. Tests
    cover every n, d and k of maps of up to 512 cells, with 12 bits of altitude.

    Attributes
    ----------
    reciprocal : int
        F, the greater of the two values: fraction bits of a reciprocal, which is below 1.
    minor, rise : int
        Fraction bits of the minor coordinate and of the altitude: -log2(u).
    minor_bias, rise_bias : int
        Biases added to them at the start, in units of u: 1/2 + e, and 1 - e, or e with half steps.
    """

    reciprocal: int
    minor: int
    rise: int
    minor_bias: int
    rise_bias: int

    @classmethod
    def of(
        cls, lanes: int, coordinate_bits: int, altitude_bits: int, half_steps: bool = False
    ) -> "Precision":
        """Return the precision for L, b and a, in this order, and for altitudes with half steps."""
        b, a = coordinate_bits, altitude_bits
        spare = b - 1 - min(exact_log2(lanes), b - 1)
        minor = b + 3 + spare
        rise = minor if half_steps else minor - 1
        return cls(
            reciprocal=max(3 * b + 3, a + 2 * b + (3 if half_steps else 2)),
            minor=minor,
            rise=rise,
            minor_bias=(1 << minor - 1) + (3 << spare),
            rise_bias=3 << spare if half_steps else (1 << rise) - (1 << spare),
        )

    def of_length(self, length: int) -> int:
        """Return the reciprocal of ``length`` in units of 2^-``reciprocal``; for 0 it is 0."""
        return ((1 << self.reciprocal) - 1) // length if length else 0


class Reciprocals(Unit):
    """Table of reciprocals: one of two lengths, 2 cycles after they are given.

    The addresses are signed differences, directly from a subtraction, so that no other logic delays
    them; the rows contain the reciprocals of their absolute values.

    On a target it is one memory of dual-port block RAMs.

    Members
    -------
    differences : In(signed(coordinate_bits + 1)).array(2)
    load : In(1)
        Take ``differences``.
    second : In(1)
        With ``move``: select the second of the latest differences, not the first.
    move : In(1)
        Put the reciprocal of the selected difference into ``reciprocal``.
    reciprocal : Out(Precision.reciprocal)
        In units of 2^-``Precision.reciprocal``.
    """

    coordinate_bits: Width(1, text="Lengths are below two to its power.")
    precision: InstanceOf(Precision)

    def interface(self):
        return {
            "differences": In(signed(self.coordinate_bits + 1)).array(2),
            "load": In(1),
            "second": In(1),
            "move": In(1),
            "reciprocal": Out(self.precision.reciprocal),
        }

    def elaborate(self, platform):
        m = Module()

        edge = 1 << self.coordinate_bits
        lengths = [*range(edge), *range(edge, 0, -1)]  # Rows from `edge`: differences from -edge.
        m.submodules.table = table = memory.Memory(
            shape=self.precision.reciprocal,
            depth=len(lengths),
            init=[self.precision.of_length(length) for length in lengths],
        )
        found = []
        for difference in self.differences:
            port = table.read_port()
            m.d.comb += [port.addr.eq(difference), port.en.eq(self.load)]
            found.append(port.data)
        wanted = Signal.like(self.reciprocal, reset_less=True)
        with m.If(self.move):
            m.d.sync += wanted.eq(Mux(self.second, *reversed(found)))
        m.d.comb += self.reciprocal.eq(wanted)

        return m
