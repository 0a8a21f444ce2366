"""Source of the first paths of an island: from the map to the waypoints along a route."""

from amaranth import *
from amaranth.lib import data, memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.planner.layouts import corner_layout, frame_layout, problem_layout
from pathgene.hdl.planner.wavefront.block_map import BlockMap
from pathgene.hdl.planner.wavefront.layouts import (
    COARSE_BITS,
    INDEX_BITS,
    block_layout,
    found_layout,
    place_layout,
    shift_limit,
)
from pathgene.hdl.planner.wavefront.relaxer import surface_layout
from pathgene.hdl.planner.wavefront.route import Route
from pathgene.hdl.planner.wavefront.steps import LIMIT_BITS
from pathgene.hdl.planner.wavefront.wavefront import Wavefront
from pathgene.hdl.primitives.arithmetic import Divider, Multiplier
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, InstanceOf, Unit
from pathgene.hdl.protocol.planner import seed_waypoints


__all__ = ["SeedSource", "Seeder"]


#: Fields of the first word of a path, and of the word of a waypoint.
_COUNT, _PHASE, _SHIFT = slice(0, 8), slice(8, 16), slice(16, 19)
_PHASE_BITS = 8
_OFFSET_BITS = 16
_AXES = ("x", "y", "altitude")


