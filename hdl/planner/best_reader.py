"""Reader of the best paths of a run."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import record_layout
from pathgene.hdl.planner.layouts import member_layout, waypoint_layout
from pathgene.hdl.planner.population_memory import place_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol.runs import RETURNED


__all__ = ["BestReader"]

_KEY_BYTES = 4


class BestReader(Unit):
    """Sends paths with distinct keys as bytes, best first.

    The format is :func:`pathgene.hdl.protocol.runs.pack_best`: the key of each path, then its
    waypoints. Members are read in the order of their ranks, so members with equal keys are
    adjacent, and only the first of them is sent. Bytes are sent in consecutive cycles, except for
    one cycle before each key, 3 before each waypoint, 5 for each member read after the first, and 2
    more.

    Members
    -------
    count : In(range(9))
        Maximum number of paths to send, 1..8. Steady while ``busy``.
    best : In(1)
        Pulse: send the paths. Not while ``busy``.
    busy : Out(1)
        High until the last byte is taken.
    rank : Out(range(population))
        Member to read; 0 while not ``busy``.
    member : In(member_layout)
        The member at the ``rank`` of the previous cycle.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` from 2 cycles before.
    records : Out(stream.Signature(record_layout))
        ``last`` ends the paths.
    """

    slots: Count(2, text="Paths in the memory.")
    population: Count(2, text="Members.")
    max_waypoints: Count(2, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        member = member_layout((self.slots - 1).bit_length(), self.max_waypoints.bit_length())
        return {
            "count": In(range(RETURNED + 1)),
            "best": In(1),
            "busy": Out(1),
            "rank": Out(range(self.population)),
            "member": In(member),
            "read": Out(place_layout(self.slots, self.max_waypoints)),
            "waypoint": In(waypoint_layout(self.coordinate_bits, self.altitude_bits)),
            "records": Out(stream.Signature(record_layout)),
        }

    def elaborate(self, platform):
        m = Module()

        # The path to be sent next, whether it is the last one, and the number of paths sent before.
        path = Signal(self.member.shape(), reset_less=True)
        is_final = Signal()
        sent = Signal(range(RETURNED))
        last_rank = self.rank == self.population - 1
        # A key or a waypoint, and the number of its bytes after the one being offered.
        waypoint_bits = 2 * self.coordinate_bits + self.altitude_bits + 1
        waypoint_bytes = (waypoint_bits + 7) // 8
        most = max(_KEY_BYTES, waypoint_bytes)
        word = Signal(8 * most, reset_less=True)
        left = Signal(range(most), reset_less=True)
        index = Signal(range(self.max_waypoints), reset_less=True)
        is_key, ends = Signal(), Signal()
        last_index = Signal.like(index)  # Steady when the first waypoint is sent.
        m.d.sync += last_index.eq(path.length - 1)
        m.d.comb += [
            self.read.slot.eq(path.slot),
            self.read.index.eq(index),
            ends.eq(index == last_index),
            self.records.p.data.eq(word[:8]),
        ]

        key, differs = Signal.like(self.member.key, reset_less=True), Signal(reset_less=True)
        m.d.sync += [key.eq(self.member.key), differs.eq(key != path.key)]
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [sent.eq(0), is_final.eq(0)]
                with m.If(self.best):
                    m.next = "FIRST"
            with m.State("FIRST"):
                m.d.sync += path.eq(self.member)
                m.next = "SEEK"

            # Find the next member with a different key, which decides whether the path is the last
            # one.
            with m.State("SEEK"):
                m.d.sync += [self.rank.eq(self.rank + 1), is_final.eq(last_rank)]
                m.next = "READ"
                with m.If(last_rank | (sent == self.count - 1)):
                    m.d.sync += [self.rank.eq(self.rank), is_final.eq(1)]
                    m.next = "KEY"
            with m.State("READ"):
                m.next = "HOLD"
            with m.State("HOLD"):
                m.next = "COMPARE"
            with m.State("COMPARE"):
                m.next = "DECIDE"
            with m.State("DECIDE"):
                m.next = "SEEK"
                with m.If(differs):
                    m.next = "KEY"

            with m.State("KEY"):
                m.d.sync += [word.eq(path.key), left.eq(_KEY_BYTES - 1), is_key.eq(1), index.eq(0)]
                m.next = "SEND"
            with m.State("SEND"):
                m.d.comb += [
                    self.records.valid.eq(1),
                    self.records.p.last.eq(is_final & ends & ~is_key & (left == 0)),
                ]
                with m.If(self.records.ready):
                    m.d.sync += [word.eq(word >> 8), left.eq(left - 1)]
                    with m.If(left == 0):
                        m.d.sync += is_key.eq(0)
                        m.next = "PLACE"
                        with m.If(~is_key):
                            m.d.sync += index.eq(index + 1)
                            with m.If(ends):
                                m.d.sync += [path.eq(self.member), sent.eq(sent + 1)]
                                m.next = "SEEK"
                                with m.If(is_final):
                                    m.d.sync += self.rank.eq(0)
                                    m.next = "IDLE"
            with m.State("PLACE"):
                m.next = "FETCH"
            with m.State("FETCH"):
                m.next = "WORD"
            with m.State("WORD"):
                axes = (self.waypoint[axis] for axis in ("x", "y", "altitude"))
                m.d.sync += [word.eq(Cat(*axes, ends)), left.eq(waypoint_bytes - 1)]
                m.next = "SEND"
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))

        return m
