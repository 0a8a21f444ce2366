"""Slopes of segments, and where their columns of cells begin and end."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import Config
from hdl.feasibility.layouts import point_layout
from hdl.feasibility.reciprocal import Precision, Reciprocals
from hdl.feasibility.sequential_setup import SequentialSetup
from hdl.feasibility.sizes import SPAN_STAGES


__all__ = ["HierarchicalSetup", "group_cells", "span_layout"]

#: Bits of the parts into which the longer factor of a product is cut: an unsigned multiplier's.
_PART = 17


def group_cells(config: Config) -> int:
    """Return how many cells the detailed map is asked for in a clock: never of two columns."""
    return min(config.lanes, config.coarse_factor)


def span_layout(config: Config) -> data.StructLayout:
    """One segment with its slopes, all coordinates along its longer and its shorter side.

    ``steep``: y is the longer side; ``back``: the coordinate along it falls. ``major``, ``minor``,
    ``altitude`` of the first cell, ``minor_goal``, ``altitude_goal`` of the last; without steps
    both altitudes are the lower end. ``falls``: the altitude does. ``minor_slope`` and
    ``altitude_slope`` of one step, with ``Precision.reciprocal`` fraction bits.

    The others are sums of them with the same fraction bits, and the bias of
    :class:`hdl.feasibility.reciprocal.Precision`: the floor of a minor sum is the coordinate, that
    of an altitude sum the ceiling of the altitude. ``minor_near``, ``altitude_near``: at the cell,
    perhaps before the first one, where the first cell's group of :func:`group_cells` begins, modulo
    their width.
    ``minor_far``, ``altitude_far``: at the last cell of the first cell's column, perhaps past the
    last one.
    """
    fraction = Precision.of(config).reciprocal
    minor_sum = config.coordinate_bits + fraction
    altitude_sum = config.altitude_bits + fraction
    return data.StructLayout(
        {
            "steep": 1,
            "back": 1,
            "steps": config.coordinate_bits,
            "major": config.coordinate_bits,
            "minor": config.coordinate_bits,
            "minor_goal": config.coordinate_bits,
            "altitude": config.altitude_bits,
            "altitude_goal": config.altitude_bits,
            "falls": 1,
            "minor_slope": signed(fraction + 1),
            "altitude_slope": signed(altitude_sum + 1),
            "minor_near": minor_sum,
            "minor_far": minor_sum,
            "altitude_near": altitude_sum,
            "altitude_far": altitude_sum,
            "number": config.segment_bits,
            "last": 1,
        }
    )


class HierarchicalSetup(wiring.Component):
    """Makes segments of points, with all that their walk needs: a pipeline without a divider.

    The reciprocal comes out of a table; every other stage is one adder or one multiplier. Slopes
    are not rounded after that, so the proof of :class:`hdl.feasibility.reciprocal.Precision` holds
    with nothing for its T. A segment is offered :attr:`LATENCY` clocks after its second point is
    taken, and one every clock; stalled, the stages fill up.

    Parameters
    ----------
    config : Config

    Members
    -------
    points : In(stream.Signature(point_layout))
        Paths of two points or more, one after the other.
    spans : Out(stream.Signature(span_layout))
        One segment fewer than points, path by path.
    """

    #: Clocks from the transfer of a point to the offer of the segment that it ends: stages.
    LATENCY = SPAN_STAGES

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "points": In(stream.Signature(point_layout(config))),
                "spans": Out(stream.Signature(span_layout(config))),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        precision = Precision.of(config)
        fraction = precision.reciprocal
        xy, z = config.coordinate_bits, config.altitude_bits
        column_bits = xy - config.coarse_bits
        group_bits = (group_cells(config) - 1).bit_length()

        m.submodules.sides = sides = SequentialSetup(config, tiers=False)
        connect(m, flipped(self.points), sides.points)

        # A stage moves on when there is room anywhere behind it.
        count = self.LATENCY - SequentialSetup.LATENCY
        valids = [sides.segments.valid, *(Signal(name=f"valid_{n}") for n in range(count))]
        moves = [Signal(name=f"move_{n}") for n in range(count)]
        for number, move in enumerate(moves):
            m.d.comb += move.eq(~Cat(valids[number + 1 :]).all() | self.spans.ready)
            with m.If(move):
                m.d.sync += valids[number + 1].eq(valids[number])
        m.d.comb += [sides.segments.ready.eq(moves[0]), self.spans.valid.eq(valids[-1])]
        remaining = iter(enumerate(moves))

        def stage(kept, **fields):
            """Register ``fields``, given as values, beside the ``kept`` ones."""
            number, move = next(remaining)
            registers = {}
            for field, value in {**kept, **fields}.items():
                value = Value.cast(value)
                registers[field] = Signal(value.shape(), name=f"{field}_{number}", reset_less=True)
                with m.If(move):
                    m.d.sync += registers[field].eq(value)
            return registers

        def parts(name, value, factor, bits):
            """Return the products of the parts of a value, as far as ``bits`` of their sum need."""
            value = Value.cast(value)
            extended = Signal(Shape(bits, value.shape().signed), name=f"{name}_factor")
            m.d.comb += extended.eq(value)
            return {
                f"{name}_{at}": (extended[at : at + _PART] * factor)[: bits - at]
                for at in range(0, bits, _PART)
            }

        def summed(name, values, bits):
            """Take the products of :func:`parts` out of ``values`` and return their sum."""
            return sum(values.pop(f"{name}_{at}") << at for at in range(0, bits, _PART))[:bits]

        m.submodules.reciprocals = reciprocals = Reciprocals(config)
        segment = sides.segments.p
        level = segment.steps == 0
        sinks = segment.climb < 0
        m.d.comb += [
            reciprocals.differences[0].eq(segment.steps),
            reciprocals.load.eq(moves[0]),
            reciprocals.move.eq(moves[1]),
        ]
        now = stage(
            {},
            steep=segment.steep,
            back=Mux(segment.steep, segment.south, segment.west),
            lowers=Mux(segment.steep, segment.west, segment.south),
            steps=segment.steps,
            width=segment.minor,
            major=Mux(segment.steep, segment.y, segment.x),
            minor=Mux(segment.steep, segment.x, segment.y),
            altitude=segment.altitude,
            falls=sinks & ~level,
            height=Mux(level, 0, Mux(sinks, -segment.climb, segment.climb)[:z]),
            number=segment.number,
            last=segment.last,
        )
        lower, higher = now["minor"] - now["width"], now["minor"] + now["width"]
        below, above = now["altitude"] - now["height"], now["altitude"] + now["height"]
        now = stage(
            now,
            minor_goal=Mux(now["lowers"], lower, higher)[:xy],
            altitude_goal=Mux(now["falls"], below, above)[:z],
        )
        width, height = now.pop("width"), now.pop("height")
        now = stage(
            now,
            **parts("across", reciprocals.reciprocal, width, fraction),
            **parts("climb", reciprocals.reciprocal, height, fraction + z),
        )
        now = stage(
            now,
            across=summed("across", now, fraction),
            climb=summed("climb", now, fraction + z),
        )
        lowers, across, climb = now.pop("lowers"), now.pop("across"), now.pop("climb")
        now = stage(
            now,
            minor_slope=Mux(lowers, -across, across),
            altitude_slope=Mux(now["falls"], -climb, climb),
            # Steps to the last cell of the column, and from the first of the group.
            ahead=Mux(now["back"], now["major"], ~now["major"])[:column_bits],
            behind=Mux(now["back"], ~now["major"], now["major"])[:group_bits],
        )
        ahead, behind = now.pop("ahead"), now.pop("behind")
        now = stage(
            now,
            **parts("minor_far", now["minor_slope"], ahead, xy + fraction),
            **parts("altitude_far", now["altitude_slope"], ahead, z + fraction),
            **parts("minor_near", now["minor_slope"], behind, xy + fraction),
            **parts("altitude_near", now["altitude_slope"], behind, z + fraction),
        )
        now = stage(
            now,
            minor_far=summed("minor_far", now, xy + fraction),
            altitude_far=summed("altitude_far", now, z + fraction),
            minor_near=summed("minor_near", now, xy + fraction),
            altitude_near=summed("altitude_near", now, z + fraction),
        )
        minor_bias = precision.minor_bias << fraction - precision.minor
        altitude_bias = precision.rise_bias << fraction - precision.rise
        minor = Cat(C(minor_bias, fraction), now["minor"])
        altitude = Cat(C(altitude_bias, fraction), now["altitude"])
        now = stage(
            {field: value for field, value in now.items() if not field.endswith(("_far", "_near"))},
            minor_far=(minor + now["minor_far"])[: xy + fraction],
            altitude_far=(altitude + now["altitude_far"])[: z + fraction],
            minor_near=(minor - now["minor_near"])[: xy + fraction],
            altitude_near=(altitude - now["altitude_near"])[: z + fraction],
        )
        for field, value in now.items():
            m.d.comb += self.spans.p[field].eq(value)

        return m
