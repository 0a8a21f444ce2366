"""Reader of the members with which the next run begins."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.planner.population_layouts import frame_layout, waypoint_layout
from pathgene.hdl.planner.population_memory import place_layout
from pathgene.hdl.planner.wavefront.layouts import found_layout
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.multiplier import Multiplier
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["MemberReader"]

#: Cycles from the read of a waypoint to the waypoint itself, as it leaves.
_STAGES = 5


class MemberReader(Unit):
    """Reads the waypoints of a path, one per cycle; lifts them, or drops passed ones.

    The first waypoint is given 6 cycles after ``begin``, each further one a cycle after the
    previous one; a dropped one takes a cycle.

    With ``lifts``, a waypoint with a negative margin is raised by it, up to the limit of altitudes.
    Otherwise the first waypoints are dropped if the start has passed them, except the last two of a
    path: the remaining waypoints equal :func:`pathgene.sim.model.planner.warm.ahead`.

    Members
    -------
    lifts : In(1)
    frame : In(frame_layout)
        Steady, like ``lifts``, while a path is read.
    begin : In(1)
        Pulse: read a path. After the last waypoint of the previous one.
    slot : In(range(slots))
    length : In(range(max_waypoints + 1))
        Length of the path; read with ``begin``.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` of 2 cycles before.
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

        # A cycle for the memory's register, then differences, products, and their sum.
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

        # Flags that go with a waypoint.
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
