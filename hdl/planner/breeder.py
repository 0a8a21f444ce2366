"""Breeder: the children of a generation, one after another."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.ga_core.distinct_draw import DistinctDraw
from hdl.planner.child_builder import ChildBuilder
from hdl.planner.child_planner import ChildPlanner
from hdl.planner.parent_draw import SURVIVOR_BITS, ParentDraw
from hdl.planner.population_layouts import slot_count
from hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["Breeder"]


class Breeder(wiring.Component):
    """Breeds the children of a generation and draws its survivors.

    Each child takes a step of the random source, in order. Draw, plan and points of consecutive
    children overlap: a child of ``n`` waypoints takes ``n + 2`` cycles, or 8 if that is more, while
    points, children and slots are taken and given at once. The first point is offered 21 cycles
    after ``begin`` at the earliest. Equals
    :func:`sim.model.planner.definition.breeder.breed`.

    Parameters
    ----------
    config : Config
    islands : int
        Islands whose populations have slots, 1 or more.

    Members
    -------
    begin : In(1)
        Pulse: breed a generation. Only while ``planning`` and ``building`` are low.
    words : In(stream.Signature(data.ArrayLayout(64, 2)))
        Steps of the random source: selection word, mutation word.
    rank : Out(config.slot_bits)
        Member of the population to be read.
    reads : Out(1)
        Read it. Stays until ``readable``.
    readable : In(1)
        It is read in this cycle.
    parent : In(child_layout)
        Slot and length of the member read last, from the cycle after on.
    planning : Out(1)
        Not all children are planned. Members are read only then.
    survivors : Out(data.ArrayLayout(config.slot_bits, config.survivors))
        Ranks of the survivors, in the order drawn, from the end of ``planning`` to ``begin``.
    slots : In(stream.Signature(range(slot_count)))
        Free slots, one for each child.
    limits, start, goal : In(corner_layout)
        Greatest corner and altitude of a waypoint, and the ends of all paths. Steady.
    read : Out(place_layout)
    waypoint : In(waypoint_layout)
        Contents of ``read`` of 2 cycles before.
    write : Out(write_layout)
        Waypoints of the children.
    children : Out(stream.Signature(child_layout))
        Slot and length of each child, before its points.
    points : Out(stream.Signature(point_layout))
        Points of the children, start and goal included; ``last`` marks the goal.
    building : Out(1)
        Waypoints are still to be written.
    """

    def __init__(self, config, islands):
        self.config = config
        self.islands = islands
        self.slot_count = slot_count(config, islands)
        self.builder = ChildBuilder(
            self.slot_count,
            config.max_waypoints,
            config.coordinate_bits,
            config.altitude_bits,
            config.box_cells,
            config.box_steps,
        )
        self.child_layout = self.builder.child_layout
        passed = self.builder.signature.members
        super().__init__(
            {
                "begin": In(1),
                "words": In(stream.Signature(data.ArrayLayout(WORD_BITS, LANES))),
                "rank": Out(config.slot_bits),
                "reads": Out(1),
                "readable": In(1),
                "parent": In(self.child_layout),
                "planning": Out(1),
                "survivors": Out(data.ArrayLayout(config.slot_bits, config.survivors)),
                **{name: passed[name] for name in _PASSED},
                "building": Out(1),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.draw = draw = ParentDraw(config.slot_bits)
        m.submodules.planner = planner = ChildPlanner(
            config.slot_bits,
            self.child_layout["slot"].width,
            config.max_waypoints,
            config.box_cells,
            config.box_steps,
        )
        m.submodules.builder = builder = self.builder
        connect(m, flipped(self.words), draw.words)
        connect(m, draw.draws, planner.draws)
        connect(m, planner.plans, builder.plans)
        for name in ("slots", "children", "points"):
            connect(m, flipped(getattr(self, name)), getattr(builder, name))
        m.d.comb += [
            self.rank.eq(planner.rank),
            self.reads.eq(planner.reads),
            planner.readable.eq(self.readable),
            planner.parent.eq(self.parent),
            *(
                getattr(builder, name).eq(getattr(self, name))
                for name in ("limits", "start", "goal", "waypoint")
            ),
            self.read.eq(builder.read),
            self.write.eq(builder.write),
            self.building.eq(builder.busy),
        ]

        # Children whose words are taken, and whose plans are.
        drawn = Signal(range(config.children))
        planned = Signal(range(config.children))
        drawing = Signal()
        with m.If(draw.words.valid & draw.words.ready):
            m.d.sync += [drawn.eq(drawn + 1), drawing.eq(drawn != config.children - 1)]
        with m.If(planner.plans.valid & planner.plans.ready):
            m.d.sync += [planned.eq(planned + 1), self.planning.eq(planned != config.children - 1)]
        with m.If(self.begin):
            m.d.sync += [drawn.eq(0), planned.eq(0), drawing.eq(1), self.planning.eq(1)]
        m.d.comb += draw.on.eq(drawing)

        m.submodules.survivor_draw = survivor_draw = DistinctDraw(
            total=config.population - config.elites,
            count=config.survivors,
            draw_bits=SURVIVOR_BITS,
            first=config.elites,
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


#: Members that are those of the builder.
_PASSED = (
    "slots",
    "limits",
    "start",
    "goal",
    "read",
    "waypoint",
    "write",
    "children",
    "points",
)
