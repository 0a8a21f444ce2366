"""Blocks of the map: the lowest corner of each, and the scan of changed blocks."""

from amaranth import *
from amaranth.lib import data, memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.planner.layouts import corner_layout, row_layout
from pathgene.hdl.planner.wavefront.layouts import (
    BLOCK_BITS,
    COARSE_BITS,
    INDEX_BITS,
    block_layout,
    place_layout,
    shift_limit,
)
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS


__all__ = ["BlockMap", "LowestCorner", "lowest_layout"]


def lowest_layout(lanes, altitude_bits):
    """Return the layout of the lowest corner: its lane and altitude; ``blocked``: any corner is."""
    return data.StructLayout(
        {"lane": exact_log2(lanes), "altitude": altitude_bits, "none": 1, "blocked": 1}
    )


class LowestCorner(Unit):
    """First of the lowest corners in a row, found by halving the row in every cycle.

    ``lowest`` follows :attr:`latency` cycles after the corners. Its ``none`` is high if no corner
    qualifies.

    Attributes
    ----------
    latency : int

    Members
    -------
    corners : In(altitude_bits).array(lanes)
    counts : In(lanes)
        Lanes with a corner that counts.
    lowest : Out(lowest_layout)
    """

    lanes: PowerOfTwo(1, 64, "Corners in a row.")
    altitude_bits: Width(1, text="The top value marks a blocked corner.")

    def interface(self):
        self.latency = 1 + exact_log2(self.lanes)
        return {
            "corners": In(self.altitude_bits).array(self.lanes),
            "counts": In(self.lanes),
            "lowest": Out(lowest_layout(self.lanes, self.altitude_bits)),
        }

    def elaborate(self, platform):
        m = Module()

        # The bit above an altitude flags a missing corner. Lane numbers grow by one bit per level.
        left = []
        for lane, (corner, counts) in enumerate(zip(self.corners, self.counts, strict=True)):
            key = delay_line(m, Cat(corner, ~counts), 1, f"key_0_{lane}")
            blocked = delay_line(m, counts & corner.all(), 1, f"blocked_0_{lane}")
            left.append((key, None, blocked))
        level = 0
        while len(left) > 1:
            level += 1
            halved = []
            for pair, (a, b) in enumerate(zip(left[::2], left[1::2], strict=True)):
                name = f"{level}_{pair}"
                second = b[0] < a[0]
                lane = second if a[1] is None else Cat(Mux(second, b[1], a[1]), second)
                halved.append(
                    (
                        delay_line(m, Mux(second, b[0], a[0]), 1, f"key_{name}"),
                        delay_line(m, lane, 1, f"lane_{name}"),
                        delay_line(m, a[2] | b[2], 1, f"blocked_{name}"),
                    )
                )
            left = halved
        ((key, lane, blocked),) = left
        if lane is not None:
            m.d.comb += self.lowest.lane.eq(lane)
        m.d.comb += [
            self.lowest.altitude.eq(key[:-1]),
            self.lowest.none.eq(key[-1]),
            self.lowest.blocked.eq(blocked),
        ]

        return m


