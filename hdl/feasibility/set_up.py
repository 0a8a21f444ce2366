"""From points to segments, and from these to the groups of cells that the lanes take in a clock."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.config import Config
from hdl.feasibility.layouts import point_layout
from hdl.feasibility.reciprocal import Precision, Reciprocals


__all__ = ["TAG_BITS", "SetUp", "segment_layout", "token_layout"]

#: Width of the number by which paths under way are told apart. More of them cannot be between the
#: points and the results: a verdict each, and three in the set-up.
TAG_BITS = 4


def segment_layout(config: Config) -> data.StructLayout:
    """Return the layout of a segment as the lanes see it.

    ``steep`` (the major axis is y), ``descending`` (along it), ``length`` (cells but one),
    ``major``, ``minor``, ``altitude`` (where it starts), ``across`` and ``rise`` (what minor
    coordinate and altitude gain along it), ``places`` (of each lane's first cell along the
    segment), ``reciprocal`` (of the length).
    """
    xy, z = config.coordinate_bits, config.altitude_bits
    return data.StructLayout(
        {
            "steep": 1,
            "descending": 1,
            "length": xy,
            "major": xy,
            "minor": xy,
            "altitude": z,
            "across": signed(xy + 1),
            "rise": signed(z + 1),
            "places": data.ArrayLayout(max(1, exact_log2(config.lanes)), config.lanes),
            "reciprocal": Precision.of(config).reciprocal,
        }
    )


def token_layout(config: Config) -> data.StructLayout:
    """Return the layout of what goes with a group of cells through all stages.

    ``valid``; ``starts`` and ``ends_segment``, ``first`` and ``ends_path`` (it is the first or last
    group of its segment, of its path), ``segment`` (its number), ``tag`` (of its path).
    """
    return data.StructLayout(
        {
            "valid": 1,
            "starts": 1,
            "ends_segment": 1,
            "first": 1,
            "ends_path": 1,
            "segment": config.segment_bits,
            "tag": TAG_BITS,
        }
    )


class SetUp(wiring.Component):
    """Makes segments of points, and has the lanes walk them one right after the other.

    A segment goes through two stages that wait for their turn: differences and their signs; major
    axis, and the reciprocal of the length. From the second it is launched: a group of its cells a
    clock, then the next segment. So nothing behind this unit ever waits, and as long as points come
    no clock is lost between segments or paths. A segment whose second point is taken in some clock
    is launched 2 clocks later, if it is its turn.

    In the clock of ``drop`` all that belongs to that path is given up; its points to come are taken
    and forgotten.

    Parameters
    ----------
    config : Config

    Members
    -------
    points : In(stream.Signature(point_layout))
    room, segment_room : In(1)
    begins, segment_begins : Out(1)
        See :func:`hdl.feasibility.walker.walker_signature`.
    drop : In(1)
    drop_tag : In(TAG_BITS)
        Path to be given up.
    token : Out(token_layout)
        The group that is launched.
    segment : Out(segment_layout)
        With ``token.starts``.
    """

    def __init__(self, config: Config):
        self.config = config
        super().__init__(
            {
                "points": In(stream.Signature(point_layout(config))),
                "room": In(1),
                "segment_room": In(1),
                "begins": Out(1),
                "segment_begins": Out(1),
                "drop": In(1),
                "drop_tag": In(TAG_BITS),
                "token": Out(token_layout(config)),
                "segment": Out(segment_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, segment, token = self.config, self.segment, self.token
        xy, z = config.coordinate_bits, config.altitude_bits
        lane_bits = exact_log2(config.lanes)

        identity = data.StructLayout(
            {
                "valid": 1,
                "tag": TAG_BITS,
                "first": 1,
                "ends_path": 1,
                "segment": config.segment_bits,
            }
        )
        move_on = Signal()
        launch = Signal()

        # The path whose points are coming.
        point, before = self.points.p, Signal(point_layout(config), reset_less=True)
        inside, unwanted = Signal(), Signal()
        tag, number = Signal(TAG_BITS), Signal(config.segment_bits)
        dropped, taken = Signal(), Signal()
        m.d.comb += [
            taken.eq(self.points.valid & self.points.ready),
            dropped.eq(unwanted | (inside & self.drop & (self.drop_tag == tag))),
        ]
        m.d.sync += unwanted.eq(dropped & ~(taken & point.last))
        with m.If(taken):
            m.d.sync += [before.eq(point), inside.eq(~point.last)]
            with m.If(inside):
                m.d.sync += number.eq(number + 1)
            with m.Else():
                m.d.sync += [number.eq(0), tag.eq(tag + 1)]

        # First stage.
        measured = Signal(identity)
        ends = Signal(data.ArrayLayout(point_layout(config), 2), reset_less=True)
        gains = [Signal(signed(xy + 1), name=f"gain_{n}", reset_less=True) for n in "xy"]
        sides = [Signal(xy, name=f"side_{n}", reset_less=True) for n in "xy"]
        rise = Signal(signed(z + 1), reset_less=True)
        m.d.comb += self.points.ready.eq(~measured.valid | move_on)
        m.submodules.reciprocals = reciprocals = Reciprocals(config)
        m.d.comb += reciprocals.load.eq(self.points.ready)
        with m.If(self.points.ready):
            m.d.sync += [
                measured.valid.eq(taken & inside & ~dropped),
                measured.tag.eq(tag),
                measured.first.eq(number == 0),
                measured.ends_path.eq(point.last),
                measured.segment.eq(number),
                ends[0].eq(before),
                ends[1].eq(point),
                rise.eq(point.altitude - before.altitude),
            ]
            for axis, gain, side, length in zip(
                "xy", gains, sides, reciprocals.lengths, strict=True
            ):
                forth, back = point[axis] - before[axis], before[axis] - point[axis]
                m.d.sync += [gain.eq(forth), side.eq(length)]
                m.d.comb += length.eq(Mux(forth[-1], back, forth))
        with m.Elif(self._is_dropped(measured)):
            m.d.sync += measured.valid.eq(0)

        # Second stage.
        waiting = Signal(identity)
        steep = Signal()
        descending = Signal()
        shape = Signal(
            data.StructLayout(
                {name: field.shape for name, field in segment.shape() if name != "reciprocal"}
            ),
            reset_less=True,
        )
        m.d.comb += [
            move_on.eq(~waiting.valid | launch),
            reciprocals.move.eq(move_on),
            steep.eq(sides[1] > sides[0]),
            descending.eq(Mux(steep, gains[1], gains[0]) < 0),
        ]
        with m.If(move_on):
            m.d.sync += [
                waiting.eq(measured),
                waiting.valid.eq(measured.valid & ~self._is_dropped(measured)),
                shape.steep.eq(steep),
                shape.descending.eq(descending),
                shape.length.eq(Mux(steep, sides[1], sides[0])),
                shape.major.eq(Mux(steep, ends[0].y, ends[0].x)),
                shape.minor.eq(Mux(steep, ends[0].x, ends[0].y)),
                shape.across.eq(Mux(steep, gains[0], gains[1])),
                shape.rise.eq(rise),
                # Within one cell, the lower end counts; a length of 0 makes it level.
                shape.altitude.eq(
                    Mux(
                        (rise < 0) & ~Cat(sides).any(),
                        ends[1].altitude,
                        ends[0].altitude,
                    )
                ),
            ]
            for lane, place in enumerate(shape.places):
                from_x, from_y = (
                    Mux(gain < 0, (start[:lane_bits] - lane), (lane - start[:lane_bits]))
                    for gain, start in zip(gains, (ends[0].x, ends[0].y), strict=True)
                )
                m.d.sync += place.eq(Mux(steep, from_y, from_x))
        with m.Elif(self._is_dropped(waiting)):
            m.d.sync += waiting.valid.eq(0)

        # Groups left of the segment that was launched last, and whether there are none.
        left, free = Signal(xy), Signal(init=1)
        launched = Signal(identity)
        dropping = Signal()
        m.d.comb += [
            launch.eq(waiting.valid & free & self.segment_room & (self.room | ~waiting.first)),
            self.begins.eq(launch & waiting.first),
            self.segment_begins.eq(launch),
            *(segment[name].eq(shape[name]) for name, _ in shape.shape()),
            segment.reciprocal.eq(Mux(shape.steep, *reversed(reciprocals.reciprocals))),
        ]
        groups = shape.length >> lane_bits
        with m.If(launch):
            m.d.sync += [left.eq(groups), free.eq(groups == 0), launched.eq(waiting)]
            m.d.comb += [
                token.starts.eq(1),
                token.first.eq(waiting.first),
                token.ends_segment.eq(groups == 0),
                token.ends_path.eq(waiting.ends_path & (groups == 0)),
                token.segment.eq(waiting.segment),
                token.tag.eq(waiting.tag),
            ]
        with m.Else():
            m.d.sync += [left.eq(left - ~free), free.eq(left <= 1)]
            m.d.comb += [
                token.ends_segment.eq(left == 1),
                token.ends_path.eq(launched.ends_path & (left == 1)),
                token.segment.eq(launched.segment),
                token.tag.eq(launched.tag),
            ]
        m.d.comb += [
            dropping.eq(self.drop & (token.tag == self.drop_tag)),
            token.valid.eq((launch | ~free) & ~dropping),
        ]
        with m.If(dropping):
            m.d.sync += [left.eq(0), free.eq(1)]

        return m

    def _is_dropped(self, identity):
        return self.drop & (identity.tag == self.drop_tag)
