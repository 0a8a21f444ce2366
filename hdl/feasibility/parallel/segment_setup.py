"""From points to segments, and from segments to the groups of cells that lanes take each cycle."""

from typing import NamedTuple

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.primitives.buffers import SkidBuffer
from pathgene.hdl.primitives.logic import fanout, multiplex
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width


__all__ = ["TAG_BITS", "SegmentSetup", "SegmentShaper", "segment_layout", "token_layout"]

#: Width of the number that distinguishes paths in flight, of which there are at most as many as
#: places for verdicts.
TAG_BITS = 4


def segment_layout(
    lanes: int, coordinate_bits: int, altitude_bits: int, half_steps: bool = False
) -> data.StructLayout:
    """Return the layout of a segment for the lanes.

    ``steep`` (the major axis is y), ``descending`` (along it), ``length`` (cells minus one),
    ``major``, ``minor``, ``altitude`` (where it starts), ``across`` and ``rise`` (gain of minor
    coordinate and altitude along it), ``places`` (of each lane's first cell along the segment),
    ``across_to`` and ``rise_to`` (their products with ``across`` and ``rise``), ``reciprocal`` (of
    the length).

    With ``half_steps``, the altitudes are the lowest within half a step of each cell: ``rise_to``
    is the product with twice the place, minus one if the segment rises and plus one otherwise.
    ``lowest`` is the altitude of the lower end.
    """
    xy, z = coordinate_bits, altitude_bits
    lane_bits = exact_log2(lanes)
    lowest = {"lowest": z} if half_steps else {}
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
            "places": data.ArrayLayout(max(1, lane_bits), lanes),
            "across_to": data.ArrayLayout(signed(xy + 1 + lane_bits), lanes),
            "rise_to": data.ArrayLayout(signed(z + 1 + lane_bits + half_steps), lanes),
            "reciprocal": Precision.of(lanes, xy, z, half_steps).reciprocal,
            **lowest,
        }
    )


def token_layout(segment_bits: int) -> data.StructLayout:
    """Return the layout of the data that accompanies a group of cells through the pipeline.

    ``valid``; ``starts_segment`` and ``ends_segment`` (the group is the first or last of its
    segment), ``first`` and ``ends_path`` (of its path), ``segment`` (its number), ``tag`` (of its
    path).
    """
    return data.StructLayout(
        {
            "valid": 1,
            "starts_segment": 1,
            "ends_segment": 1,
            "first": 1,
            "ends_path": 1,
            "segment": segment_bits,
            "tag": TAG_BITS,
        }
    )


