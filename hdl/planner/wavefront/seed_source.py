"""First paths of an island: computes their waypoints from the map."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.planner.layouts import frame_layout, problem_layout
from pathgene.hdl.planner.wavefront.block_map import BlockMap
from pathgene.hdl.planner.wavefront.route import Route
from pathgene.hdl.planner.wavefront.seeder import Seeder
from pathgene.hdl.planner.wavefront.steps import LIMIT_BITS
from pathgene.hdl.planner.wavefront.wavefront import Wavefront
from pathgene.hdl.primitives.unit import Count, InstanceOf, Unit


__all__ = ["SeedSource"]


class SeedSource(Unit):
    """Scans the map's blocks, finds a route over a surface, and seeds paths along it one by one.

    The blocks are scanned before the first ``launch`` of a run; every later launch uses a different
    slope limit. A launch is a wavefront, then a route, then a path for each ``begin``. ``busy`` is
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
    begin : In(1)
        Pulse: make a path along the route. Not while ``busy``.
    busy : Out(1)
        High until the blocks are scanned, the route is found, or the words of a path are taken.
    passes : Out(9)
        Passes of the latest wavefront.
    word : In(19)
    word_ready : In(1)
    step : Out(1)
    found : Out(found_layout)
        See :class:`pathgene.hdl.planner.wavefront.seeder.Seeder`.
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
        m.submodules.route = route = Route(self.config.altitude_bits)
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
        m.d.comb += [
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