class Seeder(Unit):
    """Makes paths along the route, at random heights above the surface.

    The waypoints are evenly spaced, or at the turns of the route, or at random heights above the
    waypoints of the guide. It takes a word of the random
    source in every cycle after ``launch``: one for the path, then one for each waypoint. A waypoint
    follows its word by :attr:`latency` cycles.
    Equals ``seed_path`` of :mod:`pathgene.sim.model.planner.seeds`.

    Attributes
    ----------
    latency : int
        Cycles from a waypoint's word to the waypoint.

    Members
    -------
    limits : In(corner_layout)
        Highest corner and altitude of a waypoint. Steady.
    length : In(13)
        Blocks of the route, 1 or more. Steady.
    follows : In(1)
        The waypoints are at the turns, or above the guide's. Steady.
    turns : In(range(max_waypoints + 1))
        Their number, 2 or more with ``follows``. Steady.
    guided : In(1)
        With ``follows``: they are above the guide's. Steady.
    block_shift : In
        Corners along the edge of a block, as a power of two. Steady.
    launch : In(1)
        Pulse: make a path. Not while ``busy``.
    busy : Out(1)
        Words are being taken.
    word : In(19)
        Lowest bits of the random source's selection word.
    word_ready : In(1)
        A word is available.
    step : Out(1)
        The word is taken in this cycle. Only with ``word_ready``.
    number : Out(12)
        Number of a block of the route, a turn or a waypoint of the guide to read.
    place : In(place_layout)
    guide : In(corner_layout)
        That block, and that waypoint, 2 cycles later.
    read_block : Out(12)
        Block to read from map and surface.
    block : In(block_layout)
    surface : In(surface_layout)
        That block, 2 cycles later.
    found : Out(found_layout)
        The path, one waypoint per cycle.
    """

    config: InstanceOf(Config)

    #: Registers from a word to the quotient, then for route, block, and two for the waypoint.
    latency = 2 + INDEX_BITS + 2 + 2 + 2

    def interface(self):
        config = self.config
        xy, z = config.coordinate_bits, config.altitude_bits
        return {
            "limits": In(corner_layout(xy, z)),
            "length": In(INDEX_BITS + 1),
            "follows": In(1),
            "turns": In(range(config.max_waypoints + 1)),
            "guided": In(1),
            "block_shift": In(max(1, shift_limit(xy).bit_length())),
            "launch": In(1),
            "busy": Out(1),
            "word": In(_SHIFT.stop),
            "word_ready": In(1),
            "step": Out(1),
            "number": Out(INDEX_BITS),
            "place": In(place_layout),
            "guide": In(corner_layout(xy, z)),
            "read_block": Out(INDEX_BITS),
            "block": In(block_layout(xy, z)),
            "surface": In(surface_layout(z)),
            "found": Out(found_layout(xy, z)),
        }

    def elaborate(self, platform):
        m = Module()

        config = self.config
        fewest, most = seed_waypoints(config.max_waypoints)
        longest = config.max_waypoints

        # Word 0 is for the path, each later word for a waypoint. The number of waypoints is known
        # two cycles after word 0, soon enough for two waypoints.
        number = Signal(range(longest + 1))
        count = Signal(range(longest + 1), init=Config.MIN_WAYPOINTS)
        m.d.comb += self.step.eq(self.busy & self.word_ready)
        with m.If(self.step):
            m.d.sync += number.eq(number + 1)
            with m.If(number == count):
                m.d.sync += [number.eq(0), self.busy.eq(0)]
        with m.If(self.launch):
            m.d.sync += self.busy.eq(1)

        # A register after the source.
        word = delay_line(m, self.word, 1, "word")
        index = delay_line(m, (number - 1)[: longest.bit_length()], 1, "index")
        is_head, is_place = Signal(), Signal()
        m.d.sync += [
            is_head.eq(self.step & (number == 0)),
            is_place.eq(self.step & (number != 0)),
        ]

        # The path's word is read one cycle before its first waypoint arrives.
        phase = Signal(_PHASE_BITS, reset_less=True)
        shift = Signal(3, reset_less=True)
        with m.If(is_head):
            m.d.sync += [
                count.eq(
                    Mux(
                        self.follows,
                        self.turns,
                        fewest + (word[_COUNT] * (most - fewest + 1) >> 8),
                    )
                ),
                phase.eq(word[_PHASE]),
                shift.eq(word[_SHIFT]),
            ]

        # Position on the route, then its block, then the block's lowest corner and surface.
        along = Cat(phase, index)
        m.submodules.along = scale = Multiplier(
            (len(along), len(self.length)), _PHASE_BITS, (False, False)
        )
        m.submodules.offsets = offsets = Multiplier(
            (_OFFSET_BITS, config.altitude_bits), _OFFSET_BITS, (False, False)
        )
        m.submodules.divider = divider = Divider(len(scale.product) - INDEX_BITS, INDEX_BITS)
        m.d.comb += [
            scale.first.eq(along),
            scale.second.eq(self.length),
            offsets.first.eq(word[:_OFFSET_BITS]),
            offsets.second.eq(config.box_steps),
            divider.dividend.eq(scale.product),
            divider.divisor.eq(delay_line(m, count, 1, "divisor")),
            self.number.eq(
                Mux(
                    self.follows,
                    delay_line(m, index, 1 + divider.latency, "turn"),
                    divider.quotient,
                )
            ),
            self.read_block.eq(self.place),
        ]
        to_block = divider.latency + 2 + 2
        height = delay_line(m, offsets.product >> delay_line(m, shift, 1, "shift"), 1, "height")
        height = delay_line(m, height, to_block - 1, "above")
        is_here = Signal(to_block + 3)
        m.d.sync += is_here.eq(Cat(is_place, is_here))
        last = delay_line(m, index == count - 1, to_block + 3, "last")

        limits = self.limits
        half = (1 << self.block_shift) >> 1
        guide = {axis: delay_line(m, self.guide[axis], 2, f"guide_{axis}") for axis in _AXES}
        lowest = Mux(self.guided, guide["altitude"], self.surface.altitude)
        raised = delay_line(m, lowest + height, 1, "raised")
        found = Signal(corner_layout(config.coordinate_bits, config.altitude_bits), reset_less=True)
        for axis in "xy":
            middle = (self.place[axis] << self.block_shift) | half
            middle = delay_line(m, middle[: config.coordinate_bits], 2, f"middle_{axis}")
            listed = Mux(self.guided, guide[axis], middle)
            corner = Mux(self.follows, listed, self.block[axis])
            corner = delay_line(m, corner, 1, f"corner_{axis}")
            m.d.sync += found[axis].eq(Mux(corner > limits[axis], limits[axis], corner))
        m.d.sync += found.altitude.eq(Mux(raised > limits.altitude, limits.altitude, raised))
        m.d.comb += [
            self.found.valid.eq(is_here[-1]),
            self.found.last.eq(last),
            *(self.found[axis].eq(found[axis]) for axis in _AXES),
        ]

        return m


