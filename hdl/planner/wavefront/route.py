"""Route from the start to the goal over the blocks, and its turns."""

from amaranth import *
from amaranth.lib import memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.wavefront.layouts import BLOCK_BITS, COST_BITS, INDEX_BITS, place_layout
from pathgene.hdl.planner.wavefront.relaxer import surface_layout
from pathgene.hdl.planner.wavefront.steps import StepPricer
from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, FAR


__all__ = ["Route", "TurnFinder"]

#: Blocks of a straight line.
_STRAIGHT_BITS = 6
_STRAIGHT = 1 << _STRAIGHT_BITS
#: Relative x and y of a block and its neighbours, and the index of their direction: the block
#: itself first, then its neighbours by rows.
_STEPS = (
    (0, 0, 0),
    *((x, y, 2 if x and y else int(x == 0)) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y),
)
#: Cycles from the step of a neighbour to its surface and cost, and to the cost by way of it.
_READ = 3
_PRICED = _READ + 1 + StepPricer.latency
_SUMMED = _PRICED + 1


class TurnFinder(Unit):
    """Tells whether the block before the current one is a turn of the route.

    The route is straight as long as its blocks lie in a wedge, which begins at the last turn and
    which each of them narrows to its own width. Equals ``turns_of`` of
    :mod:`pathgene.sim.model.planner.definition.wavefront`.

    Attributes
    ----------
    cycles : int
        Cycles that a block takes.

    Members
    -------
    begin : In(1)
        Pulse: ``place`` is the start.
    advance : In(1)
        Pulse: ``place`` is the next block. Not within ``cycles`` cycles of another pulse.
    place : In(place_layout)
        Steady from a pulse until the next.
    found : Out(1)
        Pulse within ``cycles`` cycles after ``advance``: ``turn`` is a turn.
    turn : Out(place_layout)
        The block before ``place``.
    """

    #: Two cross products with the wedge, then two with the wedge that the block leaves.
    cycles = 11

    def interface(self):
        return {
            "begin": In(1),
            "advance": In(1),
            "place": In(place_layout),
            "found": Out(1),
            "turn": Out(place_layout),
        }

    def elaborate(self, platform):
        m = Module()

        def vector(name):
            # Differences of two blocks, and one block more.
            shape = signed(BLOCK_BITS + 2)
            return {axis: Signal(shape, name=f"{name}_{axis}", reset_less=True) for axis in "xy"}

        def become(one, other):
            return [one[axis].eq(other[axis]) for axis in "xy"]

        def sign(value):
            return Cat(value.any(), value[-1]).as_signed()

        at = Signal(place_layout, reset_less=True)
        before = Signal(place_layout, reset_less=True)
        m.d.comb += self.turn.eq(before)
        way, left, right = vector("way"), vector("left"), vector("right")
        to_left, to_right = vector("to_left"), vector("to_right")
        narrows, outside = Signal(), Signal()

        # Whether the cross product of the vectors chosen two cycles ago is negative.
        one, other = vector("one"), vector("other")
        products = []
        for first, second in ("xy", "yx"):
            multiplier = Multiplier((BLOCK_BITS + 2, BLOCK_BITS + 2))
            m.submodules[f"product_{first}{second}"] = multiplier
            m.d.comb += [multiplier.first.eq(one[first]), multiplier.second.eq(other[second])]
            products.append(multiplier.product)
        is_negative = products[0] < products[1]

        aside = {axis: sign(value) for axis, value in way.items()}
        # Cycles left; 0 between blocks.
        left_cycles = Signal(range(self.cycles + 1))
        with m.If(left_cycles.any()):
            m.d.sync += left_cycles.eq(left_cycles - 1)
        with m.If(self.begin):
            m.d.sync += [at.eq(self.place), before.eq(self.place), narrows.eq(0)]
        with m.If(self.advance):
            m.d.sync += left_cycles.eq(self.cycles)
        cycle = [self.cycles - i for i in range(self.cycles)]
        with m.Switch(left_cycles):
            with m.Case(cycle[0], cycle[5]):
                m.d.sync += [way[axis].eq(self.place[axis] - at[axis]) for axis in "xy"]
            with m.Case(cycle[1]):
                m.d.sync += [*become(one, right), *become(other, way)]
            with m.Case(cycle[2]):
                m.d.sync += [*become(one, way), *become(other, left)]
            with m.Case(cycle[3]):
                m.d.sync += outside.eq(is_negative)
            with m.Case(cycle[4]):
                with m.If(narrows & (outside | is_negative)):
                    m.d.comb += self.found.eq(1)
                    m.d.sync += [at.eq(before), narrows.eq(0)]
            with m.Case(cycle[6]):
                m.d.sync += [
                    to_left["x"].eq(way["x"] - aside["y"]),
                    to_left["y"].eq(way["y"] + aside["x"]),
                    to_right["x"].eq(way["x"] + aside["y"]),
                    to_right["y"].eq(way["y"] - aside["x"]),
                ]
            with m.Case(cycle[7]):
                m.d.sync += [*become(one, left), *become(other, to_left)]
            with m.Case(cycle[8]):
                m.d.sync += [*become(one, to_right), *become(other, right)]
            with m.Case(cycle[9]):
                with m.If(~narrows | is_negative):
                    m.d.sync += become(left, to_left)
            with m.Case(cycle[10]):
                with m.If(~narrows | is_negative):
                    m.d.sync += become(right, to_right)
                m.d.sync += [narrows.eq(1), before.eq(self.place)]

        return m


