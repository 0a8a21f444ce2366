"""Builder of children: makes the points and waypoints of a child from its plan."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.mutator import within
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.child_planner import plan_layout
from pathgene.hdl.planner.layouts import corner_layout, frame_layout, waypoint_layout
from pathgene.hdl.planner.population_memory import place_layout, write_layout
from pathgene.hdl.primitives.buffers import ResultQueue
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["ChildBuilder"]

#: Points offered or in flight. Nine are enough for one to be taken in each cycle.
_POINTS = 16
#: Cycles from the step of a point to its entry into the queue.
_STAGES = 7
_AXES = ("x", "y", "altitude")


class ChildBuilder(Unit):
    """Reads the waypoints of a child's parents, mutates one of them, and writes the child.

    Each cycle makes one point: the start, the child's waypoints, the goal. A child of ``n``
    waypoints takes ``n + 2`` cycles while points are taken, and the next child follows without a
    gap. A point is offered 8 cycles after its cycle, and a waypoint is written one cycle earlier;
    the first cycle of a child follows the one in which its plan is taken. A plan waits for a free
    slot and for ``children``.

    A moved waypoint stays within the limits of the frame, and its margin is 0. An inserted
    waypoint, which is moved from the midpoint of its neighbours, and a settled waypoint also have a
    margin of 0. All other waypoints keep their margins. Equals the waypoints of ``cross`` and
    ``mutate`` of :mod:`pathgene.sim.model.planner.breeder`.

    Members
    -------
    plans : In(stream.Signature(plan_layout))
    slots : In(stream.Signature(range(slot_count)))
        Free slots; each child takes one.
    frame : In(frame_layout)
        Steady.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` from 2 cycles before.
    write : Out(write_layout)
        Waypoints of the child. Registers.
    children : Out(stream.Signature(range(slot_count)))
        Slot of each child, offered with the plan and taken with it.
    points : Out(stream.Signature(point_layout))
        ``last`` marks the goal.
    """

    slot_count: Count(2, text="Paths in the memory.", name="Slots")
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    box_cells: Count(1, text="Maximum gain of a moved waypoint in x and in y.", name="Box width")
    box_steps: Count(1, text="Maximum gain of a moved waypoint in altitude.", name="Box height")

    def interface(self):
        slot_bits = (self.slot_count - 1).bit_length()
        self.plan_layout = plan_layout(
            slot_bits, self.max_waypoints, self.box_cells, self.box_steps
        )
        self.corner_layout = corner_layout(self.coordinate_bits, self.altitude_bits)
        self.waypoint_layout = waypoint_layout(self.coordinate_bits, self.altitude_bits)
        self.point_layout = point_layout(self.coordinate_bits, self.altitude_bits)
        self.place_layout = place_layout(self.slot_count, self.max_waypoints)
        self._step_layout = data.StructLayout(
            {
                "is_start": 1,
                "is_goal": 1,
                "is_last": 1,
                "inserted": 1,
                "moved": 1,
                "settled": 1,
                "place": self.place_layout,
            }
        )
        return {
            "plans": In(stream.Signature(self.plan_layout)),
            "slots": In(stream.Signature(range(self.slot_count))),
            "frame": In(frame_layout(self.coordinate_bits, self.altitude_bits)),
            "read": Out(self.place_layout),
            "waypoint": In(self.waypoint_layout),
            "write": Out(write_layout(self.slot_count, self.max_waypoints, self.waypoint_layout)),
            "children": Out(stream.Signature(range(self.slot_count))),
            "points": Out(stream.Signature(self.point_layout)),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.queue = queue = ResultQueue(self.point_layout, _POINTS)
        room = Signal(range(_POINTS + 1), init=_POINTS)
        has_room = Signal(init=1)
        makes = Signal()
        step = Signal(self._step_layout)
        plan = self._step(m, makes, step, has_room)
        frees = self.points.valid & self.points.ready
        m.d.sync += [
            room.eq(room + frees - makes),
            has_room.eq(frees | (room > 1) | (has_room & ~makes)),
        ]

        # Facts that accompany a point through all stages, by the number of cycles since its step.
        valid = [makes]
        steps = [step]
        for stage in range(1, _STAGES):
            valid.append(Signal(name=f"valid_{stage}"))
            steps.append(Signal(step.shape(), name=f"step_{stage}", reset_less=True))
            m.d.sync += [valid[-1].eq(valid[-2]), steps[-1].eq(steps[-2])]

        self._mutate(m, plan, valid, steps)

        last = Signal(reset_less=True)
        put = Signal()
        m.d.sync += [
            put.eq(valid[-1]),
            last.eq(steps[-1].is_last),
            self.write.valid.eq(valid[-1] & ~steps[-1].is_start & ~steps[-1].is_last),
            self.write.place.eq(steps[-1].place),
        ]
        m.d.comb += [
            queue.put.eq(put),
            queue.word.last.eq(last),
            *(queue.word[axis].eq(self.write.waypoint[axis]) for axis in _AXES),
            self.points.valid.eq(queue.words.valid),
            self.points.p.eq(queue.words.p),
            queue.words.ready.eq(self.points.ready),
        ]

        return m

    def _step(self, m, makes, step, has_room):
        """Make one step of a point per cycle; return the plan."""
        plan = Signal(self.plan_layout, reset_less=True)
        slot = Signal(self.place_layout["slot"].shape, reset_less=True)
        building = Signal()
        takes = Signal()
        ends = Signal()
        # The number of the point in the child before its mutation, start and goal included; the
        # index of the waypoint in the child; and comparisons of the number, made one step ahead.
        number = Signal(range(self.max_waypoints + 2))
        index = Signal(range(self.max_waypoints), reset_less=True)
        at_place, is_start, is_goal = (
            Signal(name=name, reset_less=True) for name in ("at_place", "is_start", "is_goal")
        )
        # The previous step inserted a waypoint.
        inserted = Signal()
        is_next = Signal()
        skips = Signal()
        m.d.comb += [
            takes.eq(self.plans.valid & self.slots.valid & (~building | ends)),
            self.children.valid.eq(takes),
            self.plans.ready.eq(takes & self.children.ready),
            self.slots.ready.eq(takes & self.children.ready),
            self.children.p.eq(self.slots.p),
            makes.eq(building & has_room),
            ends.eq(makes & step.is_last),
            is_next.eq(number + 1 == plan.place),
            skips.eq(plan.deletes & is_next),
            step.is_start.eq(is_start),
            step.is_goal.eq(is_goal),
            step.is_last.eq(step.is_goal & ~step.inserted),
            step.inserted.eq(at_place & plan.inserts & ~inserted),
            step.settled.eq(at_place & plan.settles),
            step.moved.eq(
                step.inserted | (at_place & ~plan.inserts & ~plan.deletes & ~plan.settles)
            ),
            step.place.slot.eq(slot),
            step.place.index.eq(index),
        ]
        with m.If(makes):
            m.d.sync += [
                inserted.eq(step.inserted),
                index.eq(Mux(step.is_start, 0, index + 1)),
            ]
            with m.If(~step.inserted):
                m.d.sync += [
                    number.eq(number + 1 + skips),
                    at_place.eq(is_next & ~plan.deletes),
                    is_start.eq(0),
                    is_goal.eq(number == plan.length - skips),
                ]
        with m.If(ends):
            m.d.sync += building.eq(0)
        with m.If(takes & self.children.ready):
            m.d.sync += [
                building.eq(1),
                plan.eq(self.plans.p),
                slot.eq(self.slots.p),
                number.eq(0),
                at_place.eq(0),
                is_start.eq(1),
                is_goal.eq(0),
            ]

        # The place of the waypoint, if the point is one.
        is_head = Signal()
        m.d.comb += is_head.eq(number <= plan.head)
        m.d.sync += [
            self.read.slot.eq(Mux(is_head, plan.head_slot, plan.tail_slot)),
            self.read.index.eq(number - 1 + Mux(is_head, 0, plan.tail_gain)),
        ]
        return plan

    def _mutate(self, m, plan, valid, steps):
        """Mutate the points in their stages; the last stage is in the registers of ``write``."""
        # Step 3: the word from the memory. Step 4: the point, the point before it, and the child's
        # move. The plan may already belong to the next child by then. A child has at least four
        # steps, so in step 3 of its start the plan is still its own.
        point = Signal(self.waypoint_layout, reset_less=True)
        before = Signal(self.corner_layout, reset_less=True)
        move = Signal(self.plan_layout["move"].shape, reset_less=True)
        doubles = Signal(self.plan_layout["doubles"].shape, reset_less=True)
        m.d.sync += point.margin.eq(self.waypoint.margin)
        for axis in _AXES:
            m.d.sync += point[axis].eq(
                Mux(
                    steps[3].is_start,
                    self.frame.start[axis],
                    Mux(steps[3].is_goal, self.frame.goal[axis], self.waypoint[axis]),
                )
            )
        with m.If(valid[3] & steps[3].is_start):
            m.d.sync += [move.eq(plan.move), doubles.eq(plan.doubles)]
        with m.If(valid[4]):
            m.d.sync += [before[axis].eq(point[axis]) for axis in _AXES]

        # Step 5: the position from which the waypoint moves, and the distance.
        margin = Signal(self.waypoint_layout["margin"].shape, reset_less=True)
        fall = Signal(signed(len(margin) + 1))
        m.d.sync += margin.eq(point.margin)
        with m.If(point.margin < 0):
            m.d.comb += fall.eq(point.margin)
        with m.Else():
            m.d.comb += fall.eq((point.margin << doubles) >> 1)
        # Step 6: the position to which it moves, before clamping.
        for axis in _AXES:
            base = Signal(len(point[axis]), name=f"base_{axis}", reset_less=True)
            middle = (before[axis] + point[axis]) >> 1
            m.d.sync += base.eq(Mux(steps[4].inserted, middle, point[axis]))
            moved = Mux(steps[4].moved, move[axis], 0)
            if axis == "altitude":
                moved = Mux(steps[4].settled, -fall, moved)
            gain = Signal(moved.shape(), name=f"gain_{axis}", reset_less=True)
            far = Signal((base + gain).shape(), name=f"far_{axis}", reset_less=True)
            limited = steps[6].moved | (steps[6].settled if axis == "altitude" else 0)
            m.d.sync += [
                gain.eq(moved),
                far.eq(base + gain),
                self.write.waypoint[axis].eq(
                    Mux(limited, within(m, far, self.frame.limits[axis]), far)
                ),
            ]
        margin_held = delay_line(m, margin, 1, "margin_held")
        m.d.sync += self.write.waypoint.margin.eq(
            Mux(steps[6].moved | steps[6].settled, 0, margin_held)
        )
