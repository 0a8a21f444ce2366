"""Surfaces of the blocks, and the cost from each block to the goal."""

from amaranth import *
from amaranth.lib import memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.planner.layouts import problem_layout
from pathgene.hdl.planner.wavefront.layouts import (
    COST_BITS,
    INDEX_BITS,
    block_layout,
    by_rows,
)
from pathgene.hdl.planner.wavefront.relaxer import Relaxer, surface_layout
from pathgene.hdl.planner.wavefront.steps import LIMIT_BITS, StepConstants
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, FAR, SWEEPS


__all__ = ["Wavefront"]

#: Maximum passes of a relaxation.
_PASSES = 2 * SWEEPS


class Wavefront(Unit):
    """Makes a surface from the minimum ground, limits its slopes, and spreads costs from the goal.

    1. Every block is read and written to the surface, while the falls of the steps are computed.
    2. If ``limit`` is not 0, the slopes are limited: passes over the depths of the blocks.
    3. The depths become the surface, and the costs begin: 0 at the goal. Meanwhile, the constants
       of the steps' costs are computed.
    4. Costs spread.

    Steps 2 and 4 end with the first two passes, forwards and backwards, that change nothing, or
    after 128 passes. ``busy`` is high for as many cycles as
    :func:`pathgene.sim.model.planner.run_cycles.spreading` says. Equals ``limit_slopes`` and
    ``spread`` of :mod:`pathgene.sim.model.planner.definition.wavefront`; a cost beyond 2**30 means
    no route.

    Members
    -------
    problem : In(problem_layout)
        Steady.
    fine : In(1)
        The map has 64 x 64 blocks; otherwise 32 x 32. Steady.
    limit : In(4)
        Slope limit, in halves of the climb limit; 0 leaves the surface unchanged. Steady.
    goal : In(12)
        Block of the goal. Steady.
    launch : In(1)
        Pulse: begin. Not while ``busy``.
    busy : Out(1)
    passes : Out(9)
        Passes since ``launch``.
    map_block : Out(12)
        Block to read from the map of blocks.
    block : In(block_layout)
        That block, 2 cycles later.
    read_block : In(12)
        Block to read while not ``busy``.
    surface : Out(surface_layout)
    cost : Out(31)
        That block's altitude, 0 if it is not free, and its cost to the goal, 2**30 if there is no
        route; 2 cycles later.
    before, after : In(altitude_bits)
    prices : Out(31).array(3)
        See :class:`pathgene.hdl.planner.wavefront.relaxer.Relaxer`.
    """

    config: InstanceOf(Config)

    @staticmethod
    def fill_cycles(fine: bool) -> int:
        """Return the cycles to fill the memories once."""
        return (BLOCKS if fine else COARSE_BLOCKS) ** 2 + 2

    def interface(self):
        config = self.config
        z = config.altitude_bits
        self.block_layout = block_layout(config.coordinate_bits, z)
        self.surface_layout = surface_layout(z)
        return {
            "problem": In(problem_layout(config)),
            "fine": In(1),
            "limit": In(LIMIT_BITS),
            "goal": In(INDEX_BITS),
            "launch": In(1),
            "busy": Out(1),
            "passes": Out(range(2 * _PASSES + 1)),
            "map_block": Out(INDEX_BITS),
            "block": In(self.block_layout),
            "read_block": In(INDEX_BITS),
            "surface": Out(self.surface_layout),
            "cost": Out(COST_BITS),
            "before": In(z),
            "after": In(z),
            "prices": Out(COST_BITS).array(3),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.constants = constants = StepConstants(
            self.problem.shape(), self.config.coordinate_bits, self.config.altitude_bits
        )
        m.submodules.relaxer = relaxer = Relaxer(self.config.altitude_bits)
        assert constants.most_cycles < self.fill_cycles(fine=False)
        m.d.comb += [
            constants.problem.eq(self.problem),
            constants.limit.eq(self.limit),
            relaxer.fine.eq(self.fine),
            relaxer.constants.eq(constants.constants),
            relaxer.before.eq(self.before),
            relaxer.after.eq(self.after),
            *(own.eq(price) for own, price in zip(self.prices, relaxer.prices, strict=True)),
        ]

        # Filling takes one cycle per block, and two for the last block to be read and written.
        number = Signal(range(self.fill_cycles(fine=True)))
        block = Cat(*by_rows(number, self.fine))
        # Steady long before the end of a filling.
        end = Mux(self.fine, BLOCKS**2, COARSE_BLOCKS**2) + 1
        final = delay_line(m, end[: len(number)], 1, "final")
        passes = Signal(range(_PASSES + 1))
        first, unchanged, spreads = Signal(), Signal(), Signal()
        filled = delay_line(m, block, 2, "filled")
        fills = Signal()
        m.d.comb += constants.falls.eq(~spreads)
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += number.eq(0)
                with m.If(self.launch):
                    m.d.sync += [self.passes.eq(0), spreads.eq(0)]
                    m.next = "FILL"
            with m.State("FILL"):
                m.d.comb += [fills.eq(number >= 2), constants.launch.eq(number == 0)]
                m.d.sync += [number.eq(number + 1), first.eq(1), passes.eq(0)]
                with m.If(number == final):
                    m.d.sync += number.eq(0)
                    m.next = "RELAX"
                    with m.If(~spreads & ~self.limit.any()):
                        m.d.sync += spreads.eq(1)
                        m.next = "FILL"
            with m.State("RELAX"):
                with m.If(~relaxer.busy):
                    m.d.sync += [first.eq(0), unchanged.eq(~relaxer.changed)]
                    ends = ~relaxer.changed & unchanged | (passes == _PASSES)
                    with m.If(~first & ~passes[0] & ends):
                        m.d.sync += spreads.eq(1)
                        m.next = "FILL"
                        with m.If(spreads):
                            m.next = "IDLE"
                    with m.Else():
                        m.d.comb += relaxer.launch.eq(1)
                        m.d.sync += [
                            relaxer.backwards.eq(passes[0]),
                            passes.eq(passes + 1),
                            self.passes.eq(self.passes + 1),
                        ]
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))

        def memory_of(shape, name):
            m.submodules[name] = rows = memory.Memory(
                shape=shape, depth=BLOCKS**2, init=[], attrs={"no_rw_check": 1}
            )
            return rows.write_port(), rows.read_port()

        surface_write, surface_read = memory_of(self.surface_layout, "surfaces")
        cost_write, cost_read = memory_of(COST_BITS, "costs")
        surface = Signal(self.surface_layout, reset_less=True)
        cost = Signal(COST_BITS, reset_less=True)
        m.d.sync += [surface.eq(surface_read.data), cost.eq(cost_read.data)]
        m.d.comb += [
            self.map_block.eq(block),
            self.surface.eq(surface),
            self.cost.eq(cost),
            relaxer.surface.eq(surface),
            relaxer.cost.eq(cost),
        ]
        with m.If(states.ongoing("FILL")):
            m.d.comb += [surface_read.addr.eq(block), cost_read.addr.eq(block)]
        with m.Elif(relaxer.busy):
            m.d.comb += [
                surface_read.addr.eq(relaxer.surface_block),
                cost_read.addr.eq(relaxer.cost_block),
            ]
        with m.Else():
            m.d.comb += [
                surface_read.addr.eq(self.read_block),
                cost_read.addr.eq(self.read_block),
            ]

        # A depth is the complement of an altitude: the top altitude has all bits.
        with m.If(relaxer.busy):
            m.d.comb += [
                cost_write.addr.eq(relaxer.write.block),
                cost_write.data.eq(relaxer.write.cost),
                cost_write.en.eq(relaxer.write.valid),
            ]
        with m.Else():
            m.d.comb += [cost_write.addr.eq(filled), cost_write.en.eq(fills)]
            with m.If(spreads):
                m.d.comb += cost_write.data.eq(Mux(filled == self.goal, 0, FAR))
            with m.Else():
                depth = ~self.block.altitude
                m.d.comb += cost_write.data.eq(Mux(self.block.free, depth, FAR))
        m.d.comb += [surface_write.addr.eq(filled), surface_write.en.eq(fills)]
        with m.If(spreads):
            height = ~cost[: len(surface.altitude)]
            m.d.comb += [
                surface_write.data.free.eq(surface.free),
                surface_write.data.altitude.eq(Mux(surface.free, height, 0)),
            ]
        with m.Else():
            m.d.comb += [
                surface_write.data.free.eq(self.block.free),
                surface_write.data.altitude.eq(self.block.altitude),
            ]

        return m