class SeedSource(Unit):
    """Scans the map's blocks, finds a route over a surface, and seeds paths along it one by one.

    The blocks are scanned before the first ``launch`` of a run; every later launch uses a different
    slope limit. A launch is a wavefront, then a route, then a path for each ``begin``; a path along
    the guide needs no launch. ``busy`` is
    high for as many cycles as ``scanned``, ``launched`` and ``seeded`` of
    :mod:`pathgene.sim.model.planner.run_cycles` say.

    Members
    -------
    problem : In(problem_layout)
    frame : In(frame_layout)
        Ends of the frame: corners nearest to the ends of the problem, and the steps at or below
        them. Steady, like ``problem``, while ``busy`` and one cycle earlier.
    write : In({"valid", "x", "y"})
    row : Out({"x", "y"})
    corners : In(altitude_bits).array(lanes)
        See :class:`pathgene.hdl.planner.wavefront.block_map.BlockMap`.
    scan : In(1)
        Pulse: scan the blocks. Not while ``busy``.
    launch : In(1)
        Pulse: find a route. Not while ``busy``.
    limit : In(4)
        Slope limit of the surface, in halves of the climb limit; 0 means none. Steady while
        ``busy``.
    by_turns : In(1)
        The waypoints are at the turns of the route if it has at least two and not more than a path
        has waypoints. Steady, as ``limit``.
    guided : In(8)
        Number of waypoints of the guide, 2 or more, if a path has them; 0 for the route. Steady,
        as ``limit``.
    guide : In({"valid", "index", "x", "y", "altitude"})
        A waypoint of the guide to store. Not while ``busy``.
    begin : In(1)
        Pulse: make a path along the route or the guide. Not while ``busy``.
    busy : Out(1)
        High until the blocks are scanned, the route is found, or the words of a path are taken.
    passes : Out(9)
        Passes of the latest wavefront.
    word : In(19)
    word_ready : In(1)
    step : Out(1)
    found : Out(found_layout)
        See :class:`pathgene.hdl.planner.wavefront.seed_source.Seeder`.
    """

    config: InstanceOf(Config)
    read_latency: Count(1, text="Cycles from ``row`` to ``corners``.")

    def interface(self):
        config = self.config
        xy, z = config.coordinate_bits, config.altitude_bits
        self._blocks = BlockMap(config.lanes, xy, z, self.read_latency)
        self._wavefront = Wavefront(config)
        self._seeder = Seeder(config)
        members = self._blocks.signature.members
        return {
            "problem": In(problem_layout(config)),
            "frame": In(frame_layout(xy, z)),
            **{name: members[name] for name in ("write", "row", "corners")},
            "scan": In(1),
            "launch": In(1),
            "limit": In(LIMIT_BITS),
            "by_turns": In(1),
            "guided": In(8),
            "guide": In(
                data.StructLayout({"valid": 1, "index": 8, "x": xy, "y": xy, "altitude": z})
            ),
            "begin": In(1),
            "busy": Out(1),
            "passes": self._wavefront.signature.members["passes"],
            "word": self._seeder.signature.members["word"],
            "word_ready": In(1),
            "step": Out(1),
            "found": self._seeder.signature.members["found"],
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.blocks = blocks = self._blocks
        m.submodules.wavefront = wavefront = self._wavefront
        m.submodules.route = route = Route(self.config.altitude_bits, self.config.max_waypoints)
        m.submodules.seeder = seeder = self._seeder

        with m.FSM() as states:
            with m.State("IDLE"):
                with m.If(self.scan):
                    m.d.comb += blocks.launch.eq(1)
                    m.next = "SCAN"
                with m.If(self.launch):
                    m.d.comb += wavefront.launch.eq(1)
                    m.next = "SPREAD"
                with m.If(self.begin):
                    m.d.comb += seeder.launch.eq(1)
                    m.next = "SEED"
            with m.State("SCAN"):
                with m.If(~blocks.busy):
                    m.next = "IDLE"
            with m.State("SPREAD"):
                with m.If(~wavefront.busy):
                    m.d.comb += route.launch.eq(1)
                    m.next = "DESCEND"
            with m.State("DESCEND"):
                with m.If(~route.busy):
                    m.next = "IDLE"
            with m.State("SEED"):
                with m.If(~seeder.busy):
                    m.next = "IDLE"
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))

        problem = self.problem
        # All are steady long before they are used.
        fine, follows, guided = Signal(), Signal(), Signal()
        count = Signal(range(self.config.max_waypoints + 1))
        furthest = (problem.x_limit | problem.y_limit) >> problem.block_shift
        m.d.sync += [
            fine.eq(furthest[COARSE_BITS:].any()),
            guided.eq(self.guided.any()),
            follows.eq(
                guided
                | (
                    self.by_turns
                    & (route.turns >= Config.MIN_WAYPOINTS)
                    & (route.turns <= self.config.max_waypoints)
                )
            ),
            count.eq(Mux(guided, self.guided, route.turns)),
        ]
        m.d.comb += [
            blocks.fine.eq(fine),
            wavefront.fine.eq(fine),
            route.fine.eq(fine),
            route.of_turns.eq(follows),
            seeder.follows.eq(follows),
            seeder.turns.eq(count),
            seeder.guided.eq(guided),
            seeder.guide.eq(self._keep_guide(m, seeder.number)),
            seeder.block_shift.eq(problem.block_shift),
            blocks.block_shift.eq(problem.block_shift),
            blocks.start.eq(self.frame.start),
            blocks.goal.eq(self.frame.goal),
            blocks.write.eq(self.write),
            self.row.eq(blocks.row),
            *(own.eq(corner) for own, corner in zip(blocks.corners, self.corners, strict=True)),
            blocks.number.eq(Mux(wavefront.busy, wavefront.map_block, seeder.read_block)),
            wavefront.problem.eq(problem),
            wavefront.limit.eq(self.limit),
            wavefront.goal.eq(blocks.goal_block),
            wavefront.block.eq(blocks.block),
            wavefront.read_block.eq(Mux(route.busy, route.read_block, seeder.read_block)),
            wavefront.before.eq(route.before),
            wavefront.after.eq(route.after),
            self.passes.eq(wavefront.passes),
            route.start.eq(blocks.start_block),
            route.goal.eq(blocks.goal_block),
            route.surface.eq(wavefront.surface),
            route.cost.eq(wavefront.cost),
            *(own.eq(price) for own, price in zip(route.prices, wavefront.prices, strict=True)),
            route.number.eq(seeder.number),
            seeder.limits.x.eq(problem.x_limit),
            seeder.limits.y.eq(problem.y_limit),
            seeder.limits.altitude.eq(problem.altitude_limit),
            seeder.length.eq(route.length),
            seeder.place.eq(route.place),
            seeder.block.eq(blocks.block),
            seeder.surface.eq(wavefront.surface),
            seeder.word.eq(self.word),
            seeder.word_ready.eq(self.word_ready),
            self.step.eq(seeder.step),
            self.found.eq(seeder.found),
        ]

        return m

    def _keep_guide(self, m, number):
        """Store the guide; return the waypoint whose number was given two cycles ago."""
        config = self.config
        layout = corner_layout(config.coordinate_bits, config.altitude_bits)
        m.submodules.guide = stored = memory.Memory(
            shape=layout, depth=config.max_waypoints, init=[]
        )
        write, read = stored.write_port(), stored.read_port(domain="comb")
        m.d.comb += [
            write.en.eq(self.guide.valid),
            write.addr.eq(self.guide.index),
            *(write.data[axis].eq(self.guide[axis]) for axis in _AXES),
            read.addr.eq(number),
        ]
        return delay_line(m, read.data.as_value(), 2, "guide_waypoint")
