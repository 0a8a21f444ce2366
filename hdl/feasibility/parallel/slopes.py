"""First cells of the lanes on a segment, and their gain in a cycle."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.config import Config
from hdl.feasibility.parallel.reciprocal import Precision
from hdl.feasibility.parallel.segment_setup import segment_layout
from hdl.primitives.delay_line import delay_line
from hdl.primitives.multiplier import Multiplier


__all__ = ["Slopes", "motion_layout"]

# Bits of a reciprocal that one multiplier takes, besides its sign: 18 x 18 bits signed on a target.
_PART = 17


def motion_layout(config: Config) -> data.StructLayout:
    """Return the layout of two numbers in the units of a segment's slope.

    See :class:`hdl.feasibility.parallel.reciprocal.Precision`.

    ``minor`` and ``rise``: coordinate and altitude, modulo the edge of the map and the number of
    altitudes.
    """
    precision = Precision.of(config)
    return data.StructLayout(
        {
            "minor": config.coordinate_bits + precision.minor,
            "rise": config.altitude_bits + precision.rise,
        }
    )


class Slopes(wiring.Component):
    """Multiplies differences by the reciprocal of the length, a segment a cycle.

    A lane's first cell comes from a product of its own, of a multiple of the difference, and so
    needs no sum of slopes. ``origins`` and ``step`` follow ``segment`` by 1 cycle, for one cycle:
    products of registers go to registers, and the sums of their parts to the lanes in the same
    cycle. On a target the registers are those of the multipliers.

    Parameters
    ----------
    config : Config

    Members
    -------
    segment : In(segment_layout)
    origins : Out(motion_layout).array(lanes)
        First cell of each lane, even if it lies past the end of the segment.
    step : Out(motion_layout)
        Gain of every lane in a cycle.
    """

    def __init__(self, config: Config):
        self.config = config
        self.precision = Precision.of(config)
        super().__init__(
            {
                "segment": In(segment_layout(config)),
                "origins": Out(motion_layout(config)).array(config.lanes),
                "step": Out(motion_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, precision, segment = self.config, self.precision, self.segment
        lane_bits = exact_log2(config.lanes)

        minor = delay_line(m, segment.minor, 1, "minor")
        altitude = delay_line(m, segment.altitude, 1, "altitude")
        biases = {
            "minor": Cat(Const(precision.minor_bias, precision.minor), minor),
            "rise": Cat(Const(precision.rise_bias, precision.rise), altitude),
        }
        fractions = {"minor": precision.minor, "rise": precision.rise}
        for axis, difference, multiples in (
            ("minor", segment.across, segment.across_to),
            ("rise", segment.rise, segment.rise_to),
        ):
            shift = precision.reciprocal - fractions[axis]
            product = self._product(m, difference, shift - lane_bits, 0, f"{axis}_step")
            m.d.comb += self.step[axis].eq(product)
            for lane, start in enumerate(self.origins):
                name = f"{axis}_{lane}"
                product = self._product(m, multiples[lane], shift, biases[axis], name)
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
