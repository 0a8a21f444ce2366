"""Mutation unit: perturbs, inserts and deletes waypoints of children while they are bred."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.ga_core.layouts import limits_layout, mutation_layout, offset_layout
from pathgene.hdl.ga_core.mutator import MutationPlan, Mutator, WaypointPerturber
from pathgene.hdl.ga_core.terrain_aware_sampler import TerrainAwareSampler
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.random_words import RandomWordLayout


__all__ = ["Mutation"]

#: Members shared with the sampler.
_MAP_INPUTS = ("settled", "run", "avoid", "offset", "lookup_altitude")
_MAP_OUTPUTS = (
    "peeks",
    "peek",
    "peek_position",
    "offset_taken",
    "lookup_valid",
    "lookup_x",
    "lookup_y",
)


class Mutation(Unit):
    """All mutators of the chip, which work at the same time.

    They plan before a generation: ``planned`` is high :attr:`latency` cycles after ``start``. A
    mutation that a length limit forbids is not applied, and is counted in ``refused``.

    Without a map, the mutators take their waypoints from the ports during crossover, and the
    mutation takes 2 cycles.

    With a map, these waypoints are read ahead after the planning, and :class:`TerrainAwareSampler`
    looks for new ones above the ground. The mutation takes 2 cycles, or longer until
    ``n + config.lookup_latency + 6`` cycles have passed since ``run`` rose, where ``n`` is the
    number of candidates until all new waypoints are decided. A mutation without a candidate above
    the ground is not applied, and is counted in ``left_out``.

    Source: *allaire-2008*, section 4.6.

    Members
    -------
    start : In(1)
        All inputs up to ``lengths`` are complete. They must stay until ``done``.
    clear : In(1)
        Discard a plan in flight. Overrides ``start``.
    children : In(ArrayLayout(child_bits, mutators))
    draws : In(ArrayLayout(16, mutators))
        From the selection unit.
    lengths : In(length_bits).array(crossovers)
        Length of each parent.
    planned : Out(1)
        Pulse: a generation may start.
    limits : In(limits_layout)
    waypoints : In(waypoint_bits).array(crossovers)
        Current waypoint of each parent.
    on : In(1)
    done : Out(1)
        High in the last cycle with ``on``.
    results : Out(mutation_layout).array(mutators)
        Work of each mutator in this generation. Valid with ``done``.
    mutations : Out(mutation_layout).array(mutators)
        Work of each mutator in the latest generation, from the cycle after ``done`` on.
    patches : Out(waypoint_bits).array(patches)
        New waypoints of the latest generation, from the same cycle on.
    refused : Out(range(mutators + 1))
        Mutations that a length limit forbade.

    Without a map:

    offsets : In(ArrayLayout(offset_layout, patches))
        From the selection unit; must stay until ``done``.
    carrying : In(1)
    position : In(index_bits)
        While ``carrying``: position of ``waypoints`` in their paths.

    With a map:

    run : In(1)
        High from the cycle before the crossover's first to the cycle before ``done``.
    settled, peeks, peek, peek_position
        See :class:`pathgene.hdl.ga_core.population.Population`.
    offset, offset_taken, avoid, lookup_valid, lookup_x, lookup_y, lookup_altitude
        See :class:`pathgene.hdl.ga_core.terrain_aware_sampler.TerrainAwareSampler`.
    redrawn : Out(range(patches * candidates))
        Candidates that replaced a candidate in the ground.
    left_out : Out(range(patches + 1))
        Mutations not applied because all their candidates were in the ground.

    Attributes
    ----------
    latency : int
        Cycles from ``start`` to ``planned``. With a map, add the cycles in which the population is
        not yet ``settled`` after the planning.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.avoids_ground = config.checker is not CheckerBuild.NONE
        self.limits_layout = limits_layout(config.coordinate_bits, config.altitude_bits)
        self.offset_layout = offset_layout(config.box_cells, config.box_steps)
        record = mutation_layout(config.children, config.max_waypoints)
        self.latency = MutationPlan.latency_of(config.mutators) + 1
        if self.avoids_ground:
            self.latency += TerrainAwareSampler.latency_of(config.patches)
            members = {
                "run": In(1),
                "settled": In(1),
                "peeks": Out(1),
                "peek": Out(1),
                "peek_position": Out(config.index_bits),
                "offset": In(self.offset_layout),
                "offset_taken": Out(1),
                "avoid": In(1),
                "lookup_valid": Out(1),
                "lookup_x": Out(config.coordinate_bits),
                "lookup_y": Out(config.coordinate_bits),
                "lookup_altitude": In(config.altitude_bits),
                "redrawn": Out(range(config.patches * config.candidates)),
                "left_out": Out(range(config.patches + 1)),
            }
        else:
            members = {
                "offsets": In(data.ArrayLayout(self.offset_layout, config.patches)),
                "carrying": In(1),
                "position": In(config.index_bits),
            }
        return {
            "start": In(1),
            "clear": In(1),
            "children": In(data.ArrayLayout(config.child_bits, config.mutators)),
            "draws": In(data.ArrayLayout(RandomWordLayout.OFFSET_BITS, config.mutators)),
            "lengths": In(config.length_bits).array(config.crossovers),
            "planned": Out(1),
            "limits": In(self.limits_layout),
            "waypoints": In(config.waypoint_bits).array(config.crossovers),
            "on": In(1),
            "done": Out(1),
            "results": Out(record).array(config.mutators),
            "mutations": Out(record).array(config.mutators),
            "patches": Out(config.waypoint_bits).array(config.patches),
            "refused": Out(range(config.mutators + 1)),
            **members,
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.plan = plan = MutationPlan(
            mutators=config.mutators,
            crossovers=config.crossovers,
            max_waypoints=config.max_waypoints,
        )
        m.d.comb += [
            plan.start.eq(self.start),
            plan.clear.eq(self.clear),
            plan.children.eq(self.children),
            plan.draws.eq(self.draws),
        ]
        for target, length in zip(plan.lengths, self.lengths, strict=True):
            m.d.comb += target.eq(length)
        complete = Signal()
        m.d.sync += complete.eq(plan.valid & (plan.number == config.mutators - 1) & ~self.clear)

        mutators = []
        for number, kind in enumerate(config.mutations):
            m.submodules[f"mutator_{number}"] = mutator = Mutator(
                kind,
                crossovers=config.crossovers,
                waypoint_bits=config.waypoint_bits,
                min_waypoints=config.MIN_WAYPOINTS,
                max_waypoints=config.max_waypoints,
            )
            mutators.append(mutator)
            m.d.comb += [
                mutator.planned.eq(plan.valid & (plan.number == number)),
                mutator.plan.eq(plan.plan),
                mutator.store.eq(self.done),
                self.results[number].eq(mutator.result),
                self.mutations[number].eq(mutator.record),
            ]
            if kind is not MutationKind.DELETE:
                m.d.comb += self.patches[number].eq(mutator.patch)

        if self.avoids_ground:
            self._search(m, mutators, complete)
        else:
            self._move(m, mutators, complete)
        return m

    def _move(self, m, mutators, complete):
        """Move each waypoint once, while it passes."""
        m.d.comb += self.planned.eq(complete)
        m.d.sync += self.done.eq(self.on & ~self.done)
        for number, mutator in enumerate(mutators[: self.config.patches]):
            m.submodules[f"perturber_{number}"] = perturber = WaypointPerturber(
                crossovers=self.config.crossovers,
                max_waypoints=self.config.max_waypoints,
                limits_layout=self.limits_layout,
                offset_layout=self.offset_layout,
            )
            m.d.comb += [
                perturber.plan.eq(mutator.kept),
                perturber.offset.eq(self.offsets[number]),
                perturber.limits.eq(self.limits),
                perturber.carrying.eq(self.carrying),
                perturber.position.eq(self.position),
                mutator.made.eq(1),
                mutator.waypoint.eq(perturber.moved),
            ]
            for target, waypoint in zip(perturber.waypoints, self.waypoints, strict=True):
                m.d.comb += target.eq(waypoint)
        m.d.comb += self.refused.eq(sum(~mutation.applied for mutation in self.mutations))

    def _search(self, m, mutators, complete):
        """Look for new waypoints above the ground."""
        config = self.config
        m.submodules.sampler = sampler = TerrainAwareSampler(
            patch_count=config.patches,
            candidates=config.candidates,
            crossovers=config.crossovers,
            max_waypoints=config.max_waypoints,
            limits_layout=self.limits_layout,
            offset_layout=self.offset_layout,
            lookup_latency=config.lookup_latency,
        )
        m.d.comb += [
            sampler.fetch.eq(complete),
            sampler.clear.eq(self.clear),
            sampler.limits.eq(self.limits),
            self.planned.eq(sampler.fetched),
        ]
        for name in _MAP_INPUTS:
            m.d.comb += getattr(sampler, name).eq(getattr(self, name))
        for name in _MAP_OUTPUTS:
            m.d.comb += getattr(self, name).eq(getattr(sampler, name))
        for target, waypoint in zip(sampler.waypoints, self.waypoints, strict=True):
            m.d.comb += target.eq(waypoint)

        patching = mutators[: config.patches]
        for number, mutator in enumerate(patching):
            m.d.comb += [
                sampler.plans[number].eq(mutator.kept),
                sampler.needed[number].eq(mutator.allowed),
                mutator.made.eq(sampler.found[number]),
                mutator.waypoint.eq(sampler.patches[number]),
            ]

        # `allowed` changes with the next plans, but the counts of this generation must stay.
        forbidden = [~mutator.allowed for mutator in mutators]
        missing = [
            mutator.allowed & ~found for mutator, found in zip(patching, sampler.found, strict=True)
        ]
        m.d.sync += self.done.eq(self.on & ~self.done & sampler.decided)
        with m.If(self.done):
            m.d.sync += [
                self.refused.eq(sum(forbidden)),
                self.left_out.eq(sum(missing)),
                self.redrawn.eq(sampler.redrawn),
            ]