class SegmentShaper(Unit):
    """Stages that derive a segment's shape from its ends: base class of the launching units.

    The first stage computes differences, their signs and the major axis; the second, small
    multiples of the differences, in parallel with the reciprocal of the length.

    Attributes
    ----------
    half_steps : bool
        See :func:`segment_layout`.
    """

    lanes: PowerOfTwo(1, "1 << coordinate_bits", "Cells or corners in a group.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    half_steps = False

    def _measure(self, m, load, before, point, turns, reciprocals, identity):
        """Add the first stage; return its registers for a segment from ``before`` to ``point``.

        ``identity`` assigns the identity of the segment in the same cycle.

        ``turns`` are the signs of the sum and the difference of the two gains; the segment is steep
        if they are equal. If both sides are equally long, either axis may be the major one: the
        cells are the same.
        """
        xy, z = self.coordinate_bits, self.altitude_bits
        ends = Signal(data.ArrayLayout(self.point_layout, 2), reset_less=True)
        gains = [Signal(signed(xy + 1), name=f"gain_{n}", reset_less=True) for n in "xy"]
        sides = [Signal(xy, name=f"side_{n}", reset_less=True) for n in "xy"]
        rise = Signal(signed(z + 1), reset_less=True)
        half = Signal.like(rise, reset_less=True)
        steep = Signal(reset_less=True)
        differences = reciprocals.differences
        m.d.comb += [
            reciprocals.second.eq(steep),
            *(
                difference.eq(point[axis] - before[axis])
                for axis, difference in zip("xy", differences, strict=True)
            ),
        ]
        with m.If(load):
            m.d.sync += [
                *identity,
                ends[0].eq(before),
                ends[1].eq(point),
                rise.eq(point.altitude - before.altitude),
                steep.eq(turns[0] == turns[1]),
            ]
            for axis, gain, side, difference in zip("xy", gains, sides, differences, strict=True):
                m.d.sync += [
                    gain.eq(difference),
                    side.eq(Mux(difference < 0, before[axis] - point[axis], difference)),
                ]
            if self.half_steps:
                gain, loss = point.altitude - before.altitude, before.altitude - point.altitude
                m.d.sync += half.eq(Mux(gain < 0, gain, loss))
        start, descending = Signal(exact_log2(self.lanes)), Signal()
        if self.half_steps:
            is_steep = turns[0] == turns[1]
            with m.If(load):
                m.d.sync += start.eq(Mux(is_steep, before.y, before.x))
                m.d.sync += descending.eq(Mux(is_steep, *differences[::-1]) < 0)
        return _Sides(ends, gains, sides, rise, half, steep, start, descending)

    def _shape(self, m, move_on, measured):
        """Add the second stage; return its registers for a segment, without the reciprocal."""
        ends, gains, sides, rise, half, steep, *turned = measured
        lanes, lane_bits = self.lanes, exact_log2(self.lanes)
        across, descending = Signal(signed(self.coordinate_bits + 1)), Signal()
        start = Signal(lane_bits)
        shape = Signal(
            data.StructLayout(
                {name: field.shape for name, field in self.segment.shape() if name != "reciprocal"}
            ),
            reset_less=True,
        )
        m.d.comb += across.eq(Mux(steep, gains[0], gains[1]))
        if self.half_steps:
            m.d.comb += [start.eq(turned[0]), descending.eq(turned[1])]
        else:
            m.d.comb += descending.eq(Mux(steep, gains[1], gains[0]) < 0)
            m.d.comb += start.eq(Mux(steep, ends[0].y, ends[0].x))
        with m.If(move_on):
            m.d.sync += [
                shape.steep.eq(steep),
                shape.descending.eq(descending),
                shape.length.eq(Mux(steep, sides[1], sides[0])),
                shape.major.eq(Mux(steep, ends[0].y, ends[0].x)),
                shape.minor.eq(Mux(steep, ends[0].x, ends[0].y)),
                shape.across.eq(across),
                shape.rise.eq(rise),
                # Within one cell the lower end counts, and a length of 0 makes the segment level.
                shape.altitude.eq(
                    Mux(
                        (rise < 0) & ~Cat(sides).any(),
                        ends[1].altitude,
                        ends[0].altitude,
                    )
                ),
            ]
            if self.half_steps:
                m.d.sync += shape.lowest.eq(ends[rise < 0].altitude)
            for lane in range(lanes):
                # A table of the distances from the start to the lane's first cell, upwards and
                # downwards, because adders would be slower.
                up = [(lane - at) % lanes for at in range(lanes)]
                down = [(at - lane) % lanes for at in range(lanes)]
                places = [C(place, lane_bits) for place in (*up, *down)]
                place = multiplex(Cat(start, descending), places)
                m.d.sync += [
                    shape.places[lane].eq(place),
                    shape.across_to[lane].eq(_multiple(across, place)),
                    shape.rise_to[lane].eq(
                        _odd_multiple(rise, place, half)
                        if self.half_steps
                        else _multiple(rise, place)
                    ),
                ]
        return shape


class SegmentSetup(SegmentShaper):
    """Makes segments from points, and launches them back to back.

    A segment waits for its turn in two stages: differences, their signs, and the major axis; then
    small multiples of the differences, and the reciprocal of the length. From the second stage it
    is launched: one group of its cells per cycle, then the next segment. Nothing after this unit
    waits, and while points arrive no cycle is lost between segments or paths. A segment is launched
    2 cycles after its second point is taken, or later if earlier segments are still being launched.
    A path begins with its first point, and a segment with its second: points wait for a place for
    the verdict and the count.

    In the cycle of ``drop`` the whole path is discarded; its later points are taken and discarded.

    Members
    -------
    points : In(stream.Signature(point_layout))
    room, segment_room : In(1)
    begins, segment_begins : Out(1)
        See :func:`pathgene.hdl.feasibility.layouts.walker_signature`.
    drop : In(1)
    drop_tag : In(TAG_BITS)
        Discard this path.
    token : Out(token_layout)
        The group that is launched.
    segment : Out(segment_layout)
        With ``token.starts_segment``.
    """

    segment_bits: Width(1, text="Number of a segment in its path.")

    def interface(self):
        self.point_layout = point_layout(self.coordinate_bits, self.altitude_bits)
        self.identity_layout = data.StructLayout(
            {"tag": TAG_BITS, "first": 1, "ends_path": 1, "segment": self.segment_bits}
        )
        return {
            "points": In(stream.Signature(self.point_layout)),
            "room": In(1),
            "segment_room": In(1),
            "begins": Out(1),
            "segment_begins": Out(1),
            "drop": In(1),
            "drop_tag": In(TAG_BITS),
            "token": Out(token_layout(self.segment_bits)),
            "segment": Out(segment_layout(self.lanes, self.coordinate_bits, self.altitude_bits)),
        }

    def elaborate(self, platform):
        m = Module()

        # Whether the stages hold a segment, and whether the last group of a segment has been
        # launched. The first stage has its own copies of these registers, because shared registers
        # would arrive too late.
        measured_next, waiting_next, free_next = Signal(), Signal(), Signal()
        has_measured, measured_full = fanout(m, *[measured_next] * 2, name="measured")
        has_waiting, waiting_full = fanout(m, *[waiting_next] * 2, name="waiting")
        free, freed = fanout(m, *[free_next] * 2, name="free", init=1)
        load, move_on, launch = Signal(), Signal(), Signal()
        measured = Signal(self.identity_layout, reset_less=True)
        waiting = Signal(self.identity_layout, reset_less=True)
        m.submodules.reciprocals = reciprocals = Reciprocals(
            self.coordinate_bits,
            Precision.of(self.lanes, self.coordinate_bits, self.altitude_bits),
        )
        m.d.comb += [
            load.eq(~measured_full | ~waiting_full | freed),
            move_on.eq(~has_waiting | launch),
            launch.eq(has_waiting & free),
            reciprocals.load.eq(load),
            reciprocals.move.eq(move_on),
            waiting_next.eq(
                Mux(
                    move_on,
                    has_measured & ~self._is_dropped(measured),
                    has_waiting & ~self._is_dropped(waiting),
                )
            ),
        ]

        enters, path = self._take_points(m, load)
        m.d.comb += measured_next.eq(Mux(load, enters, has_measured & ~self._is_dropped(measured)))
        identity = [
            measured.tag.eq(path.tag),
            measured.first.eq(path.number == 0),
            measured.ends_path.eq(path.point.last),
            measured.segment.eq(path.number),
        ]
        turns = self._turns(m, path)
        sides = self._measure(m, load, path.before, path.point, turns, reciprocals, identity)
        shape = self._shape(m, move_on, sides)
        with m.If(move_on):
            m.d.sync += waiting.eq(measured)
        m.d.comb += [
            self.segment.reciprocal.eq(reciprocals.reciprocal),
            *(self.segment[name].eq(shape[name]) for name, _ in shape.shape()),
        ]
        self._launch(m, launch, free, free_next, waiting, shape)

        return m

    def _take_points(self, m, load):
        """Take points; return whether they complete a segment, and their path."""
        # A point enters if there is room, and waits in the buffer for its turn; each of these takes
        # about half a cycle.
        m.submodules.point_buffer = buffer = SkidBuffer(self.point_layout)
        begun, room, comes = Signal(), Signal(), Signal()
        m.d.comb += [
            room.eq(Mux(begun, self.segment_room, self.room)),
            buffer.words.p.eq(self.points.p),
            buffer.words.valid.eq(self.points.valid & room),
            self.points.ready.eq(buffer.words.ready & room),
            comes.eq(self.points.valid & self.points.ready),
            self.begins.eq(comes & ~begun),
            self.segment_begins.eq(comes & begun),
        ]
        with m.If(comes):
            m.d.sync += begun.eq(~self.points.p.last)

        point = buffer.passed.p
        before = Signal(self.point_layout, reset_less=True)
        inside, unwanted = Signal(), Signal()
        tag, number = Signal(TAG_BITS), Signal(self.segment_bits)
        dropped, taken = Signal(), Signal()
        m.d.comb += [
            buffer.passed.ready.eq(load),
            taken.eq(buffer.passed.valid & load),
            dropped.eq(unwanted | (inside & self.drop & (self.drop_tag == tag))),
        ]
        m.d.sync += unwanted.eq(dropped & ~(taken & point.last))
        with m.If(taken):
            m.d.sync += [before.eq(point), inside.eq(~point.last)]
            with m.If(inside):
                m.d.sync += number.eq(number + 1)
            with m.Else():
                m.d.sync += [number.eq(0), tag.eq(tag + 1)]
        return taken & inside & ~dropped, _Path(taken, before, point, tag, number)

    def _turns(self, m, path):
        """Return the signs of the sum and difference of the gains, computed from sums per point."""
        point = path.point
        sums, sums_before = [point.y + point.x, point.y - point.x], []
        for name, value in zip(("sum", "difference"), sums, strict=True):
            sums_before.append(Signal(value.shape(), name=f"{name}_before", reset_less=True))
            with m.If(path.taken):
                m.d.sync += sums_before[-1].eq(value)
        return [(now - before)[-1] for now, before in zip(sums, sums_before, strict=True)]

    def _launch(self, m, launch, free, free_next, waiting, shape):
        """Launch the groups of the segment that is ``waiting``, one group per cycle."""
        token = self.token
        left = Signal(self.coordinate_bits)  # Groups left of the segment launched last.
        launched = Signal(self.identity_layout, reset_less=True)
        dropping = Signal()
        groups = shape.length >> exact_log2(self.lanes)
        with m.If(launch):
            m.d.sync += [left.eq(groups), launched.eq(waiting)]
            m.d.comb += [
                free_next.eq(groups == 0),
                token.starts_segment.eq(1),
                token.first.eq(waiting.first),
                token.ends_segment.eq(groups == 0),
                token.ends_path.eq(waiting.ends_path & (groups == 0)),
                token.segment.eq(waiting.segment),
                token.tag.eq(waiting.tag),
            ]
        with m.Else():
            m.d.sync += left.eq(left - ~free)
            m.d.comb += [
                free_next.eq(left <= 1),
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
            m.d.sync += left.eq(0)
            m.d.comb += free_next.eq(1)

    def _is_dropped(self, identity):
        return self.drop & (identity.tag == self.drop_tag)


class _Path(NamedTuple):
    """The path whose points are arriving: the latest points, and the segment that they end."""

    taken: Value
    before: Value
    point: Value
    tag: Value
    number: Value


class _Sides(NamedTuple):
    """A measured segment: its ends, and the differences between them.

    ``half`` is the rise, or its negative if the segment rises: twice the altitude lost over half a
    step. With half steps, ``start`` is the first lane, and ``descending`` is set if the segment
    runs against the major axis.
    """

    ends: Value
    gains: list[Value]
    sides: list[Value]
    rise: Value
    half: Value
    steep: Value
    start: Value
    descending: Value


def _multiple(value, factor):
    """Return a product made of adders, because a multiplier for a few bits would be slower."""
    return sum((Mux(bit, value << i, 0) for i, bit in enumerate(factor)), Const(0, signed(1)))


def _odd_multiple(value, factor, more):
    """Return ``2 * value * factor + more`` as a balanced tree of adders."""
    terms = [more, *(Mux(bit, value << i + 1, 0) for i, bit in enumerate(factor))]
    while len(terms) > 1:
        terms = [sum(terms[at + 1 : at + 2], terms[at]) for at in range(0, len(terms), 2)]
    return terms[0]
