"""A pass over the blocks, one block per cycle.

A block's new cost depends on its own cost, on costs of the previous row, and on the cost of the
block just finished. All except the last are summed and compared ahead of time, so the last cycle
has only one comparison in parallel with one sum.
"""

from amaranth import *
from amaranth.lib import data, memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.wavefront.layouts import (
    COST_BITS,
    INDEX_BITS,
    by_rows,
    step_constants_layout,
)
from pathgene.hdl.planner.wavefront.steps import StepPricer
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Unit, Width
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS


__all__ = ["Relaxer", "cost_write_layout", "surface_layout"]

#: Directions of the steps to the neighbours in the order west, north-west, north, north-east, for a
#: forward pass; to the opposite neighbours for a backward pass.
_WAYS = (0, 2, 1, 2)
#: The cycles, counted from a block's first, in which its costs are read and in which the new cost
#: is written.
_READ, _WRITTEN = StepPricer.latency + 2, StepPricer.latency + 8
#: Cycles of a pass beside one for each block.
_PIPELINE = _WRITTEN + 2

#: Cost to write to a block.
cost_write_layout = data.StructLayout({"valid": 1, "block": INDEX_BITS, "cost": COST_BITS})


def surface_layout(altitude_bits: int) -> data.StructLayout:
    """Return the layout of a block of the surface: whether it is free, and its altitude."""
    return data.StructLayout({"free": 1, "altitude": altitude_bits})


