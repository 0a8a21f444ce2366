"""Genetic core: population, draws, and one generation at a time."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import CheckerBuild, Config
from hdl.control import Control, clocks_layout, counters_layout
from hdl.ga_core.layouts import limits_layout, mutation_layout
from hdl.ga_core.mutation import Mutation
from hdl.ga_core.population import Population
from hdl.ga_core.selection import Selection
from hdl.ga_core.slot_mapping import SlotMapping
from hdl.layouts import ranking_layout, read_layout, start_layout, waypoint_layout, write_layout
from hdl.primitives.skid_buffer import SkidBuffer
from hdl.protocol import ChipState


__all__ = ["Core"]


class Core(wiring.Component):
    """The genetic core; equal to :class:`sim.model.core.Core` bit for bit and clock for clock.

    A generation takes the clocks of the longest path that is kept or bred, plus 4: 20 for paths of
    16 waypoints. With a map, new waypoints in the ground are refused, one look at the map a clock,
    while the waypoints pass: no further clocks where paths are long. Only if that takes longer, a
    generation takes ``n + config.lookup_latency + 6`` clocks, where ``n``, at most ``patches *
    candidates``, is how many candidates it took to decide all new waypoints: 13 in the default
    sizes if no first candidate lies in the ground, and at most 19. (Three redraws would keep within
    the 24 clocks that are asked for; seven of them may take 34.)

    ``ranking`` comes before a generation, after all ``starts`` and ``writes``, which make an
    earlier one void, as does a generation; ranks come upwards from 0, and each slot once.

    ``starts``, ``writes``, ``ranking`` and ``reads`` are taken only while no generation runs;
    besides, ``ranking`` waits for a complete set of draws, and ``writes`` for the end of a read.

    Source: *allaire-2008*, section 4.

    Parameters
    ----------
    config : Config
        Sizes of the chip.

    Members
    -------
    starts : In(stream.Signature(start_layout))
        Seed of the random source, highest values of new waypoints, which must be within the map,
        and whether those in the ground are refused, which matters only with a map. The number of
        the generation and the longest become 0. The population stays.
    writes : In(stream.Signature({"slot", "index", "waypoint", "last": 1}))
        A waypoint for a slot of the present population; ``last`` sets the length of the path.
    ranking : In(stream.Signature({"rank", "slot"}))
        Slot of each rank, 0 the best.
    ranked : Out(1)
        A whole ranking has been worked in: a generation may start. It is high ``mutators + 13``
        clocks after the last rank, with a map ``mutators + patches + 18``, if no read is under way.
    reads : In(stream.Signature({"slot", "count"}))
        Consecutive slots to read out.
    waypoints : Out(stream.Signature({"waypoint", "last": 1, "final": 1}))
        Their waypoints; ``last`` marks the end of a path, ``final`` that of the last one.
        The first is there 5 clocks after a read is taken, then one a clock, 3 clocks between paths.
    pending, receive_on, receive_over, generate, check, check_on, check_over, transmit_on,
    transmit_over, line_busy, line_sending
        See :class:`hdl.control.Control`.
    state, history, generation, clocks, counters
        See there; ``generation`` counts from the latest of ``starts``.
    parents : Out(slot_bits).array(crossovers)
    survivors : Out(slot_bits).array(survivors)
        Slots, before the update, of the parents and of the survivors of the latest generation.
    mutations : Out(mutation_layout).array(mutators)
        What each mutator did in the latest generation.
    patches : Out(waypoint_bits).array(patches)
        The waypoints that the perturbing, then the inserting mutators made; 0 if not applied.
    lookup_valid, lookup_x, lookup_y, lookup_altitude
        Only with a map: see :class:`hdl.ga_core.terrain_aware_sampler.TerrainAwareSampler`. Only
        while a generation runs.
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        lookup = {
            "lookup_valid": Out(1),
            "lookup_x": Out(config.coordinate_bits),
            "lookup_y": Out(config.coordinate_bits),
            "lookup_altitude": In(config.altitude_bits),
        }
        super().__init__(
            {
                "starts": In(stream.Signature(start_layout(config))),
                "writes": In(stream.Signature(write_layout(config))),
                "ranking": In(stream.Signature(ranking_layout(config))),
                "ranked": Out(1),
                "reads": In(stream.Signature(read_layout(config))),
                "waypoints": Out(stream.Signature(waypoint_layout(config))),
                "pending": In(1),
                "receive_on": Out(1),
                "receive_over": In(1),
                "generate": In(1),
                "check": In(1),
                "check_on": Out(1),
                "check_over": In(1),
                "transmit_on": Out(1),
                "transmit_over": In(1),
                "line_busy": In(1),
                "line_sending": In(1),
                "state": Out(ChipState),
                "history": Out(32),
                "generation": Out(32),
                "clocks": Out(clocks_layout(config)),
                "counters": Out(counters_layout(config)),
                "parents": Out(config.slot_bits).array(config.crossovers),
                "survivors": Out(config.slot_bits).array(config.survivors),
                "mutations": Out(mutation_layout(config)).array(config.mutators),
                "patches": Out(config.waypoint_bits).array(config.patches),
                **(lookup if config.checker is not CheckerBuild.NONE else {}),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        kept = config.elites + config.survivors

        m.submodules.control = control = Control(config)
        m.submodules.selection = selection = Selection(config)
        m.submodules.mapping = mapping = SlotMapping(config)
        m.submodules.population = population = Population(config)
        m.submodules.mutation = mutation = Mutation(config)

        # A ranking is worked in by the mapping, then by the mutators; other orders make it void.
        # What they do to the whole core begins in registers: the wires are long enough.
        allow = Signal()
        started = Signal()
        start = Signal.like(self.starts.p, reset_less=True)
        overtaken = Signal()
        void = Signal()
        planned = Signal()
        m.d.comb += [
            allow.eq(~control.generating),
            self.starts.ready.eq(allow),
            mapping.allow.eq(allow & selection.ready),
            void.eq(control.update_on | overtaken),
            mapping.clear.eq(void),
            mutation.clear.eq(void),
            self.ranked.eq(planned & population.settled & ~overtaken),
        ]
        m.d.sync += [
            started.eq(self.starts.valid & self.starts.ready),
            start.eq(self.starts.p),
            overtaken.eq(
                (self.starts.valid & self.starts.ready)
                | (self.writes.valid & self.writes.ready)
                | (self.ranking.valid & self.ranking.ready & (self.ranking.p.rank == 0))
            ),
        ]
        with m.If(void):
            m.d.sync += planned.eq(0)
        with m.Elif(mutation.planned):
            m.d.sync += planned.eq(1)

        limits = Signal(
            limits_layout(config),
            init={
                "x": config.map_size - 1,
                "y": config.map_size - 1,
                "altitude": config.blocked_altitude - 1,
            },
        )
        with m.If(started):
            m.d.sync += [limits[axis].eq(start[axis]) for axis in ("x", "y", "altitude")]
        m.d.comb += [
            selection.seed.eq(self.starts.p.seed),
            selection.load.eq(self.starts.valid & self.starts.ready),
            selection.next.eq(control.update_on),
        ]

        connect(m, flipped(self.ranking), mapping.ranking)
        m.d.comb += [
            mapping.parents.eq(selection.parents),
            mapping.survivors.eq(selection.survivors),
            *_each(mapping.lengths, population.lengths),
        ]

        connect(m, flipped(self.writes), population.writes)
        connect(m, flipped(self.reads), population.reads)
        # Whether a waypoint is taken is said late, and from afar.
        m.submodules.skid = skid = SkidBuffer(self.waypoints.payload.shape())
        connect(m, population.read_waypoints, skid.words)
        connect(m, skid.passed, flipped(self.waypoints))
        m.d.comb += [
            population.allow.eq(allow),
            population.starts.eq(control.starts),
            population.update.eq(control.update_on),
            *_each(population.carried, mapping.carried),
            *_each(population.patches, mutation.patches),
            *_each(population.mutations, mutation.doing),
        ]

        parents = mapping.carried[kept:]
        passing = population.waypoints[kept:]
        if config.checker is CheckerBuild.NONE:
            m.d.comb += [
                mutation.offsets.eq(selection.offsets),
                mutation.carrying.eq(population.carrying),
                mutation.position.eq(population.position),
            ]
        else:
            # A register of its own for what is the crossover and the mutation to the control unit.
            run = Signal()
            ran = Signal()
            m.d.comb += run.eq(control.begin | (ran & ~mutation.over))
            m.d.sync += ran.eq(run)
            avoid_ground = Signal()
            with m.If(started):
                m.d.sync += avoid_ground.eq(start.avoid_ground)
            m.d.comb += [
                mutation.settled.eq(population.settled),
                population.peeks.eq(mutation.peeks),
                population.peek.eq(mutation.peek),
                population.peek_position.eq(mutation.peek_position),
                mutation.run.eq(run),
                mutation.avoid.eq(avoid_ground),
                mutation.offset.eq(selection.offsets[0]),
                selection.offset_taken.eq(mutation.offset_taken),
                self.lookup_valid.eq(mutation.lookup_valid),
                self.lookup_x.eq(mutation.lookup_x),
                self.lookup_y.eq(mutation.lookup_y),
                mutation.lookup_altitude.eq(self.lookup_altitude),
                control.redrawn.eq(mutation.redrawn),
                control.left_out.eq(mutation.left_out),
            ]
        m.d.comb += [
            mutation.start.eq(mapping.mapped),
            mutation.children.eq(selection.children),
            mutation.draws.eq(selection.waypoints),
            mutation.limits.eq(limits),
            mutation.on.eq(control.mutation_on),
            *_each(mutation.lengths, (parent.length for parent in parents)),
            *_each(mutation.waypoints, passing),
            *_each(self.mutations, mutation.mutations),
            *_each(self.patches, mutation.patches),
        ]

        # The next ranking overwrites the mapping, perhaps with slots that make no generation.
        survivors = mapping.carried[config.elites : kept]
        with m.If(control.update_on):
            m.d.sync += [
                *_each(self.survivors, (survivor.slot for survivor in survivors)),
                *_each(self.parents, (parent.slot for parent in parents)),
            ]

        for name in (
            "pending",
            "receive_over",
            "generate",
            "check",
            "check_over",
            "transmit_over",
            "line_busy",
            "line_sending",
        ):
            m.d.comb += getattr(control, name).eq(getattr(self, name))
        for name in (
            "receive_on",
            "check_on",
            "transmit_on",
            "state",
            "history",
            "generation",
            "clocks",
            "counters",
        ):
            m.d.comb += getattr(self, name).eq(getattr(control, name))
        m.d.comb += [
            control.ready.eq(self.ranked),
            control.restart.eq(started),
            control.crossover_over.eq(population.over),
            control.mutation_over.eq(mutation.over),
            control.update_over.eq(1),
            control.refused.eq(mutation.refused),
        ]

        return m


def _each(targets, sources):
    """Return the assignments of each of ``sources`` to its target."""
    return [target.eq(source) for target, source in zip(targets, sources, strict=True)]
