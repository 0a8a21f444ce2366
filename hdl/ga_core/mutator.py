"""Mutator: the plan of one mutation, and its result."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.layouts import mutation_layout
from pathgene.hdl.ga_core.mutation_plan import plan_layout
from pathgene.hdl.primitives.unit import Count, Given, Unit, Width


__all__ = ["Mutator"]


class Mutator(Unit):
    """Keeps its plan, and records at the end of a mutation whether it was applied.

    Source: *allaire-2008*, section 4.6.

    Members
    -------
    planned : In(1)
        ``plan`` belongs to this mutator.
    plan : In(plan_layout)
    kept : Out(plan_layout)
        Its latest plan.
    allowed : Out(1)
        The limits on the length allow the plan.
    made : In(1)
        There is a new waypoint. Ignored unless ``allowed``. A deleting mutator lacks ``made``,
        ``waypoint`` and ``patch``.
    waypoint : In(waypoint_bits)
        The new waypoint.
    result : Out(mutation_layout)
        Result of the plan, which ``store`` records.
    store : In(1)
        Record ``result``, in the last cycle of the mutation.
    record : Out(mutation_layout)
        Result of the latest mutation. Like ``patch``, it changes with ``store`` only.
    patch : Out(waypoint_bits)
        New waypoint of the latest mutation, or 0 if that was not applied.
    """

    kind: Given("MutationKind")
    crossovers: Count(2, text="Crossover modules. Each has a parent and breeds two children.")
    waypoint_bits: Width(1)
    min_waypoints: Count(1, text="Waypoints of the shortest path.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        self.kind = MutationKind(self.kind)
        plan = plan_layout(self.crossovers, self.max_waypoints)
        record = mutation_layout(2 * self.crossovers, self.max_waypoints)
        patch = {
            "made": In(1),
            "waypoint": In(self.waypoint_bits),
            "patch": Out(self.waypoint_bits),
        }
        return {
            "planned": In(1),
            "plan": In(plan),
            "kept": Out(plan),
            "allowed": Out(1),
            "result": Out(record),
            "store": In(1),
            "record": Out(record),
            **({} if self.kind is MutationKind.DELETE else patch),
        }

    def elaborate(self, platform):
        m = Module()

        allowed = {
            MutationKind.PERTURB: C(1),
            MutationKind.INSERT: self.plan.length < self.max_waypoints,
            MutationKind.DELETE: self.plan.length > self.min_waypoints,
        }
        with m.If(self.planned):
            m.d.sync += [self.kept.eq(self.plan), self.allowed.eq(allowed[self.kind])]

        # A register, since it reaches all children.
        applied = Signal()
        m.d.sync += applied.eq(self.allowed)
        m.d.comb += [
            self.result.applied.eq(applied),
            self.result.child.eq(self.kept.child),
            self.result.index.eq(self.kept.index),
        ]
        if self.kind is not MutationKind.DELETE:
            m.d.sync += applied.eq(self.allowed & self.made)
            with m.If(self.store):
                m.d.sync += self.patch.eq(Mux(self.result.applied, self.waypoint, 0))
        with m.If(self.store):
            m.d.sync += self.record.eq(self.result)

        return m
