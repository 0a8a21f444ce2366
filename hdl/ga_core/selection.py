"""The selection unit: draws a whole set while the previous generation runs."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import CheckerBuild, Config, SurvivorSelection
from pathgene.hdl.ga_core.distinct_draw import DistinctDraw
from pathgene.hdl.ga_core.layouts import offset_layout
from pathgene.hdl.ga_core.random_source import RandomSource
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.random_words import SEED_BITS, RandomWordLayout


__all__ = ["Selection"]


class Selection(Unit):
    """Draws all random numbers of a generation.

    The draws of a set equal the draws of :class:`pathgene.sim.model.selection.Selection`: crossover
    ranks are independent with P(r) = (2 (N - r) - 1) / N**2; survivors and children are distinct.
    The random source advances ``config.draw_steps`` steps per set and never otherwise, so the set
    of generation ``g`` is a function of the seed and ``g``.

    A set is ready :attr:`latency` cycles after ``next`` (15 in the default configuration, 18 with a
    map), and ``WARM_UP_STEPS + latency`` cycles after ``load``. After reset, the set of generation
    0 and seed 0 is ready ``WARM_UP_STEPS + latency - 1`` cycles later.

    Source: *allaire-2008*, sections 4.1 and 4.4: a fixed roulette by rank. Difference: the paper's
    addresses change every cycle; here there is one set per generation, so that a run can be
    repeated. The smaller of two uniform draws has exactly the roulette's distribution.

    Members
    -------
    seed : In(64)
        Sampled with ``load``.
    load : In(1)
        Start again from ``seed``, at any time: the next set belongs to generation 0.
    next : In(1)
        Draw another set. Ignored while not ``ready``.
    ready : Out(1)
        The outputs below are a complete set. They stay while ``ready`` is high and no offset is
        taken.
    parents : Out(data.ArrayLayout(config.slot_bits, config.crossovers))
        Rank of each parent; 0 is the best.
    survivors : Out(data.ArrayLayout(config.slot_bits, config.survivors))
        Distinct ranks, ``elites`` to ``population - 1``.
    children : Out(data.ArrayLayout(config.child_bits, config.mutators))
        Distinct children, one for each mutator.
    waypoints : Out(data.ArrayLayout(16, config.mutators))
        Fraction of its child's length at which each mutator works.
    offsets : Out(data.ArrayLayout(offset_layout, config.patches * config.candidates))
        Signed ``x`` and ``y`` in cells and ``altitude`` in steps, each within the mutation box: for
        the first candidate of every patch, then for the second, and so on.
    offset_taken : In(1)
        Only with a map: the first of ``offsets`` has been used. The rest moves up by one place,
        until the next set. Only while ``ready``.

    Attributes
    ----------
    latency : int
        Cycles from ``next`` to ``ready``.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.draw_layout = RandomWordLayout(config)
        self.latency = 2 + max(
            config.crossovers + 1,
            config.survivors + DistinctDraw.LATENCY,
            config.mutators + DistinctDraw.LATENCY,
            config.mutators + config.patches * config.candidates + 2,
        )
        self.boxes = {"x": config.box_cells, "y": config.box_cells, "altitude": config.box_steps}
        offsets = data.ArrayLayout(
            offset_layout(config.box_cells, config.box_steps), config.patches * config.candidates
        )
        return {
            "seed": In(SEED_BITS),
            "load": In(1),
            "next": In(1),
            "ready": Out(1),
            "parents": Out(data.ArrayLayout(config.slot_bits, config.crossovers)),
            "survivors": Out(data.ArrayLayout(config.slot_bits, config.survivors)),
            "children": Out(data.ArrayLayout(config.child_bits, config.mutators)),
            "waypoints": Out(data.ArrayLayout(RandomWordLayout.OFFSET_BITS, config.mutators)),
            "offsets": Out(offsets),
            **({} if config.checker is CheckerBuild.NONE else {"offset_taken": In(1)}),
        }

    def elaborate(self, platform):
        m = Module()
        config, at = self.config, self.draw_layout

        # Cycles since `next`, minus two: step i of the source is taken in cycle i. `step` enables
        # the whole state and is therefore a register, like `begin`.
        cycle = Signal(range(self.latency))
        step = Signal(init=1)
        begins, begin = Signal(), Signal(init=1)
        m.submodules.source = source = RandomSource()
        # The source has no reset, so it is loaded with 0 after a reset.
        load, seed = Signal(init=1), Signal(SEED_BITS, reset_less=True)
        m.d.sync += [begin.eq(begins), load.eq(self.load), seed.eq(Mux(self.load, self.seed, 0))]
        m.d.comb += [
            begins.eq(self.load | self.next & self.ready),
            source.seed.eq(seed),
            source.load.eq(load),
            source.step.eq(step),
        ]
        with m.If(begin):
            m.d.sync += [cycle.eq(0), step.eq(1)]
        with m.Elif(source.ready & ~self.ready):
            m.d.sync += [
                cycle.eq(cycle + 1),
                step.eq(cycle < config.draw_steps - 1),
                self.ready.eq(cycle == self.latency - 3),
            ]
        with m.If(begins):
            m.d.sync += self.ready.eq(0)

        # Registers of the words, with a flag for each use.
        by_rank = config.survivor_selection is SurvivorSelection.RANK
        selection_bits = Signal(
            (at.survivor_second if by_rank else at.survivor_first)[1], reset_less=True
        )
        mutation_bits = Signal(max(at.waypoint[1], at.offsets[-1][1]), reset_less=True)
        draws = source.ready & ~begin
        takes_parent = Signal()
        takes_survivor = Signal()
        takes_child = Signal()
        takes_offset = Signal()
        offsets_end = config.mutators + config.patches * config.candidates
        m.d.sync += [
            selection_bits.eq(source.words[0]),
            mutation_bits.eq(source.words[1]),
            takes_parent.eq(draws & (cycle < config.crossovers)),
            takes_survivor.eq(draws & (cycle < config.survivors)),
            takes_child.eq(draws & (cycle < config.mutators)),
            takes_offset.eq((cycle >= config.mutators) & (cycle < offsets_end)),
        ]

        first = selection_bits[slice(*at.rank_first)]
        second = selection_bits[slice(*at.rank_second)]
        parents = Signal.like(self.parents, reset_less=True)
        m.d.comb += self.parents.eq(parents)
        with m.If(takes_parent):
            m.d.sync += _append(parents, Mux(first < second, first, second))

        # One cycle after `begin`, to discard a draw that was in the register, and after a reset.
        clear = Signal(init=1)
        m.d.sync += clear.eq(begin)

        m.submodules.survivor_draw = survivor_draw = DistinctDraw(
            total=config.population - config.elites,
            count=config.survivors,
            draw_bits=RandomWordLayout.DISTINCT_BITS,
            first=config.elites,
            best_of=2 if by_rank else 1,
        )
        m.d.comb += [
            survivor_draw.clear.eq(clear),
            survivor_draw.take.eq(takes_survivor),
            survivor_draw.bits.eq(selection_bits[at.survivor_first[0] :]),
            self.survivors.eq(survivor_draw.numbers),
        ]

        m.submodules.child_draw = child_draw = DistinctDraw(
            total=config.children,
            count=config.mutators,
            draw_bits=RandomWordLayout.DISTINCT_BITS,
        )
        m.d.comb += [
            child_draw.clear.eq(clear),
            child_draw.take.eq(takes_child),
            child_draw.bits.eq(mutation_bits[slice(*at.child)]),
            self.children.eq(child_draw.numbers),
        ]
        waypoints = Signal.like(self.waypoints, reset_less=True)
        m.d.comb += self.waypoints.eq(waypoints)
        with m.If(takes_child):
            m.d.sync += _append(waypoints, mutation_bits[slice(*at.waypoint)])

        scaled = Signal(
            data.StructLayout({name: range(2 * box + 1) for name, box in self.boxes.items()}),
            reset_less=True,
        )
        offset = Signal(offset_layout(config.box_cells, config.box_steps))
        for (name, box), (low, high) in zip(self.boxes.items(), at.offsets, strict=True):
            m.d.sync += scaled[name].eq(mutation_bits[low:high] * (2 * box + 1) >> (high - low))
            m.d.comb += offset[name].eq(scaled[name] - box)
        takes_scaled = Signal()
        m.d.sync += takes_scaled.eq(takes_offset)
        shifts = takes_scaled
        if config.checker is not CheckerBuild.NONE:
            # The offset shifted in at the end is undefined.
            shifts = takes_scaled | self.offset_taken
        offsets = Signal.like(self.offsets, reset_less=True)
        m.d.comb += self.offsets.eq(offsets)
        with m.If(shifts):
            m.d.sync += _append(offsets, offset.as_value())

        return m


def _append(items, item):
    """Return the assignment that shifts in ``item`` at the end and shifts out the first item."""
    return items.eq(Cat(items.as_value()[len(item) :], item))
