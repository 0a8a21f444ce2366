"""Multiplier of factors that are wider than a multiplier cell."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.multiplier import Multiplier
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["WideMultiplier"]

#: Bits of a factor that a multiplier cell takes, with or without a sign.
CELL_BITS = 18


class WideMultiplier(Unit):
    """Product of two numbers of any width in every cycle.

    The factors are cut into parts of 18 bits; the products of the parts are added in pairs, a
    register after each addition.

    Attributes
    ----------
    latency : int
        Cycles from the factors to their product: 1 if each factor is one part, and 1 more for
        every doubling of the products.
    multipliers : int
        Products of parts, each of which takes a multiplier.

    Members
    -------
    first : In(first)
    second : In(second)
    product : Out(Shape)
        ``first * second >> shift``. Signed if a factor is signed.
    """

    first_shape: Given("ShapeLike", "Shape of a factor.")
    second_shape: Given("ShapeLike", "Shape of a factor.")
    shift: Count(0, CELL_BITS, "Low bits of the product that are left out.") = 0

    def interface(self):
        shapes = Shape.cast(self.first_shape), Shape.cast(self.second_shape)
        self.multipliers = -(-shapes[0].width // CELL_BITS) * -(-shapes[1].width // CELL_BITS)
        self.latency = 1 + (self.multipliers - 1).bit_length()
        width = shapes[0].width + shapes[1].width - self.shift
        return {
            "first": In(shapes[0]),
            "second": In(shapes[1]),
            "product": Out(Shape(width, shapes[0].signed or shapes[1].signed)),
        }

    def elaborate(self, platform):
        m = Module()

        # Numbers with their weights. Only the product of the lowest parts has bits that `shift`
        # discards.
        terms = []
        for i, (low, first) in enumerate(_parts(self.first)):
            for j, (high, second) in enumerate(_parts(self.second)):
                left_out = 0 if i or j else self.shift
                part = Multiplier(
                    (len(first), len(second)),
                    left_out,
                    (first.shape().signed, second.shape().signed),
                )
                m.submodules[f"part_{i}_{j}"] = part
                m.d.comb += [part.first.eq(first), part.second.eq(second)]
                terms.append((low + high + left_out, part.product))

        level = 0
        while len(terms) > 1:
            level += 1
            # Neighbours in weight share the fewest bits.
            terms.sort(key=lambda term: term[0])
            terms = [
                self._add(m, terms[n : n + 2], f"sum_{level}_{n // 2}")
                for n in range(0, len(terms), 2)
            ]
        m.d.comb += self.product.eq(terms[0][1])

        return m

    def _add(self, m, terms, name):
        """Return the sum of one or two terms in a register, with its weight."""
        offset, value = terms[0]
        if len(terms) == 2:
            apart = terms[1][0] - offset
            high = (value >> apart) + terms[1][1]
            joined = Cat(value[:apart], high)
            value = joined.as_signed() if high.shape().signed else joined
        # No sum is wider than the product's part at or above its weight.
        width = min(len(value), len(self.product) + self.shift - offset)
        total = Signal(Shape(width, value.shape().signed), name=name, reset_less=True)
        m.d.sync += total.eq(value)
        return offset, total


def _parts(factor):
    """Return the parts of a factor with their weights; only the last may have a sign."""
    parts = []
    for low in range(0, len(factor), CELL_BITS):
        part = factor[low : low + CELL_BITS]
        if low + CELL_BITS >= len(factor) and factor.shape().signed:
            part = part.as_signed()
        parts.append((low, part))
    return parts
