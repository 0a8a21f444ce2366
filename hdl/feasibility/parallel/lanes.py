"""Lanes of the parallel walker: their steps, the comparison with the terrain, the first hit."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from pathgene.hdl.feasibility.parallel.segment_setup import segment_layout, token_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import lane_layout, lane_row_bits
from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Flag, PowerOfTwo, Unit, Width


__all__ = ["HitLocator", "Lanes", "Slopes", "group_layout", "motion_layout"]


# Bits of a reciprocal that one multiplier takes, without a sign: 18 x 18 bits signed on a target.
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

    A lane's first cell comes from a separate product with a multiple of the difference, so it does
    not need a sum of slopes. ``origins`` and ``step`` are valid for one cycle, 1 cycle after
    ``segment``: products of registers are registered, and the sums of their parts reach the lanes
    in the same cycle. On a target, the multipliers contain these registers.

    Members
    -------
    segment : In(segment_layout)
    origins : Out(motion_layout).array(lanes)
        First cell of each lane, even if it lies past the end of the segment.
    step : Out(motion_layout)
        Gain of every lane per cycle.
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
        """Return ``bias + floor(factor * reciprocal / 2**shift)``, one cycle later."""
        reciprocal = self.segment.reciprocal
        if len(reciprocal) <= _PART:
            return _registered(m, factor, _signed(reciprocal), shift, name) + bias

        cut = min(shift, _PART)
        low = _registered(m, factor, _signed(reciprocal[:_PART]), cut, f"{name}_low")
        high = _registered(m, factor, _signed(reciprocal[_PART:]), 0, f"{name}_high")
        return (low + (high << _PART - cut) >> shift - cut) + bias


def _registered(m, first, second, shift, name):
    """Return ``first * second >> shift``, one cycle later."""
    m.submodules[name] = multiplier = Multiplier((len(first), len(second)), shift)
    m.d.comb += [multiplier.first.eq(first), multiplier.second.eq(second)]
    return multiplier.product


def _signed(value):
    """Return an unsigned value as a signed one, for a multiplier of signed numbers."""
    return Cat(value, Const(0, 1)).as_signed()


def group_layout(lanes: int, coordinate_bits: int) -> data.StructLayout:
    """Return the layout of a group: the cells of one cycle.

    ``steep`` and ``descending`` of its segment; ``major`` (of its first cell), ``minors`` (of all
    lanes), ``cells`` (their number).
    """
    return data.StructLayout(
        {
            "steep": 1,
            "descending": 1,
            "major": coordinate_bits,
            "minors": data.ArrayLayout(coordinate_bits, lanes),
            "cells": range(lanes + 1),
        }
    )


class Lanes(Unit):
    """Walks segments, ``lane_count`` cells per cycle.

    Lane c has the cells whose major coordinate is congruent to c mod ``lane_count``. Its cell in
    the first group depends on the start of the segment, so that each group except the last is full:
    a segment of n cells takes n / ``lane_count`` cycles, rounded up. The following cells are sums,
    because every lane gains the same in a cycle; see
    :class:`pathgene.hdl.feasibility.parallel.reciprocal.Precision`.

    ``group`` and ``lanes`` follow their token in ``launched`` by one cycle.

    Source: *allaire two-tier*, section 5.3. Difference: the reference has several walkers, each
    with a part of the segment.

    Members
    -------
    launched : In(token_layout)
    segment : In(segment_layout)
    origins : In(motion_layout).array(lane_count)
    step : In(motion_layout)
        First cells and gain of the segment that ``launched`` starts.
    token : Out(token_layout)
        ``launched``, one cycle later.
    group : Out(group_layout)
    lanes : Out(lane_layout).array(lane_count)
    """

    lane_count: PowerOfTwo(1, "1 << coordinate_bits", "Cells walked in a cycle.", name="Lanes")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")
    half_steps: Flag(
        "Each ``ceiling`` is the lowest altitude within half a step of the cell, rounded "
        "down, and never below the lower end. Only the cell at the lower end can lie below "
        "it: that cell takes the altitude of the end."
    ) = False

    def interface(self):
        sizes = (self.lane_count, self.coordinate_bits, self.altitude_bits)
        token, motion = token_layout(self.segment_bits), motion_layout(*sizes, self.half_steps)
        return {
            "launched": In(token),
            "segment": In(segment_layout(*sizes, self.half_steps)),
            "origins": In(motion).array(self.lane_count),
            "step": In(motion),
            "token": Out(token),
            "group": Out(group_layout(self.lane_count, self.coordinate_bits)),
            "lanes": Out(lane_layout(*sizes)).array(self.lane_count),
        }

    def elaborate(self, platform):
        m = Module()
        lane_count, segment, token = self.lane_count, self.segment, self.token
        precision = Precision.of(
            lane_count, self.coordinate_bits, self.altitude_bits, self.half_steps
        )
        fractions = {"minor": precision.minor, "rise": precision.rise}
        lane_bits = exact_log2(lane_count)
        row_bits = lane_row_bits(lane_count, self.coordinate_bits)
        begins = self.launched.starts_segment

        m.d.sync += token.eq(self.launched)

        # In the last group, only the lanes up to the end of the segment have a cell.
        rest = Signal(max(1, lane_bits), reset_less=True)
        step = Signal.like(self.step, reset_less=True)
        steep, descending = Signal(reset_less=True), Signal(reset_less=True)
        major = Signal(self.coordinate_bits, reset_less=True)
        rest_now = segment.length[:lane_bits]
        with m.If(begins):
            m.d.sync += [
                rest.eq(rest_now),
                step.eq(self.step),
                steep.eq(segment.steep),
                descending.eq(segment.descending),
                major.eq(segment.major),
            ]
        with m.Else():
            m.d.sync += major.eq(Mux(descending, major - lane_count, major + lane_count))
        m.d.comb += [
            self.group.steep.eq(steep),
            self.group.descending.eq(descending),
            self.group.major.eq(major),
            self.group.cells.eq(Mux(token.ends_segment, rest + 1, lane_count)),
        ]

        # Both rows of the next group: the row of its first cell and the row after it.
        begin = segment.major[lane_bits:]
        beyond = Signal(row_bits)
        next_row, next_beyond = (
            Signal(row_bits, name=name, reset_less=True) for name in ("next_row", "next_beyond")
        )
        at_first, then = Signal(signed(2)), Signal(signed(2))
        m.d.comb += [
            at_first.eq(Mux(segment.descending, -1, 1)),
            then.eq(Mux(descending, -1, 1)),
            beyond.eq(begin + at_first),
        ]
        # Sums come first, because `begins` drives all lanes and arrives late.
        m.d.sync += [
            next_row.eq(Mux(begins, beyond, next_row + then)),
            next_beyond.eq(Mux(begins, beyond + at_first, next_beyond + then)),
        ]

        first = segment.major[:lane_bits]
        for number, (lane, start) in enumerate(zip(self.lanes, self.origins, strict=True)):
            motion = Signal.like(step, name=f"motion_{number}", reset_less=True)
            row = Signal(row_bits, name=f"row_{number}", reset_less=True)
            in_last = Signal(name=f"in_last_{number}", reset_less=True)
            late = Signal(name=f"late_{number}", reset_less=True)
            is_late = Signal(name=f"is_late_{number}")
            # Written without comparisons whose result is constant.
            m.d.comb += is_late.eq(
                Mux(
                    segment.descending,
                    first < number if number else 0,
                    first > number if number < lane_count - 1 else 0,
                )
            )
            with m.If(begins):
                m.d.sync += [
                    motion.eq(start),
                    late.eq(is_late),
                    row.eq(Mux(is_late, beyond, begin)),
                    in_last.eq(segment.places[number] <= rest_now if lane_bits else 1),
                ]
            with m.Else():
                m.d.sync += [
                    *(motion[axis].eq(motion[axis] + step[axis]) for axis in fractions),
                    row.eq(Mux(late, next_beyond, next_row)),
                ]

            minor = motion.minor[precision.minor :]
            m.d.comb += [
                self.group.minors[number].eq(minor),
                lane.valid.eq(token.valid & (in_last | ~token.ends_segment)),
                lane.row.eq(row),
                lane.minor.eq(minor),
                lane.ceiling.eq(motion.rise[precision.rise :]),
            ]
        if self.half_steps:
            self._end_low(m, rest_now)

        return m

    def _end_low(self, m, rest):
        """Give the cell at the lower end of the segment the altitude of that end.

        That is the first cell or, if the segment falls, the last one, ``rest`` places after the
        first cell of its group.
        """
        segment, begins = self.segment, self.launched.starts_segment
        lowest = Signal(self.altitude_bits, reset_less=True)
        falling = segment.rise < 0
        with m.If(begins):
            m.d.sync += lowest.eq(segment.lowest)
        for number, (lane, place) in enumerate(zip(self.lanes, segment.places, strict=True)):
            is_first = Signal(name=f"is_first_{number}", reset_less=True)
            is_last = Signal(name=f"is_last_{number}", reset_less=True)
            m.d.sync += is_first.eq(begins & ~falling & (place == 0))
            with m.If(begins):
                m.d.sync += is_last.eq(falling & (place == rest))
            with m.If(is_first | is_last & self.token.ends_segment):
                m.d.comb += lane.ceiling.eq(lowest)


class HitLocator(Unit):
    """Finds the first colliding cell of a group, and counts all colliding cells, one cycle later.

    Along a segment, lanes follow each other from the lane of the group's first cell, wrapping
    around to the lane before it, in the opposite order if the segment descends.

    Members
    -------
    group : In(group_layout)
    hits, blocked : In(lanes)
        Lanes whose cells collide, and lanes whose cells are blocked, which also collide.
    hit : Out(1)
    until : Out(range(lanes + 1))
    x, y : Out(coordinate_bits)
    terrain, nofly : Out(range(lanes + 1))
        See :func:`pathgene.hdl.feasibility.layouts.step_layout`.
    """

    lanes: PowerOfTwo(1, "1 << coordinate_bits", "Cells of a group.")
    coordinate_bits: Width(1)

    def interface(self):
        return {
            "group": In(group_layout(self.lanes, self.coordinate_bits)),
            "hits": In(self.lanes),
            "blocked": In(self.lanes),
            "hit": Out(1),
            "until": Out(range(self.lanes + 1)),
            "x": Out(self.coordinate_bits),
            "y": Out(self.coordinate_bits),
            "terrain": Out(range(self.lanes + 1)),
            "nofly": Out(range(self.lanes + 1)),
        }

    def elaborate(self, platform):
        m = Module()
        group, lanes = self.group, self.lanes
        lane_bits = exact_log2(lanes)

        # After mirroring for a descending segment, lane numbers rise along it, except lanes that
        # have wrapped around, which come last.
        start = group.major[:lane_bits]
        mirrored, late = Signal(lanes), Signal(lanes)
        m.d.comb += mirrored.eq(Mux(group.descending, self.hits[::-1], self.hits))
        for number in range(lanes):
            opposite = lanes - 1 - number
            # Written without comparisons whose result is constant.
            m.d.comb += late[number].eq(
                Mux(
                    group.descending,
                    start < opposite if opposite else 0,
                    start > number if opposite else 0,
                )
            )
        chosen, gone = Signal(lanes), Signal()
        early = mirrored & ~late
        m.d.comb += [
            gone.eq(~early.any()),
            chosen.eq(Mux(gone, _lowest(mirrored & late), _lowest(early))),
        ]

        # All lanes that have wrapped around are in the same row.
        row = Signal(lane_row_bits(lanes, self.coordinate_bits), reset_less=True)
        here = group.major[lane_bits:]
        first = Signal(lanes, reset_less=True)
        places = [Signal.like(self.until, name=f"place_{n}", reset_less=True) for n in range(lanes)]
        now = Signal.like(group, reset_less=True)
        m.d.sync += [
            now.eq(group),
            row.eq(Mux(gone, Mux(group.descending, here - 1, here + 1), here)),
            first.eq(Mux(group.descending, chosen[::-1], chosen)),
            self.hit.eq(self.hits.any()),
            self.terrain.eq(sum(self.hits & ~self.blocked)),
            self.nofly.eq(sum(self.blocked)),
            *(
                place.eq(Mux(group.descending, start - number, number - start)[:lane_bits] + 1)
                for number, place in enumerate(places)
            ),
        ]

        major, minor = (Signal(self.coordinate_bits, name=n) for n in ("major", "minor"))
        m.d.comb += [
            self.until.eq(_selected(first, places)),
            minor.eq(_selected(first, now.minors)),
            major.eq(Cat(_selected(first, range(lanes))[:lane_bits], row)),
            self.x.eq(Mux(now.steep, minor, major)),
            self.y.eq(Mux(now.steep, major, minor)),
        ]

        return m


def _lowest(flags):
    return flags & (~flags + 1)[: len(flags)]


def _selected(flags, items):
    """Return the item whose flag is set, or 0 if none is."""
    result = Const(0)
    for flag, item in zip(flags, items, strict=True):
        result |= Mux(flag, item, 0)
    return result
