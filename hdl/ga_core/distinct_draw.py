"""Draws of distinct numbers, one per cycle, without rejection."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.unit import Choice, Count, Flag, Unit, Width


__all__ = ["DistinctDraw"]


class DistinctDraw(Unit):
    """Draws ``count`` distinct numbers of ``total``; all ordered choices are equally likely.

    Draw ``k`` picks the remaining number with index ``d``, uniform below ``total - k``, in
    increasing order: the number is ``d`` plus the count of earlier numbers at or below it. With the
    earlier numbers ``c_j`` in order, that is the count of ``e_j = c_j - j`` that are at most ``d``.
    So a register file holds the ``e_j``, compares all of them with ``d`` at once, and shifts to
    insert it. Each draw yields a number; none is rejected. Equals
    :class:`pathgene.sim.model.selection.DistinctDraw`.

    One draw is accepted per cycle; its number is the last in ``numbers`` :attr:`LATENCY` cycles
    later. A reset does not reach this unit; its user clears it after a reset.

    Members
    -------
    clear : In(1)
        Put all numbers back, including draws in flight. Overrides ``take``. ``numbers`` stays.
    take : In(1)
        Accept ``bits``, at most ``count`` times between two clears or before the first one.
    bits : In(data.ArrayLayout(draw_bits, best_of))
        Uniform raw draws.
    numbers : Out(data.ArrayLayout(range(first + total), count))
        The latest ``count`` numbers, oldest first. Registers.
    """

    total: Count(2, text="Numbers to draw from.")
    count: Count(1, "total", "Draws between two clears.")
    draw_bits: Width(2, text="``d`` is ``bits * (total - k) >> draw_bits``.")
    first: Count(0, text="The highest number is ``first + total - 1``.", name="First number") = 0
    best_of: Choice(1, 2, text="The smaller ``d`` counts.", name="Draws for one number") = 1
    multiplies: Flag(
        "The platform's multiplier cells make the products, if it has some; otherwise logic does."
    ) = False

    #: Cycles from a draw to its number.
    LATENCY = 5

    def interface(self):
        return {
            "clear": In(1),
            "take": In(1),
            "bits": In(data.ArrayLayout(self.draw_bits, self.best_of)),
            "numbers": Out(data.ArrayLayout(range(self.first + self.total), self.count)),
        }

    def elaborate(self, platform):
        m = Module()

        # Stages of the pipeline that hold a draw.
        valid = Signal(self.LATENCY - 1, reset_less=True)
        m.d.sync += valid.eq(Mux(self.clear, 0, Cat(self.take, valid)))

        # Stages 1 and 2: two products of half the width, then their sum.
        left = Signal(range(self.total + 1), init=self.total, reset_less=True)
        with m.If(self.clear):
            m.d.sync += left.eq(left.init)
        with m.Elif(self.take):
            m.d.sync += left.eq(left - 1)

        low_bits = self.draw_bits // 2
        high_bits = self.draw_bits - low_bits
        draws = []
        for i in range(self.best_of):
            low = self._product(m, self.bits[i][:low_bits], left, low_bits, f"low_{i}")
            high = self._product(m, self.bits[i][low_bits:], left, 0, f"high_{i}")
            draw = Signal(range(self.total), name=f"draw_{i}", reset_less=True)
            m.d.sync += draw.eq((high + low) >> high_bits)
            draws.append(draw)

        # Stage 3.
        best = Signal(range(self.total), reset_less=True)
        if self.best_of == 1:
            m.d.sync += best.eq(draws[0])
        else:
            m.d.sync += best.eq(Mux(draws[0] < draws[1], *draws))

        # Stage 4. An empty entry is above every draw, and stays above as it shifts and decreases:
        # before draw k it is at least total - k, and a draw is below that.
        lowered = Array(
            Signal(range(self.total + 1), init=self.total, name=f"lowered_{j}", reset_less=True)
            for j in range(self.count - 1)
        )
        below = Signal(self.count - 1)
        m.d.comb += below.eq(Cat(entry <= best for entry in lowered))
        for j, entry in enumerate(lowered):
            with m.If(self.clear):
                m.d.sync += entry.eq(entry.init)
            with m.Elif(valid[2] & ~below[j]):
                if j == 0:
                    m.d.sync += entry.eq(best)
                else:
                    m.d.sync += entry.eq(Mux(below[j - 1], best, lowered[j - 1] - 1))

        picked = Signal(range(self.first + self.total), reset_less=True)
        below_picked = Signal(self.count - 1, reset_less=True)
        m.d.sync += [
            picked.eq(best + self.first),
            below_picked.eq(below),
        ]

        # Stage 5.
        number = Signal(range(self.first + self.total))
        m.d.comb += number.eq(picked + sum(below_picked))
        numbers = Signal.like(self.numbers, reset_less=True)
        m.d.comb += self.numbers.eq(numbers)
        with m.If(valid[3] & ~self.clear):
            m.d.sync += numbers.eq(Cat(numbers.as_value()[len(number) :], number))

        return m

    def _product(self, m, bits, left, shift, name):
        """Return ``bits * left >> shift``, one cycle later."""
        if self.multiplies:
            m.submodules[name] = multiplier = Multiplier(
                (len(bits), len(left)), shift, (False, False)
            )
            m.d.comb += [multiplier.first.eq(bits), multiplier.second.eq(left)]
            return multiplier.product
        product = Signal(len(bits) + len(left) - shift, name=name, reset_less=True)
        m.d.sync += product.eq(bits * left >> shift)
        return product
