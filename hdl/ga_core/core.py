"""Paper core: the population, the random draws, and one generation at a time."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.ga_core.layouts import limits_layout, mutation_layout
from pathgene.hdl.ga_core.mutation import Mutation
from pathgene.hdl.ga_core.population import Population
from pathgene.hdl.ga_core.selection import Selection
from pathgene.hdl.ga_core.slot_mapping import SlotMapping
from pathgene.hdl.layouts import (
    generation_signature,
    ranking_layout,
    read_layout,
    start_layout,
    waypoint_layout,
    write_layout,
)
from pathgene.hdl.primitives.buffers import SkidBuffer
from pathgene.hdl.primitives.logic import assign_each
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["PaperCore"]


class PaperCore(Unit):
    """The paper core. With a control unit, it equals the model's ``PaperCore`` in every cycle.

    A generation takes 4 cycles plus one per waypoint of the longest path kept or bred: 20 for paths
    of 16 waypoints. With a map, new waypoints in the ground are rejected, at one lookup per cycle,
    while the waypoints pass; long paths need no more cycles. Short paths may: a generation takes at
    least ``n + config.lookup_latency + 6`` cycles, where ``n``, at most ``patches * candidates``,
    is the number of candidates until all new waypoints are decided. With the default sizes, that is
    13 cycles if no first candidate lies in the ground, and at most 19. (With three redraws it stays
    within the required 24 cycles; with seven it may take 34.)

    ``ranking`` precedes a generation and follows all ``start_requests`` and ``writes``; these, and
    a generation, discard an earlier ranking. Ranks arrive in increasing order from 0, and each slot
    once.

    ``start_requests``, ``writes``, ``ranking`` and ``reads`` are only accepted while no generation
    runs; in addition, ``ranking`` waits for a complete set of draws, and ``writes`` wait for the
    end of a read.

    Source: *allaire-2008*, section 4.

    Members
    -------
    start_requests : In(stream.Signature(start_layout))
        Seed of the random source, maximum values of new waypoints, which must be within the map,
        and whether waypoints in the ground are rejected, which only matters with a map. The
        generation number becomes 0. The population stays.
    writes : In(stream.Signature(write_layout))
        A waypoint for a slot of the current population; ``last`` sets the length of the path.
    ranking : In(stream.Signature(ranking_layout))
        Slot of each rank; 0 is the best.
    control : In(generation_signature)
        Handshakes with the control unit. ``ready`` means that a whole ranking is processed. It
        rises ``mutators + 13`` cycles after the last rank, or ``mutators + patches + 18`` with a
        map, if no read is in flight.
    reads : In(stream.Signature(read_layout))
        Consecutive slots to read.
    waypoints : Out(stream.Signature(waypoint_layout))
        Their waypoints. The first follows 5 cycles after a read is accepted, then one per cycle,
        with 3 cycles between paths.
    parents : Out(slot_bits).array(crossovers)
    survivors : Out(slot_bits).array(survivors)
        Slots, before the update, of the parents and of the survivors of the latest generation.
    mutations : Out(mutation_layout).array(mutators)
        Work of each mutator in the latest generation.
    patches : Out(waypoint_bits).array(patches)
        New waypoints of the perturbing, then of the inserting mutators; 0 if not applied.
    lookup_valid, lookup_x, lookup_y, lookup_altitude
        Only with a map: see
        :class:`pathgene.hdl.ga_core.terrain_aware_sampler.TerrainAwareSampler`. Used only while a
        generation runs.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.has_map = config.checker is not CheckerBuild.NONE
        lookup = {
            "lookup_valid": Out(1),
            "lookup_x": Out(config.coordinate_bits),
            "lookup_y": Out(config.coordinate_bits),
            "lookup_altitude": In(config.altitude_bits),
        }
        return {
            "start_requests": In(stream.Signature(start_layout(config))),
            "writes": In(
                stream.Signature(
                    write_layout(config.slot_bits, config.index_bits, config.waypoint_bits)
                )
            ),
            "ranking": In(stream.Signature(ranking_layout(config.slot_bits))),
            "control": In(generation_signature(config)),
            "reads": In(stream.Signature(read_layout(config.slot_bits))),
            "waypoints": Out(stream.Signature(waypoint_layout(config.waypoint_bits))),
            "parents": Out(config.slot_bits).array(config.crossovers),
            "survivors": Out(config.slot_bits).array(config.survivors),
            "mutations": Out(mutation_layout(config.children, config.max_waypoints)).array(
                config.mutators
            ),
            "patches": Out(config.waypoint_bits).array(config.patches),
            **(lookup if self.has_map else {}),
        }

    def elaborate(self, platform):
        m = Module()
        config, control = self.config, self.control
        kept = config.elites + config.survivors

        m.submodules.selection = selection = Selection(config)
        m.submodules.mapping = mapping = SlotMapping(
            population=config.population,
            elite_ports=config.elites,
            survivor_ports=config.survivors,
            parent_ports=config.crossovers,
            max_waypoints=config.max_waypoints,
        )
        m.submodules.population = population = Population(config)
        m.submodules.mutation = mutation = Mutation(config)

        allow = Signal()
        m.d.comb += allow.eq(~control.generating)
        request = self._start(m, allow, selection, mutation)
        self._rank(m, allow, selection, mapping, population, mutation)

        connect(m, flipped(self.writes), population.writes)
        connect(m, flipped(self.reads), population.reads)
        # `waypoints.ready` arrives late; a skid buffer breaks the path.
        m.submodules.skid = skid = SkidBuffer(self.waypoints.payload.shape())
        connect(m, population.read_waypoints, skid.words)
        connect(m, skid.passed, flipped(self.waypoints))
        m.d.comb += [
            population.allow.eq(allow),
            population.launch.eq(control.launch),
            population.update.eq(control.update_on),
            assign_each(population.carried, mapping.carried),
            assign_each(population.patches, mutation.patches),
            assign_each(population.mutations, mutation.results),
        ]

        parents = mapping.carried[kept:]
        m.d.comb += [
            mutation.start.eq(mapping.mapped),
            mutation.children.eq(selection.children),
            mutation.draws.eq(selection.waypoints),
            mutation.on.eq(control.mutation_on),
            assign_each(mutation.lengths, (parent.length for parent in parents)),
            assign_each(mutation.waypoints, population.waypoints[kept:]),
            assign_each(self.mutations, mutation.mutations),
            assign_each(self.patches, mutation.patches),
        ]
        if self.has_map:
            self._search(m, request, selection, population, mutation)
        else:
            m.d.comb += [
                mutation.offsets.eq(selection.offsets),
                mutation.carrying.eq(population.carrying),
                mutation.position.eq(population.position),
            ]

        # The next ranking overwrites the mapping, perhaps without a generation.
        survivors = mapping.carried[config.elites : kept]
        with m.If(control.update_on):
            m.d.sync += [
                assign_each(self.survivors, (survivor.slot for survivor in survivors)),
                assign_each(self.parents, (parent.slot for parent in parents)),
            ]
        m.d.comb += [
            control.crossover_done.eq(population.done),
            control.mutation_done.eq(mutation.done),
            control.update_done.eq(1),
            control.refused.eq(mutation.refused),
        ]

        return m

    def _start(self, m, allow, selection, mutation):
        """Accept requests for a new run; return the latest."""
        config, control = self.config, self.control

        request = Signal.like(self.start_requests.p, reset_less=True)
        m.d.comb += self.start_requests.ready.eq(allow)
        m.d.sync += [
            control.restart.eq(self.start_requests.valid & self.start_requests.ready),
            request.eq(self.start_requests.p),
        ]
        limits = Signal(
            limits_layout(config.coordinate_bits, config.altitude_bits),
            init={
                "x": config.map_size - 1,
                "y": config.map_size - 1,
                "altitude": config.blocked_altitude - 1,
            },
        )
        with m.If(control.restart):
            m.d.sync += [limits[axis].eq(request[axis]) for axis in ("x", "y", "altitude")]
        m.d.comb += [
            selection.seed.eq(self.start_requests.p.seed),
            selection.load.eq(self.start_requests.valid & self.start_requests.ready),
            selection.next.eq(control.update_on),
            mutation.limits.eq(limits),
        ]
        return request

    def _rank(self, m, allow, selection, mapping, population, mutation):
        """Pass a ranking to the mapping, then to the mutators; later commands discard it."""
        control = self.control

        # Registers drive everything that reaches the whole core, because those wires are long.
        superseded = Signal()
        discard = Signal()
        planned = Signal()
        connect(m, flipped(self.ranking), mapping.ranking)
        m.d.comb += [
            mapping.allow.eq(allow & selection.ready),
            mapping.parents.eq(selection.parents),
            mapping.survivors.eq(selection.survivors),
            assign_each(mapping.lengths, population.lengths),
            discard.eq(control.update_on | superseded),
            mapping.clear.eq(discard),
            mutation.clear.eq(discard),
            control.ready.eq(planned & population.settled & ~superseded),
        ]
        m.d.sync += superseded.eq(
            (self.start_requests.valid & self.start_requests.ready)
            | (self.writes.valid & self.writes.ready)
            | (self.ranking.valid & self.ranking.ready & (self.ranking.p.rank == 0))
        )
        with m.If(discard):
            m.d.sync += planned.eq(0)
        with m.Elif(mutation.planned):
            m.d.sync += planned.eq(1)

    def _search(self, m, request, selection, population, mutation):
        """Connect the search for new waypoints above the ground."""
        control = self.control

        # `running` is high during crossover and mutation, `run` a cycle earlier.
        run = Signal()
        running = Signal()
        m.d.comb += run.eq(control.begin | (running & ~mutation.done))
        m.d.sync += running.eq(run)
        avoid_ground = Signal()
        with m.If(control.restart):
            m.d.sync += avoid_ground.eq(request.avoid_ground)
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
