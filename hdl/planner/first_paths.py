"""First paths of a run: seeds, lifted paths, and members of an earlier run."""

from amaranth import *
from amaranth.lib import data, enum, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import corner_layout, frame_layout, member_layout, waypoint_layout
from pathgene.hdl.planner.population_memory import place_layout, write_layout
from pathgene.hdl.planner.wavefront.layouts import found_layout
from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.buffers import ResultQueue
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["FirstPathKind", "FirstPaths", "MemberReader"]


#: Cycles from the read of a waypoint to its output.
_STAGES = 5


class MemberReader(Unit):
    """Reads the waypoints of a path, one per cycle; lifts them, or drops those already passed.

    The first waypoint is output 6 cycles after ``begin``, and then one per cycle; a dropped
    waypoint also takes a cycle.

    With ``lifts``, a waypoint with a negative margin is raised by the missing height, up to the
    altitude limit. Otherwise the first waypoints are dropped if the start has passed them, except
    for the last two of a path: the remaining waypoints equal
    :func:`pathgene.sim.model.planner.seeds.ahead`.

    Members
    -------
    lifts : In(1)
    frame : In(frame_layout)
        Steady, like ``lifts``, while a path is read.
    begin : In(1)
        Pulse: read a path. Not before the last waypoint of the previous path.
    slot : In(range(slots))
    length : In(range(max_waypoints + 1))
        Length of the path; read with ``begin``.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` from 2 cycles before.
    found : Out(found_layout)
    """

    slots: Count(2, text="Paths in the memory.")
    max_waypoints: Count(2, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        sizes = self.coordinate_bits, self.altitude_bits
        return {
            "lifts": In(1),
            "frame": In(frame_layout(*sizes)),
            "begin": In(1),
            "slot": In(range(self.slots)),
            "length": In(range(self.max_waypoints + 1)),
            "read": Out(place_layout(self.slots, self.max_waypoints)),
            "waypoint": In(waypoint_layout(*sizes)),
            "found": Out(found_layout(*sizes)),
        }

    def elaborate(self, platform):
        m = Module()

        reading = Signal()
        slot = Signal.like(self.slot, reset_less=True)
        index = Signal.like(self.read.index, reset_less=True)
        # The last index, and the number of waypoints that may be dropped.
        last = Signal.like(index, reset_less=True)
        least = Signal.like(self.length, reset_less=True)
        with m.If(self.begin):
            m.d.sync += [
                reading.eq(1),
                slot.eq(self.slot),
                index.eq(0),
                last.eq(self.length - 1),
                least.eq(self.length - Config.MIN_WAYPOINTS),
            ]
        with m.Elif(reading):
            m.d.sync += [index.eq(index + 1), reading.eq(index != last)]
        m.d.comb += [self.read.slot.eq(slot), self.read.index.eq(index)]

        # One cycle for the memory's register, then differences, products, and their sum.
        waypoint, found = self.waypoint, self.found
        start, goal = self.frame.start, self.frame.goal
        dot = []
        for axis in "xy":
            bits = self.coordinate_bits + 1
            multiplier = Multiplier((bits, bits))
            m.submodules[f"product_{axis}"] = multiplier
            way = Signal(signed(bits), name=f"way_{axis}", reset_less=True)
            off = Signal(signed(bits), name=f"off_{axis}", reset_less=True)
            m.d.sync += [
                way.eq(goal[axis] - start[axis]),
                off.eq(waypoint[axis] - start[axis]),
            ]
            m.d.comb += [multiplier.first.eq(way), multiplier.second.eq(off)]
            dot.append(multiplier.product)
            m.d.comb += found[axis].eq(delay_line(m, waypoint[axis], 3, axis))
        is_ahead = Signal(reset_less=True)
        m.d.sync += is_ahead.eq(sum(dot) > 0)

        raised = Signal(self.altitude_bits + 1, reset_less=True)
        capped = Signal(self.altitude_bits, reset_less=True)
        raises = self.lifts & (waypoint.margin < 0)
        limit = self.frame.limits.altitude
        m.d.sync += [
            raised.eq(waypoint.altitude + Mux(raises, -waypoint.margin, 0)),
            capped.eq(Mux(self.lifts & (raised > limit), limit, raised)),
        ]

        # Flags that accompany a waypoint.
        valid = Signal(_STAGES)
        m.d.sync += valid.eq(Cat(reading, valid))
        stays = delay_line(m, self.lifts | (index >= least), _STAGES, "stays")
        started = Signal()
        keeps = stays | is_ahead | started
        with m.If(self.begin):
            m.d.sync += started.eq(0)
        with m.Elif(valid[-1] & keeps):
            m.d.sync += started.eq(1)
        m.d.comb += [
            found.valid.eq(valid[-1] & keeps),
            found.last.eq(delay_line(m, index == last, _STAGES, "last")),
            found.altitude.eq(delay_line(m, capped, 1, "altitude")),
        ]

        return m


_AXES = ("x", "y", "altitude")


class FirstPathKind(enum.Enum, shape=2):
    """Kinds of first paths."""

    #: A new path along a route, in a free slot.
    SEED = 0
    #: A member of the population, raised out of the ground, in its slot.
    LIFTED = 1
    #: A member without the waypoints that the start has passed, in its slot.
    REVIVED = 2


class FirstPaths(Unit):
    """Makes the paths of a first population one after another, and writes them.

    A path is a seed, or the member of the next rank. Its slot is output first, then its points: the
    start, the waypoints, each of which is also written, and the goal. A path begins when the goal
    of the previous path is taken. Its first point is offered a constant number of cycles later,
    plus one for each waypoint that a revived path loses; each later point is offered in the cycle
    after the previous one is taken. :mod:`pathgene.sim.model.planner.run_cycles` has the numbers.

    Members
    -------
    launch : In(1)
        Pulse: make paths. Not while ``busy``.
    kind : In(FirstPathKind)
    count : In(16)
        Number of paths to make, at least 1, and at most the number of members if paths are members.
        Read with ``launch``.
    busy : Out(1)
        High until the last goal is taken.
    frame : In(frame_layout)
        Steady, like ``kind``, while ``busy``.
    begin_seed : Out(1)
        Pulse: make a seed. Not with ``seed_busy``.
    seed_busy : In(1)
    seed : In(found_layout)
        Waypoints of the seed; the next seed is not requested before the last of them.
    free_slots : In(stream.Signature(range(slots)))
        Each seed takes one.
    rank : Out(range(population))
        Member to read. Steady while its waypoints are read.
    member : In(member_layout)
        The member at the ``rank`` of the previous cycle.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` from 2 cycles before.
    write : Out(write_layout)
        Waypoints of the paths. Registers.
    paths : Out(stream.Signature(range(slots)))
        Slot of each path, before its points.
    points : Out(stream.Signature(point_layout))
        Points of the paths, start and goal included; ``last`` marks the goal.
    """

    slots: Count(2, text="Paths in the memory.")
    population: Count(2, text="Members.")
    max_waypoints: Count(2, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        sizes = self.coordinate_bits, self.altitude_bits
        self._reader = MemberReader(self.slots, self.max_waypoints, *sizes)
        self.corner_layout = corner_layout(*sizes)
        return {
            "launch": In(1),
            "kind": In(FirstPathKind),
            "count": In(16),
            "busy": Out(1),
            "frame": In(frame_layout(*sizes)),
            "begin_seed": Out(1),
            "seed_busy": In(1),
            "seed": In(found_layout(*sizes)),
            "free_slots": In(stream.Signature(range(self.slots))),
            "rank": Out(range(self.population)),
            "member": In(
                member_layout((self.slots - 1).bit_length(), self.max_waypoints.bit_length())
            ),
            "read": Out(place_layout(self.slots, self.max_waypoints)),
            "waypoint": In(waypoint_layout(*sizes)),
            "write": Out(write_layout(self.slots, self.max_waypoints, self.corner_layout)),
            "paths": Out(stream.Signature(range(self.slots))),
            "points": Out(stream.Signature(point_layout(*sizes))),
        }

    def elaborate(self, platform):
        m = Module()

        # One of the two sources supplies all waypoints of a path while the queue sends them.
        seeds = Signal()
        word = data.StructLayout({"corner": self.corner_layout, "last": 1})
        m.submodules.reader = reader = self._reader
        m.submodules.queue = queue = ResultQueue(word, self.max_waypoints)
        source = Signal(self.seed.shape())
        m.d.comb += [
            source.eq(Mux(seeds, self.seed, reader.found)),
            seeds.eq(self.kind == FirstPathKind.SEED),
            reader.lifts.eq(self.kind == FirstPathKind.LIFTED),
            reader.frame.eq(self.frame),
            reader.slot.eq(self.member.slot),
            reader.length.eq(self.member.length),
            reader.waypoint.eq(self.waypoint),
            self.read.eq(reader.read),
            queue.put.eq(source.valid),
            queue.word.last.eq(source.last),
            *(queue.word.corner[axis].eq(source[axis]) for axis in _AXES),
        ]

        waypoints = queue.words
        point = self.points
        left = Signal(16)
        slot = Signal.like(self.paths.p, reset_less=True)
        index = Signal.like(self.write.place.index, reset_less=True)
        m.d.sync += self.write.valid.eq(0)
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [left.eq(self.count), self.rank.eq(0)]
                with m.If(self.launch):
                    m.next = "BEGIN"
            with m.State("BEGIN"):
                m.d.comb += self.begin_seed.eq(seeds & ~self.seed_busy)
                with m.If(~seeds | self.begin_seed):
                    m.next = "PATH"
            with m.State("PATH"):
                m.d.comb += [
                    self.paths.valid.eq(~seeds | self.free_slots.valid),
                    self.paths.p.eq(Mux(seeds, self.free_slots.p, self.member.slot)),
                    self.free_slots.ready.eq(seeds & self.paths.ready),
                ]
                m.d.sync += [slot.eq(self.paths.p), index.eq(0)]
                with m.If(self.paths.valid & self.paths.ready):
                    m.d.comb += reader.begin.eq(~seeds)
                    m.next = "START"
            with m.State("START"):
                m.d.comb += [
                    point.valid.eq(waypoints.valid),
                    *(point.p[axis].eq(self.frame.start[axis]) for axis in _AXES),
                ]
                with m.If(point.valid & point.ready):
                    m.next = "WAYPOINTS"
            with m.State("WAYPOINTS"):
                m.d.comb += [
                    point.valid.eq(waypoints.valid),
                    waypoints.ready.eq(point.ready),
                    *(point.p[axis].eq(waypoints.p.corner[axis]) for axis in _AXES),
                ]
                with m.If(point.valid & point.ready):
                    m.d.sync += [self.write.valid.eq(1), index.eq(index + 1)]
                    with m.If(waypoints.p.last):
                        m.next = "GOAL"
            with m.State("GOAL"):
                m.d.comb += [
                    point.valid.eq(1),
                    point.p.last.eq(1),
                    *(point.p[axis].eq(self.frame.goal[axis]) for axis in _AXES),
                ]
                with m.If(point.ready):
                    m.d.sync += [left.eq(left - 1), self.rank.eq(self.rank + 1)]
                    m.next = "BEGIN"
                    with m.If(left == 1):
                        m.next = "IDLE"
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))
        m.d.sync += [
            self.write.place.slot.eq(slot),
            self.write.place.index.eq(index),
            self.write.waypoint.eq(waypoints.p.corner),
        ]

        return m