class Route(Unit):
    """Follows the minimum costs from the start to the goal, and stores the blocks.

    The next block is the first of the eight neighbours, by rows, that has the minimum cost; one
    neighbour is read per cycle. If the start has no route to the goal, the result is a straight
    line of 64 blocks, without turns. ``busy`` is high for as many cycles as
    :func:`pathgene.sim.model.planner.run_cycles.routing` says. Equals ``descend`` and ``turns_of``
    of :mod:`pathgene.sim.model.planner.definition.wavefront`.

    Members
    -------
    start, goal : In(place_layout)
        Blocks. Steady.
    fine : In(1)
        The map has 64 x 64 blocks; otherwise 32 x 32. Steady.
    launch : In(1)
        Pulse: begin. Not while ``busy``.
    busy : Out(1)
    length : Out(13)
        Number of blocks of the route, including start and goal.
    turns : Out(range(max_waypoints + 2))
        Number of its turns, or one more than a path has waypoints if there are more.
    read_block : Out(12)
        Block to read from the wavefront.
    surface : In(surface_layout)
    cost : In(31)
        That block, 2 cycles later.
    before, after : Out(altitude_bits)
        Altitudes of a step to price.
    prices : In(31).array(3)
        Cost of the step in x, in y, and diagonally, 5 cycles later.
    number : In(12)
        Number of a block of the route, or of a turn, to read while not ``busy``.
    of_turns : In(1)
        ``number`` is the number of a turn. Steady.
    place : Out(place_layout)
        That block, 2 cycles later.
    """

    altitude_bits: Width(1)
    max_waypoints: Count(2, text="Waypoints of the longest path.")

    #: Cycles for a block with a route to the goal, including the last one.
    step_cycles = len(_STEPS) + _SUMMED + 1

    def interface(self):
        return {
            "start": In(place_layout),
            "goal": In(place_layout),
            "fine": In(1),
            "launch": In(1),
            "busy": Out(1),
            "length": Out(INDEX_BITS + 1),
            "turns": Out(range(self.max_waypoints + 2)),
            "read_block": Out(INDEX_BITS),
            "surface": In(surface_layout(self.altitude_bits)),
            "cost": In(COST_BITS),
            "before": Out(self.altitude_bits),
            "after": Out(self.altitude_bits),
            "prices": In(COST_BITS).array(3),
            "number": In(INDEX_BITS),
            "of_turns": In(1),
            "place": Out(place_layout),
        }

    def elaborate(self, platform):
        m = Module()

        here = Signal(place_layout, reset_less=True)
        count = Signal(range(self.step_cycles))

        m.submodules.places = places = memory.Memory(
            shape=place_layout, depth=BLOCKS**2, init=[], attrs={"no_rw_check": 1}
        )
        write, read = places.write_port(), places.read_port()
        m.d.comb += [
            write.addr.eq(self.length),
            write.data.eq(here),
            read.addr.eq(self.number),
        ]

        best_place, is_stuck = self._best(m, here, count)

        # The straight line: the start plus the differences times the number of the block.
        line = {
            axis: Signal(BLOCK_BITS + _STRAIGHT_BITS, name=f"line_{axis}", reset_less=True)
            for axis in "xy"
        }
        way = {axis: Signal(signed(BLOCK_BITS + 1), name=f"way_{axis}") for axis in "xy"}
        m.d.sync += [way[axis].eq(self.goal[axis] - self.start[axis]) for axis in "xy"]
        with m.FSM() as states:
            with m.State("IDLE"):
                with m.If(self.launch):
                    m.d.sync += [
                        here.eq(self.start),
                        self.length.eq(0),
                        count.eq(0),
                        *(line[axis].eq(self.start[axis] << _STRAIGHT_BITS) for axis in "xy"),
                    ]
                    m.next = "STEP"
            with m.State("STEP"):
                m.d.sync += count.eq(count + 1)
                with m.If((count == _READ) & is_stuck):
                    # No neighbour may stay in the pipeline to the sum, where the next route would
                    # take it.
                    m.d.sync += count.eq(0)
                    m.next = "STRAIGHT"
                with m.Elif(count == self.step_cycles - 1):
                    m.d.comb += write.en.eq(1)
                    m.d.sync += [
                        self.length.eq(self.length + 1),
                        here.eq(best_place),
                        count.eq(0),
                    ]
                    with m.If(here == self.goal):
                        m.next = "IDLE"
            with m.State("STRAIGHT"):
                m.d.comb += write.en.eq(1)
                m.d.sync += self.length.eq(self.length + 1)
                for axis, each in line.items():
                    further = (each + way[axis])[: len(each)]
                    m.d.sync += [each.eq(further), here[axis].eq(further >> _STRAIGHT_BITS)]
                with m.If(self.length == _STRAIGHT - 1):
                    m.next = "IDLE"
        m.d.comb += self.busy.eq(~states.ongoing("IDLE"))

        # A block is examined while the next one is sought.
        turn = self._find_turns(m, here, states.ongoing("STEP") & (count == 0))
        place = Mux(self.of_turns, turn, read.data.as_value())
        m.d.comb += self.place.eq(delay_line(m, place, 1, "place"))

        return m

    def _find_turns(self, m, here, steps):
        """Store the turns; return the one whose number was given in the previous cycle."""
        m.submodules.finder = finder = TurnFinder()
        assert TurnFinder.cycles < self.step_cycles
        m.submodules.stored_turns = stored = memory.Memory(
            shape=place_layout, depth=self.max_waypoints, init=[]
        )
        write, read = stored.write_port(), stored.read_port(domain="comb")
        is_start = self.length == 0
        m.d.comb += [
            finder.place.eq(here),
            finder.begin.eq(steps & is_start),
            finder.advance.eq(steps & ~is_start),
            write.addr.eq(self.turns),
            write.data.eq(finder.turn),
            write.en.eq(finder.found & (self.turns != self.max_waypoints)),
            read.addr.eq(self.number),
        ]
        with m.If(self.launch):
            m.d.sync += self.turns.eq(0)
        with m.Elif(finder.found & (self.turns != self.max_waypoints + 1)):
            m.d.sync += self.turns.eq(self.turns + 1)
        return delay_line(m, read.data.as_value(), 1, "turn")

    def _best(self, m, here, count):
        """Return the best of the neighbours read, and whether the block just read has no route."""
        # The step of the previous cycle: its neighbour, whether it exists, and its direction.
        place = Signal(place_layout, reset_less=True)
        exists = Signal()
        way = Signal(2, reset_less=True)
        last = Mux(self.fine, BLOCKS - 1, COARSE_BLOCKS - 1)
        inside = [{-1: at.any(), 0: Const(1), 1: at != last} for at in (here.x, here.y)]
        m.d.sync += exists.eq(0)
        with m.Switch(count):
            for i, (x, y, index) in enumerate(_STEPS):
                with m.Case(i):
                    m.d.sync += [
                        place.x.eq(here.x + x),
                        place.y.eq(here.y + y),
                        exists.eq(inside[0][x] & inside[1][y] & int(i > 0)),
                        way.eq(index),
                    ]
        m.d.comb += self.read_block.eq(Cat(place.x, place.y))

        before = Signal(self.altitude_bits, reset_less=True)
        with m.If(count == _READ):
            m.d.sync += before.eq(self.surface.altitude)
        m.d.comb += [
            self.before.eq(before),
            self.after.eq(delay_line(m, self.surface.altitude, 1, "after")),
        ]

        # The cost of a missing neighbour is above any other.
        price = Signal(COST_BITS)
        with m.Switch(delay_line(m, way, _PRICED - 1, "way")):
            for index in range(3):
                with m.Case(index):
                    m.d.comb += price.eq(self.prices[index])
        cost = delay_line(m, self.cost, _PRICED - _READ, "cost")
        total = delay_line(m, price + cost, 1, "total")
        counts = delay_line(m, exists, _SUMMED - 1, "exists")
        at = delay_line(m, place, _SUMMED - 1, "at")

        best = Signal(range(FAR + 1), reset_less=True)
        best_place = Signal(place_layout, reset_less=True)
        with m.If(count == 0):
            m.d.sync += best.eq(FAR)
        with m.Elif(counts & (total < best)):
            m.d.sync += [best.eq(total), best_place.eq(at)]
        return best_place, self.cost == FAR
