"""Memory of the waypoints of all populations, and the pool of its free slots."""

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.layouts import waypoint_layout
from pathgene.hdl.primitives.buffers import MemoryQueue
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = [
    "PopulationMemory",
    "SlotPool",
    "decided_layout",
    "margin_layout",
    "place_layout",
    "write_layout",
]


class SlotPool(Unit):
    """Hands out free slots: unused slots first, then returned slots, oldest first.

    After ``clear``, all slots are unused and are handed out starting with 0, so no slot has to be
    written initially. A returned slot is handed out as late as possible, and may be read until
    then. A slot is offered 2 cycles after the previous one is taken, and at least 2 cycles after it
    is put back.

    Members
    -------
    clear : In(1)
        Make all slots unused. Overrides the rest.
    put : In(1)
        Put ``slot`` back.
    slot : In(range(total))
    slots : Out(stream.Signature(range(total)))
        Free slots, to be taken.
    """

    total: Count(2, name="Slots")
    depth: Count(
        1, text="Maximum number of slots that have been put back and not handed out again."
    )

    def interface(self):
        return {
            "clear": In(1),
            "put": In(1),
            "slot": In(range(self.total)),
            "slots": Out(stream.Signature(range(self.total))),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.queue = queue = MemoryQueue(self.slot.shape(), self.depth)
        # All slots from this number on are unused.
        unused = Signal(range(self.total + 1))
        is_unused = Signal()
        offered = Signal(self.slot.shape(), reset_less=True)
        m.d.comb += [
            self.slots.p.eq(offered),
            queue.clear.eq(self.clear),
            queue.put.eq(self.put),
            queue.word.eq(self.slot),
            is_unused.eq(unused != self.total),
            # `ready` arrives late, so the next slot follows one cycle later.
            queue.words.ready.eq(~self.slots.valid & ~is_unused),
        ]
        with m.If(self.slots.ready):
            m.d.sync += self.slots.valid.eq(0)
        with m.If(~self.slots.valid):
            m.d.sync += [
                self.slots.valid.eq(is_unused | queue.words.valid),
                offered.eq(Mux(is_unused, unused, queue.words.p)),
            ]
            with m.If(is_unused):
                m.d.sync += unused.eq(unused + 1)
        with m.If(self.clear):
            m.d.sync += [self.slots.valid.eq(0), unused.eq(0)]

        return m


class PopulationMemory(Unit):
    """Waypoints by slot and place, each with its valid margin.

    A waypoint is written with the margin that it inherits. The margins found by the walk of a path
    go to a separate memory. One flag per slot selects walked or inherited margins. Therefore writes
    of waypoints and of margins never wait for each other.

    A row must not be read in the cycle in which it is written. The flag of a slot and its walked
    margins are only written while the slot is not read: while its path is being evaluated, after
    the last read of the previous path and before the path's key is known. A walked path gets the
    margins of all its waypoints.

    A slot has a power of two of rows for its first waypoints; rows for the remaining waypoints
    follow after the first rows of all slots. In this way 108 slots of 24 waypoints take 2,912 rows
    instead of 3,456, 32 each.

    Each of the two memories has one write port and one read port, as in block RAMs: on an ECP5,
    with 108 slots of 18 waypoints, corners of 9 bits and altitudes of 11 or 12, five for waypoints
    and two for margins. Flags are LUT RAM.

    Attributes
    ----------
    depth : int
        Rows of each of the two memories.

    Members
    -------
    read : In(place_layout)
        ``slot`` and ``index`` of a waypoint. Read in every cycle.
    waypoint : Out(waypoint_layout)
        The waypoint there, 2 cycles later. A register.
    write : In(write_layout)
        ``valid``: write ``waypoint`` to ``place``, with the margin that it inherits.
    decided : In(decided_layout)
        ``valid``: ``slot`` uses walked margins if its path is ``walked``, otherwise inherited
        margins.
    margin : In(margin_layout)
        ``valid``: the walk of a path finds this ``margin`` at ``place``.
    """

    slots: Count(2, text="Paths in the memory.")
    max_waypoints: Count(2, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        self._rows = _Rows(self.slots, self.max_waypoints)
        self.depth = self._rows.depth
        self.waypoint_layout = waypoint_layout(self.coordinate_bits, self.altitude_bits)
        self.place_layout = place_layout(self.slots, self.max_waypoints)
        self.write_layout = write_layout(self.slots, self.max_waypoints, self.waypoint_layout)
        self.decided_layout = decided_layout(self.slots)
        self.margin_layout = margin_layout(self.slots, self.max_waypoints, self.altitude_bits)
        return {
            "read": In(self.place_layout),
            "waypoint": Out(self.waypoint_layout),
            "write": In(self.write_layout),
            "decided": In(self.decided_layout),
            "margin": In(self.margin_layout),
        }

    def elaborate(self, platform):
        m = Module()

        rows = self._rows

        def memory_of(name, shape, write, word):
            """Return the contents of the place read in the previous cycle."""
            m.submodules[name] = held = memory.Memory(
                shape=shape, depth=rows.depth, init=[], attrs={"no_rw_check": 1}
            )
            write_port, read_port = held.write_port(), held.read_port()
            m.d.comb += [
                write_port.en.eq(write.valid),
                write_port.addr.eq(rows.row_of(write.place)),
                write_port.data.eq(word),
                read_port.addr.eq(rows.row_of(self.read)),
            ]
            return read_port.data

        waypoint = Signal(self.waypoint_layout, reset_less=True)
        held = memory_of("waypoints", waypoint.shape(), self.write, self.write.waypoint)
        found = memory_of("margins", waypoint.margin.shape(), self.margin, self.margin.margin)

        m.submodules.flags = flags = memory.Memory(shape=1, depth=self.slots, init=[])
        flag_write, flag_read = flags.write_port(), flags.read_port(domain="comb")
        was_walked = Signal(reset_less=True)
        m.d.comb += [
            flag_write.en.eq(self.decided.valid),
            flag_write.addr.eq(self.decided.slot),
            flag_write.data.eq(self.decided.walked),
            flag_read.addr.eq(self.read.slot),
        ]
        m.d.sync += was_walked.eq(flag_read.data)

        m.d.comb += self.waypoint.eq(waypoint)
        m.d.sync += waypoint.eq(held)
        with m.If(was_walked):
            m.d.sync += waypoint.margin.eq(found)

        return m


class _Rows:
    """Rows of the waypoints of all slots: a power of two per slot, then the rest of each slot.

    The rest also has a power of two of rows per slot. It begins at a row whose number consists of a
    constant above slot and index, so that no row number needs an addition. If that does not save
    rows, a slot has rows for all its waypoints together.

    Parameters
    ----------
    slots, max_waypoints : int

    Attributes
    ----------
    depth : int
        Rows of the memory.
    """

    def __init__(self, slots, max_waypoints):
        all_bits = (max_waypoints - 1).bit_length()
        rest = max_waypoints - (1 << all_bits - 1)
        rest_bits = (rest - 1).bit_length()
        block = 1 << (slots - 1).bit_length() + rest_bits
        first_block = -(-(slots << all_bits - 1) // block)
        depth = first_block * block + (slots << rest_bits)
        self._is_cut = depth < slots << all_bits
        self._index_bits = all_bits - self._is_cut
        self._rest_bits, self._first_block = rest_bits, first_block
        self.depth = depth if self._is_cut else slots << all_bits

    def row_of(self, place):
        """Return the row of the waypoint at ``place``."""
        index = place.index
        row = Cat(index[: self._index_bits], place.slot)
        if not self._is_cut:
            return row
        return Mux(
            index[self._index_bits],
            Cat(index[: self._rest_bits], place.slot, Const(self._first_block)),
            row,
        )


def place_layout(slots, max_waypoints):
    """Return the layout of the place of a waypoint: its path's slot, and its index there."""
    return data.StructLayout({"slot": range(slots), "index": range(max_waypoints)})


def decided_layout(slots):
    """Return the layout of a decision on the path in a slot: whether it is ``walked``."""
    return data.StructLayout({"valid": 1, "slot": range(slots), "walked": 1})


def margin_layout(slots, max_waypoints, altitude_bits):
    """Return the layout of a margin and the place of its waypoint."""
    place = place_layout(slots, max_waypoints)
    return data.StructLayout({"valid": 1, "place": place, "margin": signed(altitude_bits + 1)})


def write_layout(slots, max_waypoints, waypoint):
    """Return the layout of a write of a ``waypoint`` to a place."""
    return data.StructLayout(
        {"valid": 1, "place": place_layout(slots, max_waypoints), "waypoint": waypoint}
    )
