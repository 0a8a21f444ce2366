"""First cells of the lanes on a segment, and their gain in a cycle."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from pathgene.hdl.feasibility.parallel.segment_setup import segment_layout
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.multiplier import Multiplier
from pathgene.hdl.primitives.unit import Flag, PowerOfTwo, Unit, Width


__all__ = ["Slopes", "motion_layout"]

# Bits of a reciprocal that one multiplier takes, besides its sign: 18 x 18 bits signed on a target.
_PART = 17


def motion_layout(
    lanes: int, coordinate_bits: int, altitude_bits: int, half_steps: bool = False
) -> data.StructLayout:
    """Return the layout of two numbers in the units of a segment's slope.

    See :class:`pathgene.hdl.feasibility.parallel.reciprocal.Precision`.

    ``minor`` and ``rise``: coordinate and altitude, modulo the edge of the map and the number of
    altitudes.
    """
    precision = Precision.of(lanes, coordinate_bits, altitude_bits, half_steps)
    return data.StructLayout(
        {
            "minor": coordinate_bits + precision.minor,
            "rise": altitude_bits + precision.rise,
        }
    )


class Slopes(Unit):
    """Multiplies differences by the reciprocal of the length, one segment per cycle.

    A lane's first cell comes from a separate product, of a multiple of the difference, and so does
    not need a sum of slopes. ``origins`` and ``step`` follow ``segment`` by 1 cycle, for one cycle:
    products of registers go to registers, and the sums of their parts to the lanes in the same
    cycle. On a target, the multipliers contain these registers.

    Members
    -------
    segment : In(segment_layout)
    origins : Out(motion_layout).array(lanes)
        First cell of each lane, even if it lies past the end of the segment.
    step : Out(motion_layout)
        Gain of every lane in a cycle.
    """

    lanes: PowerOfTwo(1, "1 << coordinate_bits", "Cells walked in a cycle.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    half_steps: Flag(
        "Altitudes are the lowest within half a step of each cell, see "
        ":class:`pathgene.hdl.feasibility.parallel.reciprocal.Precision`."
    ) = False

    def interface(self):
        sizes = (self.lanes, self.coordinate_bits, self.altitude_bits, self.half_steps)
        self.precision = Precision.of(*sizes)
        motion = motion_layout(*sizes)
        return {
            "segment": In(segment_layout(*sizes)),
            "origins": Out(motion).array(self.lanes),
            "step": Out(motion),
        }

    def elaborate(self, platform):
        m = Module()
        precision, segment = self.precision, self.segment
        lane_bits = exact_log2(self.lanes)

        minor = delay_line(m, segment.minor, 1, "minor")
        altitude = delay_line(m, segment.altitude, 1, "altitude")
        biases = {
            "minor": Cat(Const(precision.minor_bias, precision.minor), minor),
            "rise": Cat(Const(precision.rise_bias, precision.rise), altitude),
        }
        fractions = {"minor": precision.minor, "rise": precision.rise}
        # Multiples of the rise are doubled if they have half steps.
        for axis, difference, multiples, doubled in (
            ("minor", segment.across, segment.across_to, 0),
            ("rise", segment.rise, segment.rise_to, int(self.half_steps)),
        ):
            shift = precision.reciprocal - fractions[axis]
            product = self._product(m, difference, shift - lane_bits, 0, f"{axis}_step")
            m.d.comb += self.step[axis].eq(product)
            for lane, start in enumerate(self.origins):
                name = f"{axis}_{lane}"
                product = self._product(m, multiples[lane], shift + doubled, biases[axis], name)
                m.d.comb += start[axis].eq(product)

        return m

    def _product(self, m, factor, shift, bias, name):
        """Return ``bias + floor(factor * reciprocal / 2**shift)``, a cycle later."""
        reciprocal = self.segment.reciprocal
        if len(reciprocal) <= _PART:
            return _registered(m, factor, _signed(reciprocal), shift, name) + bias

        cut = min(shift, _PART)
        low = _registered(m, factor, _signed(reciprocal[:_PART]), cut, f"{name}_low")
        high = _registered(m, factor, _signed(reciprocal[_PART:]), 0, f"{name}_high")
        return (low + (high << _PART - cut) >> shift - cut) + bias


def _registered(m, first, second, shift, name):
    """Return ``first * second >> shift``, a cycle later."""
    m.submodules[name] = multiplier = Multiplier((len(first), len(second)), shift)
    m.d.comb += [multiplier.first.eq(first), multiplier.second.eq(second)]
    return multiplier.product


def _signed(value):
    """Return an unsigned value as a signed one, as a multiplier of signed numbers takes it."""
    return Cat(value, Const(0, 1)).as_signed()
