"""Walk of a segment cell by cell, and the comparison of its altitudes with the terrain."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.feasibility.two_tier.segment_setup import segment_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["AltitudeComparator", "CellWalker", "level_layout", "tested_layout", "visit_layout"]


def visit_layout(coordinate_bits: int, segment_bits: int) -> data.StructLayout:
    """Return the layout of one visited cell, in cells of its map, and its place in the path.

    ``coarse``: its map is the coarse one. ``segment``: number of its segment. ``first``: it is the
    first cell of its path; ``ends_segment`` and ``ends_path``: it is the last cell of its segment
    or path.
    """
    return data.StructLayout(
        {
            "x": coordinate_bits,
            "y": coordinate_bits,
            "coarse": 1,
            "segment": segment_bits,
            "first": 1,
            "ends_segment": 1,
            "ends_path": 1,
        }
    )


def level_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of an altitude: the exact quotient ``scaled / steps``."""
    return data.StructLayout({"scaled": altitude_bits + coordinate_bits, "steps": coordinate_bits})


class CellWalker(Unit):
    """Visits every cell of segments, including both ends, in walking order.

    Cell k of a segment of n steps is ``x0 + floor((2 k dx + n) / (2 n))``, y likewise. Each step
    moves one cell along the longer side. Along the shorter side, an error between -2 n and -1 grows
    by twice that side in each step, and the walker moves one cell when the error reaches 0. Halves
    are rounded up instead of away from the start: towards lower coordinates, the error begins one
    lower. The altitude is the exact ``(z0 n + k dz) / n``, whose numerator is accumulated step by
    step; a segment without steps counts as a single step, whose first cell alone is visited.

    The first cell is visited in the cycle after its segment is taken, then one cell is visited per
    cycle. The next segment is taken in the last of these cycles, so that no cycle is lost.

    Source: *allaire two-tier*, section 3.2.3. Difference: the next segment is set up during the
    walk.

    Members
    -------
    segments : In(stream.Signature(segment_layout))
    room : In(1)
        The first segment of a path may be taken.
    segment_room : In(1)
        A segment may be taken.
    begins : Out(1)
        The first segment of a path is taken.
    segment_begins : Out(1)
        A segment is taken to be walked.
    drop : In(1)
        Leave the path of the latest visited cell from the next cycle on; that cell must not have
        been its last. A cell may still be visited in the cycle of ``drop``; it is void. Later
        segments of the path are taken and not walked, one per cycle.
    visiting : Out(1)
        ``visit`` is visited in this cycle.
    visit : Out(visit_layout)
        A register.
    level : Out(level_layout)
        Altitude at the cell that was visited in the previous cycle.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")

    def interface(self):
        segments = segment_layout(self.coordinate_bits, self.altitude_bits, self.segment_bits)
        return {
            "segments": In(stream.Signature(segments)),
            "room": In(1),
            "segment_room": In(1),
            "begins": Out(1),
            "segment_begins": Out(1),
            "drop": In(1),
            "visiting": Out(1),
            "visit": Out(visit_layout(self.coordinate_bits, self.segment_bits)),
            "level": Out(level_layout(self.coordinate_bits, self.altitude_bits)),
        }

    def elaborate(self, platform):
        m = Module()
        xy = self.coordinate_bits

        segment = self.segments.p
        active = Signal()
        dropping = Signal()
        # The current segment.
        last = Signal()
        west = Signal()
        south = Signal()
        steep = Signal()
        left = Signal(xy)
        error = Signal(signed(xy + 2))
        growth = Signal(xy + 1)
        excess = Signal(signed(xy + 2))

        visit = self.visit
        opens = Signal()
        ended = Signal()
        free = Signal()
        load = Signal()
        m.d.comb += [
            opens.eq(segment.number == 0),
            ended.eq(left == 0),
            self.visiting.eq(active),
            visit.ends_segment.eq(ended),
            visit.ends_path.eq(ended & last),
            free.eq(~active | ended),
            self.segments.ready.eq(
                dropping | (free & ~self.drop & self.segment_room & (self.room | ~opens))
            ),
            load.eq(self.segments.valid & self.segments.ready & ~dropping),
            self.begins.eq(load & opens),
            self.segment_begins.eq(load),
        ]

        with m.If(self.drop):
            m.d.sync += dropping.eq(~(active & last))
        with m.Elif(dropping & self.segments.valid & segment.last):
            m.d.sync += dropping.eq(0)

        with m.If(self.drop):
            m.d.sync += active.eq(0)
        with m.Elif(free):
            m.d.sync += active.eq(load)

        grown = Signal(signed(xy + 2))
        across = Signal()  # A step along the shorter side.
        m.d.comb += [grown.eq(error + growth), across.eq(grown >= 0)]
        with m.If(load):
            m.d.sync += [
                visit.x.eq(segment.x),
                visit.y.eq(segment.y),
                visit.coarse.eq(segment.coarse),
                visit.segment.eq(segment.number),
                visit.first.eq(opens),
                last.eq(segment.last),
                west.eq(segment.west),
                south.eq(segment.south),
                steep.eq(segment.steep),
                left.eq(segment.steps),
                # n - 2 n, and one lower if steps go towards 0.
                error.eq(-segment.steps - Mux(segment.steep, segment.west, segment.south)),
                growth.eq(segment.minor << 1),
                excess.eq((segment.minor - segment.steps) << 1),
            ]
        with m.Elif(active):
            m.d.sync += [
                visit.first.eq(0),
                left.eq(left - 1),
                error.eq(Mux(across, error + excess, grown)),
            ]
            with m.If(steep | across):
                m.d.sync += visit.y.eq(Mux(south, visit.y - 1, visit.y + 1))
            with m.If(~steep | across):
                m.d.sync += visit.x.eq(Mux(west, visit.x - 1, visit.x + 1))

        # The altitude follows one cycle later, so that the product of a new segment has a cycle.
        steps = Signal(xy)
        climb = Signal(signed(self.altitude_bits + 1))
        scaled_start = Signal(self.level.scaled.shape())
        begins = Signal()
        with m.If(load):
            divisor = Mux(segment.steps == 0, 1, segment.steps)
            m.d.sync += [
                begins.eq(1),
                steps.eq(divisor),
                climb.eq(segment.climb),
                scaled_start.eq(segment.altitude * divisor),
            ]
        with m.Else():
            m.d.sync += begins.eq(0)
        with m.If(active):
            m.d.sync += [
                self.level.scaled.eq(Mux(begins, scaled_start, self.level.scaled + climb)),
                self.level.steps.eq(steps),
            ]

        return m


def tested_layout(coordinate_bits: int, segment_bits: int, latency: int) -> data.StructLayout:
    """Return the layout of a cell that has been compared.

    ``hit``: the path is not above the ground. ``blocked``: no path may cross that ground.
    ``reads``: number of addresses given to a memory for the same path since then, including this
    cycle's. ``open``: neither this cell nor any cell read since is the path's last. ``latency``:
    cycles from a visit to its test.
    """
    return data.StructLayout(
        {
            "visit": visit_layout(coordinate_bits, segment_bits),
            "hit": 1,
            "blocked": 1,
            "reads": range(latency + 1),
            "open": 1,
        }
    )


class AltitudeComparator(Unit):
    """Tests one cell per cycle, ``memory_latency + 3`` cycles after it was visited.

    A cell is hit when ``z0 n + k dz <= ground * n``: multiplication and comparison take one cycle
    each, and nothing is rounded.

    Attributes
    ----------
    latency : int
        Cycles from a visit to its test.

    Members
    -------
    visiting : In(1)
    visit : In(visit_layout)
        Cell whose address the memory gets in this cycle.
    level : In(level_layout)
        Altitude of the path at the cell of the previous cycle.
    ground : In(altitude_bits)
        Altitude of the cell visited ``memory_latency + 1`` cycles ago, from a register.
    drop : In(1)
        Discard cells visited after the tested cell, including this cycle's.
    valid : Out(1)
    tested : Out(tested_layout)
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1, text="The top altitude marks ground that no path may cross.")
    segment_bits: Width(1, text="Number of a segment in its path.")
    memory_latency: Count(1, 2, "Cycles from an address to its data.")

    def interface(self):
        self.latency = self.memory_latency + 3
        return {
            "visiting": In(1),
            "visit": In(visit_layout(self.coordinate_bits, self.segment_bits)),
            "level": In(level_layout(self.coordinate_bits, self.altitude_bits)),
            "ground": In(self.altitude_bits),
            "drop": In(1),
            "valid": Out(1),
            "tested": Out(tested_layout(self.coordinate_bits, self.segment_bits, self.latency)),
        }

    def elaborate(self, platform):
        m = Module()

        # Youngest first: the cell of this cycle, then the cells in the pipeline.
        valids, visits = [self.visiting], [self.visit]
        for stage in range(1, self.latency + 1):
            valid = Signal(name=f"valid_{stage}")
            visit = Signal.like(self.visit, name=f"visit_{stage}", reset_less=True)
            m.d.sync += [valid.eq(valids[-1] & ~self.drop), visit.eq(visits[-1])]
            valids.append(valid)
            visits.append(visit)

        def later(value, cycles, name):
            for cycle in range(cycles):
                register = Signal.like(value, name=f"{name}_{cycle}", reset_less=True)
                m.d.sync += register.eq(value)
                value = register
            return value

        steps = later(self.level.steps, self.memory_latency, "steps")
        scaled = later(self.level.scaled, self.memory_latency + 1, "scaled")
        scaled_ground = Signal(self.level.scaled.shape(), reset_less=True)
        top = later(self.ground == (1 << self.altitude_bits) - 1, 1, "top")
        m.d.sync += [
            scaled_ground.eq(self.ground * steps),
            self.tested.hit.eq(scaled <= scaled_ground),
            self.tested.blocked.eq(top),
        ]

        m.d.comb += [self.valid.eq(valids[-1]), self.tested.visit.eq(visits[-1])]
        ended = visits[-1].ends_path
        later_reads = []
        for valid, visit in zip(reversed(valids[:-1]), reversed(visits[:-1]), strict=True):
            later_reads.append(valid & ~ended)
            ended = ended | (valid & visit.ends_path)
        m.d.comb += [
            self.tested.reads.eq(sum(later_reads)),
            # The cell of this cycle does not count: if its path ends now, a drop is still correct.
            self.tested.open.eq(
                ~Cat(v & c.ends_path for v, c in zip(valids[1:], visits[1:], strict=True)).any()
            ),
        ]

        return m