class BlockMap(Unit):
    """Minimum ground and lowest corner of each block, rescanned where the map has changed.

    A write to the map marks its block. A scan reads the marked blocks, one row of ``lanes`` corners
    per cycle, and skips unmarked blocks, one per cycle. If ``block_shift`` or ``fine`` differs from
    the previous scan, all blocks count as marked. ``busy`` is high for as many cycles as
    :func:`pathgene.sim.model.planner.run_cycles.scanning` says. Equals ``least`` and ``lowest`` of
    :func:`pathgene.sim.model.planner.definition.wavefront.blocks_of`; corners beyond the map are
    blocked.

    Members
    -------
    fine : In(1)
        The map has 64 x 64 blocks; otherwise 32 x 32. Steady like ``block_shift``.
    block_shift : In
        A block has ``2**block_shift`` corners along each edge: at most a 32nd of the map's, or one.
        Steady during a scan and while blocks are read.
    start, goal : In(corner_layout)
        The blocks of the ends are free; if a corner there is blocked, they have the altitude of the
        end. Steady while blocks are read, and one cycle earlier.
    write : In({"valid", "x", "y"})
        A corner that is written. Not while ``busy``.
    launch : In(1)
        Pulse: scan. Not while ``busy``.
    busy : Out(1)
    row : Out(row_layout)
        Row of corners to read while ``busy``.
    corners : In(altitude_bits).array(lanes)
        Altitudes of the row.
    start_block, goal_block : Out(place_layout)
        Blocks of the ends.
    number : In(12)
        Block to read while not ``busy``: 64 y + x.
    block : Out(block_layout)
        That block, 2 cycles later.
    """

    lanes: PowerOfTwo(1, "min(64, 1 << coordinate_bits)", "Corners in a row.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1, text="The top altitude is blocked.")
    read_latency: Count(1, text="Cycles from ``row`` to ``corners``.")

    def interface(self):
        xy, corner = self.coordinate_bits, corner_layout(self.coordinate_bits, self.altitude_bits)
        self.row_layout = row_layout(self.lanes, xy)
        self.block_layout = block_layout(xy, self.altitude_bits)
        return {
            "fine": In(1),
            "block_shift": In(max(1, shift_limit(xy).bit_length())),
            "start": In(corner),
            "goal": In(corner),
            "write": In(data.StructLayout({"valid": 1, "x": xy, "y": xy})),
            "launch": In(1),
            "busy": Out(1),
            "row": Out(self.row_layout),
            "corners": In(self.altitude_bits).array(self.lanes),
            "start_block": Out(place_layout),
            "goal_block": Out(place_layout),
            "number": In(INDEX_BITS),
            "block": Out(self.block_layout),
        }

    def elaborate(self, platform):
        m = Module()

        most = shift_limit(self.coordinate_bits)
        shift, fine = self.block_shift, self.fine
        m.submodules.tree = tree = LowestCorner(self.lanes, self.altitude_bits)
        behind = self.read_latency + tree.latency
        # Cycles from the number of the last block to its record in the memory.
        drain = behind + 2

        # Marks, one word per row of blocks, valid for the blocks of the previous scan.
        m.submodules.marks = marks = memory.Memory(shape=BLOCKS, depth=BLOCKS, init=[])
        mark_write, mark_read = marks.write_port(), marks.read_port(domain="comb")
        blocks = Cat(fine, shift)
        scanned, is_scanned = Signal(len(blocks)), Signal()
        written = Signal(data.StructLayout({"valid": 1, "x": BLOCK_BITS, "y": BLOCK_BITS}))
        furthest = (self.write.x >> shift) | (self.write.y >> shift)
        beyond = furthest[BLOCK_BITS:].any() | ~fine & furthest[COARSE_BITS:BLOCK_BITS].any()
        m.d.sync += [
            written.valid.eq(self.write.valid & ~beyond),
            written.x.eq(self.write.x >> shift),
            written.y.eq(self.write.y >> shift),
        ]
        with m.If(self.write.valid & (blocks != scanned)):
            m.d.sync += is_scanned.eq(0)

        # The scan: a row of blocks, a block of it, and a row of corners.
        at, all_marked = Signal(place_layout), Signal()
        left = Signal(BLOCKS, reset_less=True)
        corner_y = Signal(max(1, most), reset_less=True)
        group = Signal(max(1, most), reset_less=True)
        # Steady long before a scan.
        last_y, final_group = Signal.like(corner_y), Signal.like(group)
        edge = (1 << shift)[: most + 1]
        final = Mux(fine, BLOCKS - 1, COARSE_BLOCKS - 1)
        m.d.sync += [
            last_y.eq(edge - 1),
            final_group.eq((edge - 1) >> exact_log2(self.lanes)),
        ]
        last_group = group == final_group
        last = last_group & (corner_y == last_y)
        reads, drained = Signal(), Signal(range(drain))
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += at.eq(0)
                with m.If(self.launch):
                    m.next = "OPEN"
            with m.State("OPEN"):
                m.d.sync += [
                    all_marked.eq(~is_scanned | (scanned != blocks)),
                    is_scanned.eq(1),
                    scanned.eq(blocks),
                ]
                m.next = "ROW"
            with m.State("ROW"):
                m.d.sync += [
                    left.eq(mark_read.data | all_marked.replicate(BLOCKS)),
                    corner_y.eq(0),
                    group.eq(0),
                    drained.eq(0),
                ]
                m.next = "BLOCKS"
            with m.State("BLOCKS"):
                m.d.comb += reads.eq(left[0])
                m.d.sync += group.eq(group + 1)
                with m.If(last_group):
                    m.d.sync += [group.eq(0), corner_y.eq(corner_y + 1)]
                with m.If(last | ~left[0]):
                    m.d.sync += [corner_y.eq(0), group.eq(0), left.eq(left >> 1), at.x.eq(at.x + 1)]
                    with m.If(at.x == final):
                        m.d.sync += [at.x.eq(0), at.y.eq(at.y + 1)]
                        m.next = "ROW"
                        with m.If(at.y == final):
                            m.next = "DRAIN"
            with m.State("DRAIN"):
                m.d.sync += drained.eq(drained + 1)
                with m.If(drained == drain - 1):
                    m.next = "IDLE"
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))

        # A row is cleared once it has been read.
        clears = states.ongoing("ROW")
        row = Mux(clears, at.y, written.y)
        m.d.comb += [
            mark_read.addr.eq(row),
            mark_write.addr.eq(row),
            mark_write.en.eq(clears | written.valid),
            mark_write.data.eq(Mux(clears, 0, mark_read.data | (1 << written.x))),
        ]

        read = self._reduce(m, tree, at, corner_y, group, shift, reads, last, behind)
        self._read(m, read, shift)
        return m

    def _reduce(self, m, tree, at, corner_y, group, shift, reads, last, behind):
        """Read rows of corners, and keep the lowest of each block; return the read port."""
        lane_bits = exact_log2(self.lanes)
        x = (at.x << shift)[: self.coordinate_bits]
        y = (at.y << shift)[: self.coordinate_bits] | corner_y
        # Corners of neighbouring blocks, if a row is longer than a block, and corners beyond the
        # map.
        low = x[:lane_bits]
        counts = Cat(((lane ^ low) >> shift) == 0 for lane in range(self.lanes))
        if self.coordinate_bits < BLOCK_BITS:
            outside = (at.x | at.y)[self.coordinate_bits :].any()
            counts &= ~outside.replicate(self.lanes)
        counts = delay_line(m, counts, 1, "counts")
        row = Signal(self.row_layout, reset_less=True)
        m.d.sync += [row.x.eq((x >> lane_bits) | group), row.y.eq(y)]
        m.d.comb += [
            self.row.eq(row),
            tree.counts.eq(delay_line(m, counts, self.read_latency, "lanes")),
            *(own.eq(corner) for own, corner in zip(tree.corners, self.corners, strict=True)),
        ]

        # The place of the lowest corner of a row arrives with it.
        begins = (corner_y == 0) & (group == 0)
        tags = Signal(
            data.StructLayout({"first": 1, "last": 1, "number": INDEX_BITS}), reset_less=True
        )
        m.d.sync += [
            tags.first.eq(begins),
            tags.last.eq(last & reads),
            tags.number.eq(Cat(at.x, at.y)),
        ]
        tags = delay_line(m, tags, behind, "tags")
        where = delay_line(m, row, behind, "where")
        lowest = tree.lowest
        key = Cat(lowest.altitude, lowest.none)
        best = Signal(len(key), reset_less=True)
        found = Signal(self.block_layout, reset_less=True)
        is_blocked = Signal(reset_less=True)
        with m.If(tags.first | (key < best)):
            m.d.sync += [
                best.eq(key),
                found.altitude.eq(lowest.altitude),
                found.x.eq(Cat(lowest.lane, where.x)),
                found.y.eq(where.y),
            ]
        blocked = lowest.blocked | lowest.none
        m.d.sync += is_blocked.eq(Mux(tags.first, blocked, is_blocked | blocked))
        m.submodules.records = records = memory.Memory(
            shape=self.block_layout, depth=BLOCKS**2, init=[], attrs={"no_rw_check": 1}
        )
        write, read = records.write_port(), records.read_port()
        m.d.comb += [
            write.en.eq(delay_line(m, tags.last, 1, "ends")),
            write.addr.eq(delay_line(m, tags.number, 1, "number")),
            *(write.data[name].eq(found[name]) for name in ("altitude", "x", "y")),
            write.data.free.eq(~is_blocked),
            read.addr.eq(self.number),
        ]
        return read

    def _read(self, m, read, shift):
        """Output the block that was read; the blocks of the ends are free."""
        for end, block in ((self.start, self.start_block), (self.goal, self.goal_block)):
            m.d.sync += [block[axis].eq(end[axis] >> shift) for axis in "xy"]
        place = delay_line(m, self.number, 1, "place")
        at_start = delay_line(m, place == self.start_block.as_value(), 1, "at_start")
        at_goal = delay_line(m, place == self.goal_block.as_value(), 1, "at_goal")
        block = Signal(self.block_layout, reset_less=True)
        m.d.sync += block.eq(read.data)
        m.d.comb += self.block.eq(block)
        with m.If(~block.free & at_goal):
            m.d.comb += [self.block.free.eq(1), self.block.altitude.eq(self.goal.altitude)]
        with m.If(~block.free & at_start):
            m.d.comb += [self.block.free.eq(1), self.block.altitude.eq(self.start.altitude)]