class Relaxer(Unit):
    """Lowers the cost of each free block to the cost via a neighbour if that is lower.

    A pass takes a cycle for each block plus the cycles of the pipeline: ``busy`` is high for
    :meth:`pass_cycles` - 1 cycles from the cycle after ``launch`` on. It goes over the blocks by
    rows, forwards or backwards; the neighbours of a block are the four that the pass has already
    visited. No cost of a block exceeds 2**30, the cost of a block without a route.

    Equals half a sweep of ``spread`` of :mod:`pathgene.sim.model.planner.definition.wavefront`; and
    of ``limit_slopes``, where costs are depths below the top altitude, and each step costs its
    fall.

    Members
    -------
    launch : In(1)
        Pulse: begin a pass. Not while ``busy``.
    fine : In(1)
        The map has 64 x 64 blocks; otherwise 32 x 32. Steady from ``launch`` to the end.
    backwards : In(1)
        Direction of the pass. Steady from ``launch`` to the end of the pass.
    constants : In(step_constants_layout)
        Steady.
    surface_block : Out(12)
        Block to read from the surface.
    surface : In(surface_layout)
        That block, 2 cycles later.
    cost_block : Out(12)
        Block whose cost is read.
    cost : In(31)
        Its cost, 2 cycles later.
    write : Out(cost_write_layout)
    busy : Out(1)
    changed : Out(1)
        The latest pass changed a cost. Valid after ``busy``.
    before, after : In(altitude_bits)
        Altitudes of a step to be priced between passes.
    prices : Out(31).array(3)
        Cost of the step in x, in y, and diagonally, ``StepPricer.latency`` cycles later.
    """

    altitude_bits: Width(1)

    @staticmethod
    def pass_cycles(fine: bool) -> int:
        """Return the cycles from one ``launch`` to the next."""
        return (BLOCKS if fine else COARSE_BLOCKS) ** 2 + _PIPELINE

    def interface(self):
        return {
            "launch": In(1),
            "fine": In(1),
            "backwards": In(1),
            "constants": In(step_constants_layout),
            "surface_block": Out(INDEX_BITS),
            "surface": In(surface_layout(self.altitude_bits)),
            "cost_block": Out(INDEX_BITS),
            "cost": In(COST_BITS),
            "write": Out(cost_write_layout),
            "busy": Out(1),
            "changed": Out(1),
            "before": In(self.altitude_bits),
            "after": In(self.altitude_bits),
            "prices": Out(COST_BITS).array(len(set(_WAYS))),
        }

    def elaborate(self, platform):
        m = Module()

        # Number of the block in the pass, and the cycles that the pipeline takes after the last
        # block.
        fine = self.fine
        count = Signal(range(self.pass_cycles(fine=True)))
        # Steady long before the end of a pass.
        blocks = Mux(fine, BLOCKS**2, COARSE_BLOCKS**2)
        final = delay_line(m, (blocks + _PIPELINE - 2)[: len(count)], 1, "final")
        unwritten = delay_line(m, (blocks + _WRITTEN - 1)[: len(count)], 1, "unwritten")
        with m.If(self.busy):
            m.d.sync += count.eq(count + 1)
            with m.If(count == final):
                m.d.sync += self.busy.eq(0)
        with m.If(self.launch):
            m.d.sync += [self.busy.eq(1), count.eq(0)]
        number = count[:INDEX_BITS]

        def register(value, name):
            return delay_line(m, value, 1, name)

        def block_of(number):
            x, y = by_rows(number ^ self.backwards.replicate(INDEX_BITS), fine)
            return Cat(x, y)

        def later(cycles):
            """Return the number of the block that is ``cycles`` after its first cycle, 1 or more.

            The number is in a register, because LUT RAMs follow. Valid while ``busy``.
            """
            return register((number - (cycles - 1))[:INDEX_BITS], f"number_{cycles}")

        m.d.comb += [
            self.surface_block.eq(block_of(number)),
            self.cost_block.eq(block_of(later(_READ))),
        ]

        # 2**30 if there is no step.
        costs = self._step_costs(m, later)

        # The previous row, starting at the north-east.
        column = self._column(later(_READ - 1))
        done = Signal(COST_BITS, reset_less=True)
        written = later(_WRITTEN)
        north_east = _ring(m, "upper_costs", done, self._column(written), column)
        north = delay_line(m, north_east, 1, "north")
        north_west = delay_line(m, north, 1, "north_west")

        def least(a, b, name):
            return register(Mux(a < b, a, b), name)

        sums = [
            register(value + cost, f"by_{name}")
            for value, cost, name in zip(
                (north_west, north, north_east),
                costs[1:],
                ("north_west", "north", "north_east"),
                strict=True,
            )
        ]
        pair = least(sums[0], sums[1], "pair")
        single = least(sums[2], self.cost, "single")
        ahead = least(pair, single, "ahead")
        west = delay_line(m, costs[0], 3, "west")
        # The block just visited is better if its cost is below this.
        below = register(ahead - west, "below")
        ahead, west = register(ahead, "ahead_held"), register(west, "west_held")
        m.d.sync += done.eq(Mux(done < below, done + west, ahead))

        # Between passes `count` keeps its end, which a larger map has not passed.
        is_written = Signal()
        m.d.sync += is_written.eq(self.busy & (count >= _WRITTEN - 1) & (count < unwritten))
        m.d.comb += [
            self.write.valid.eq(is_written),
            self.write.block.eq(block_of(written)),
            self.write.cost.eq(done),
        ]
        old = delay_line(m, self.cost, _WRITTEN - _READ - 2, "old")
        differs = register((done != old) & is_written, "differs")
        with m.If(self.launch):
            m.d.sync += self.changed.eq(0)
        with m.Elif(differs):
            m.d.sync += self.changed.eq(1)

        return m

    def _column(self, number):
        """Return the column of a block, given its number in the pass."""
        return by_rows(number, self.fine)[0]

    def _step_costs(self, m, later):
        """Return the costs of the steps to the four neighbours, in registers."""
        altitude = self.surface.altitude
        column, next_column = self._column(later(2)), self._column(later(1))
        north_east = _ring(m, "upper_altitudes", altitude, column, next_column)
        here = delay_line(m, altitude, 1, "altitude")
        north = delay_line(m, north_east, 1, "altitude_north")
        north_west = delay_line(m, north, 1, "altitude_north_west")
        neighbours = delay_line(m, here, 1, "altitude_west"), north_west, north, north_east

        # For the last register of a cost. Between passes, all steps are allowed.
        at = later(StepPricer.latency + 1)
        free = delay_line(m, self.surface.free, StepPricer.latency - 1, "free")
        leads = Signal(4, reset_less=True)
        x, y = by_rows(at, self.fine)
        is_first, upper = x == 0, y.any()
        is_last = x == Mux(self.fine, BLOCKS - 1, COARSE_BLOCKS - 1)
        m.d.sync += leads.eq(
            Cat(~is_first, ~is_first & upper, upper, ~is_last & upper) & free.replicate(4)
            | (~self.busy).replicate(4)
        )

        costs = []
        for i, (way, neighbour) in enumerate(zip(_WAYS, neighbours, strict=True)):
            m.submodules[f"pricer_{i}"] = pricer = StepPricer(self.altitude_bits)
            before, after = here, neighbour
            # The first three pricers also price steps between passes.
            if i < 3:
                before = Mux(self.busy, here, self.before)
                after = Mux(self.busy, neighbour, self.after)
                m.d.comb += self.prices[way].eq(pricer.cost)
            m.d.comb += [
                pricer.way.eq(self.constants.ways[way]),
                pricer.climb.eq(self.constants.climb),
                pricer.before.eq(before),
                pricer.after.eq(after),
                pricer.leads.eq(leads[i]),
            ]
            costs.append(pricer.cost)
        return costs


def _ring(m, name, value, written, read):
    """Return the value of the previous row in column ``read``, one cycle later.

    ``value`` belongs to column ``written`` of the current row.
    """
    m.submodules[name] = rows = memory.Memory(shape=len(value), depth=BLOCKS, init=[])
    write, port = rows.write_port(), rows.read_port(domain="comb")
    m.d.comb += [
        write.addr.eq(written),
        write.data.eq(value),
        write.en.eq(1),
        port.addr.eq(read),
    ]
    return delay_line(m, port.data, 1, f"{name}_north_east")
