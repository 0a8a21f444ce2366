"""Arithmetic in pipelines: sums, products, quotients and square roots of integers."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, Given, Unit, Width


__all__ = ["AddSubtract", "Divider", "Multiplier", "SquareRoot", "WideMultiplier"]


class AddSubtract(Unit):
    """Sum or difference of two numbers modulo ``2**width``, without a register.

    On a platform with a cell for it (:meth:`pathgene.hdl.primitives.cells.Cells.add_subtract`), one
    carry chain does both; synthesis alone makes two chains and a multiplexer.

    Members
    -------
    first, second : In(width)
    subtracts : In(1)
    total : Out(width)
        ``first - second`` with ``subtracts``, otherwise ``first + second``.
    """

    width: Width(1)

    def interface(self):
        return {
            "first": In(self.width),
            "second": In(self.width),
            "subtracts": In(1),
            "total": Out(self.width),
        }

    def elaborate(self, platform):
        m = Module()

        first, second, subtracts = self.first, self.second, self.subtracts
        cell = cells_of(platform).add_subtract(self.width)
        if cell is None:
            m.d.comb += self.total.eq(Mux(subtracts, first - second, first + second))
            return m

        m.submodules.hard = cell
        m.d.comb += [
            cell.first.eq(first),
            cell.second.eq(second),
            cell.subtracts.eq(subtracts),
            self.total.eq(cell.total),
        ]
        return m


class Multiplier(Unit):
    """Multiplies two numbers; ``product`` follows one cycle later.

    If the platform has a multiplier cell for such factors
    (:meth:`pathgene.hdl.primitives.cells.Cells.multiplier`), the register is inside the cell,
    without routing between product and register.

    Members
    -------
    first, second : In(Shape)
    product : Out(Shape)
        ``first * second >> shift`` of the previous cycle; signed if a factor is signed.
    """

    widths: Given("(int, int)", "Widths of the factors.")
    shift: Count(0, text="Low bits of the product that are left out.") = 0
    signs: Given("(bool, bool)", "The factors that have a sign.") = (True, True)

    def interface(self):
        return {
            "first": In(Shape(self.widths[0], self.signs[0])),
            "second": In(Shape(self.widths[1], self.signs[1])),
            "product": Out(Shape(max(1, sum(self.widths) - self.shift), any(self.signs))),
        }

    def elaborate(self, platform):
        m = Module()

        cell = cells_of(platform).multiplier(self.widths, self.signs)
        if cell is not None:
            m.submodules.hard = cell
            m.d.comb += [
                cell.first.eq(self.first),
                cell.second.eq(self.second),
                self.product.eq(cell.product >> self.shift),
            ]
            return m

        product = Signal.like(self.product, name="product_held", reset_less=True)
        m.d.sync += product.eq(self.first * self.second >> self.shift)
        m.d.comb += self.product.eq(product)

        return m


#: Bits of a factor that a multiplier cell takes, with or without a sign.
CELL_BITS = 18


class WideMultiplier(Unit):
    """Product of two numbers of any width in every cycle.

    The factors are split into parts of 18 bits; the products of the parts are added in pairs, with
    a register after each addition.

    Attributes
    ----------
    latency : int
        Cycles from the factors to their product: 1 if each factor is one part, plus 1 for every
        doubling of the number of products.
    multipliers : int
        Number of products of parts, each of which takes a multiplier.

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

        # Terms with their weights. Only the product of the lowest parts has bits that `shift`
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
            # Terms with neighbouring weights overlap in the fewest bits.
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


class Divider(Unit):
    """Quotient of two unsigned numbers in every cycle, rounded down.

    A stage adds or subtracts the divisor once and yields one bit (non-restoring division).
    ``quotient`` follows ``latency``, that is ``quotient_bits``, cycles after its dividend. It is
    undefined if it has more bits or the divisor is 0.

    Members
    -------
    dividend : In(divisor_bits + quotient_bits)
        Less than ``divisor << quotient_bits``.
    divisor : In(divisor_bits)
    quotient : Out(quotient_bits)
    """

    divisor_bits: Width(1)
    quotient_bits: Width(1)

    def interface(self):
        self.latency = self.quotient_bits
        return {
            "dividend": In(self.divisor_bits + self.quotient_bits),
            "divisor": In(self.divisor_bits),
            "quotient": Out(self.quotient_bits),
        }

    def elaborate(self, platform):
        m = Module()

        width, bits = self.divisor_bits, self.quotient_bits
        divisor = self.divisor
        # `rest` holds the remaining bits of the dividend above the bits of the quotient. A
        # remainder may be negative; the next stage then adds, and need not restore it. It is at
        # least -divisor and less than divisor, so it fits into one more bit.
        rest, remainder = self.dividend[:bits], Cat(self.dividend[bits:], C(0))
        for stage in range(1, bits + 1):
            m.submodules[f"stage_{stage}"] = chain = AddSubtract(width + 1)
            m.d.comb += [
                chain.first.eq(Cat(rest[-1], remainder)),
                chain.second.eq(divisor),
                chain.subtracts.eq(~remainder[-1]),
            ]
            next_rest = Signal(bits, name=f"rest_{stage}", reset_less=True)
            m.d.sync += next_rest.eq(Cat(~chain.total[-1], rest))
            rest = next_rest
            if stage < bits:
                next_remainder = Signal(width + 1, name=f"remainder_{stage}", reset_less=True)
                next_divisor = Signal(width, name=f"divisor_{stage}", reset_less=True)
                m.d.sync += [next_remainder.eq(chain.total), next_divisor.eq(divisor)]
                remainder, divisor = next_remainder, next_divisor
        m.d.comb += self.quotient.eq(rest)

        return m


class SquareRoot(Unit):
    """Square root of a number in every cycle, rounded down.

    It works digit by digit: each stage takes two bits of the radicand and yields one bit of the
    root. ``root`` follows ``latency``, that is ``width``, cycles after its radicand.

    Members
    -------
    radicand : In(2 * width)
    root : Out(width)
    """

    width: Width(1, name="Root width")

    def interface(self):
        self.latency = self.width
        return {"radicand": In(2 * self.width), "root": Out(self.width)}

    def elaborate(self, platform):
        m = Module()

        # `root` and `remainder` belong to the bits taken; the remainder is at most twice the root.
        # If it is negative, the last bit of the root is 0; the next digit adds the excess back
        # instead of restoring it. Before the first digit, the root has no bits.
        root, remainder, rest = Const(0, 0), Const(0, 1), self.radicand
        for digit in range(1, self.width + 1):
            following = 2 * (self.width - digit)
            negative = remainder[-1]
            m.submodules[f"digit_{digit}"] = chain = AddSubtract(digit + 2)
            m.d.comb += [
                chain.first.eq(Cat(rest[following:], remainder)),
                # Subtract 4 root + 1; after a negative remainder, add 4 root + 3.
                chain.second.eq(Cat(C(1, 1), negative, root)),
                chain.subtracts.eq(~negative),
            ]
            next_root = Signal(digit, name=f"root_{digit}", reset_less=True)
            m.d.sync += next_root.eq(Cat(~chain.total[-1], root))
            root = next_root
            if following:
                next_remainder = Signal(digit + 2, name=f"remainder_{digit}", reset_less=True)
                next_rest = Signal(following, name=f"rest_{digit}", reset_less=True)
                m.d.sync += [next_remainder.eq(chain.total), next_rest.eq(rest)]
                remainder, rest = next_remainder, next_rest
        m.d.comb += self.root.eq(root)

        return m
