"""Breeder of the children of a generation, one after another."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.ga_core.distinct_draw import DistinctDraw
from pathgene.hdl.planner.child_builder import ChildBuilder
from pathgene.hdl.planner.child_planner import ChildPlanner, ParentDraw
from pathgene.hdl.planner.layouts import path_layout, slot_count
from pathgene.hdl.primitives.buffers import MemoryQueue
from pathgene.hdl.primitives.unit import Count, InstanceOf, Unit
from pathgene.hdl.protocol.breeding import SURVIVOR_BITS
from pathgene.hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["Breeder"]


class Breeder(Unit):
    """Plans the children of a generation at a constant rate, and builds them as they are taken.

    Planning draws parents, mutations and survivors; each child uses one step of the random source,
    in order. The plan of child j, counted from 0, is ready for the builder 13 + 8 j cycles after
    ``begin``. All n children are planned after 8 n + 5 cycles, when ``planning`` falls. Plans of
    two generations fit into the queue. Children are built in order, as slots, children and points
    are taken: see :class:`pathgene.hdl.planner.child_builder.ChildBuilder`. Equals
    :func:`pathgene.sim.model.planner.breeder.breed`.

    Members
    -------
    begin : In(1)
        Pulse: breed a generation. Only while ``planning`` is low, and after all children of the
        second-last generation have been taken.
    words : In(stream.Signature(data.ArrayLayout(64, 2)))
        Steps of the random source: selection word, mutation word. Planning waits while there is
        none.
    rank : Out(config.slot_bits)
        While ``planning``: member of the population to read.
    parent : In(parent_layout)
        Slot and length of the member at the previous cycle's ``rank``.
    planning : Out(1)
        Not all children are planned yet.
    parity : Out(1)
        Changes with each generation, in the cycle after ``begin``.
    survivors : Out(data.ArrayLayout(config.slot_bits, config.survivors))
        Ranks of the survivors in the order drawn; valid from the end of ``planning`` to ``begin``.
    slots : In(stream.Signature(range(slot_count)))
        Free slots, one for each child.
    frame : In(frame_layout)
        Maximum corner and altitude of a waypoint, and the common ends of all paths. Steady.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` from 2 cycles before.
    write : Out(write_layout)
        Waypoints of the children.
    children : Out(stream.Signature(child_layout))
        Slot of each child, and the ``parity`` of its generation, at least 9 cycles before its first
        point.
    points : Out(stream.Signature(point_layout))
        Points of the children, start and goal included; ``last`` marks the goal.
    """

    config: InstanceOf(Config)
    islands: Count(1, text="Islands whose populations have slots.")

    def interface(self):
        config = self.config
        self.slot_count = slot_count(config, self.islands)
        self.builder = ChildBuilder(
            self.slot_count,
            config.max_waypoints,
            config.coordinate_bits,
            config.altitude_bits,
            config.box_cells,
            config.box_steps,
        )
        slot_bits = (self.slot_count - 1).bit_length()
        self.parent_layout = path_layout(slot_bits, config.length_bits)
        self.child_layout = data.StructLayout({"slot": slot_bits, "parity": 1})
        passed = self.builder.signature.members
        return {
            "begin": In(1),
            "words": In(stream.Signature(data.ArrayLayout(WORD_BITS, LANES))),
            "rank": Out(config.slot_bits),
            "parent": In(self.parent_layout),
            "planning": Out(1),
            "parity": Out(1),
            "survivors": Out(data.ArrayLayout(config.slot_bits, config.survivors)),
            **{name: passed[name] for name in _PASSED},
            "children": Out(stream.Signature(self.child_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.draw = draw = ParentDraw(config.slot_bits)
        m.submodules.planner = planner = ChildPlanner(
            config.slot_bits,
            self.parent_layout["slot"].width,
            config.max_waypoints,
            config.box_cells,
            config.box_steps,
        )
        queued_layout = data.StructLayout({"plan": planner.plan_layout, "parity": 1})
        m.submodules.plans = plans = MemoryQueue(queued_layout, 2 * config.children)
        m.submodules.builder = builder = self.builder
        connect(m, flipped(self.words), draw.words)
        connect(m, draw.draws, planner.draws)
        for name in ("slots", "points"):
            connect(m, flipped(getattr(self, name)), getattr(builder, name))
        m.d.comb += [
            self.rank.eq(planner.rank),
            planner.parent.eq(self.parent),
            planner.plans.ready.eq(1),
            plans.put.eq(planner.plans.valid),
            plans.word.plan.eq(planner.plans.p),
            plans.word.parity.eq(self.parity),
            builder.plans.valid.eq(plans.words.valid),
            builder.plans.p.eq(plans.words.p.plan),
            plans.words.ready.eq(builder.plans.ready),
            self.children.valid.eq(builder.children.valid),
            self.children.p.slot.eq(builder.children.p),
            self.children.p.parity.eq(plans.words.p.parity),
            builder.children.ready.eq(self.children.ready),
            *(getattr(builder, name).eq(getattr(self, name)) for name in ("frame", "waypoint")),
            self.read.eq(builder.read),
            self.write.eq(builder.write),
        ]

        # Number of children whose words have been taken, and whose plans have been taken.
        drawn = Signal(range(config.children))
        planned = Signal(range(config.children))
        drawing = Signal()
        with m.If(draw.words.valid & draw.words.ready):
            m.d.sync += [drawn.eq(drawn + 1), drawing.eq(drawn != config.children - 1)]
        with m.If(planner.plans.valid):
            m.d.sync += [planned.eq(planned + 1), self.planning.eq(planned != config.children - 1)]
        with m.If(self.begin):
            m.d.sync += [drawn.eq(0), planned.eq(0), drawing.eq(1), self.planning.eq(1)]
            m.d.sync += self.parity.eq(~self.parity)
        m.d.comb += draw.on.eq(drawing)

        m.submodules.survivor_draw = survivor_draw = DistinctDraw(
            total=config.population - config.elites,
            count=config.survivors,
            draw_bits=SURVIVOR_BITS,
            first=config.elites,
            multiplies=True,
        )
        survives = Signal()
        m.d.sync += survives.eq(drawn < config.survivors)
        m.d.comb += [
            survivor_draw.clear.eq(self.begin),
            survivor_draw.take.eq(draw.survivor.valid & survives),
            survivor_draw.bits[0].eq(draw.survivor.bits),
            self.survivors.eq(survivor_draw.numbers),
        ]

        return m


#: Members that are passed on to the builder.
_PASSED = (
    "slots",
    "frame",
    "read",
    "waypoint",
    "write",
    "points",
)
