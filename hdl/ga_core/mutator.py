"""One mutator: what it is to do, and what it did."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import MutationKind
from hdl.ga_core.layouts import mutation_layout
from hdl.ga_core.mutation_plan import plan_layout
from hdl.primitives.arguments import check_integer


__all__ = ["Mutator"]


class Mutator(wiring.Component):
    """Keeps its plan, and says at the end of a mutation what has become of it.

    Source: *allaire-2008*, section 4.6.

    Parameters
    ----------
    kind : MutationKind
    crossovers : int
        Crossover modules, 2 or more. Each has a parent and breeds two children.
    waypoint_bits : int
        Width of a waypoint.
    min_waypoints, max_waypoints : int
        Waypoints of the shortest path, 1 or more, and of the longest, 3 or more.

    Members
    -------
    planned : In(1)
        ``plan`` is this mutator's.
    plan : In(plan_layout)
    kept : Out(plan_layout)
        Its latest plan.
    allowed : Out(1)
        The limits on the length allow what is planned.
    made : In(1)
    waypoint : In(waypoint_bits)
        Not of a deleting one. The new waypoint is there, and it. Ignored unless ``allowed``.
    result : Out(mutation_layout)
        What ``record`` would be after a ``store``.
    store : In(1)
        In the last clock of the mutation: what it did is what stands in the others now.
    record : Out(mutation_layout)
    patch : Out(waypoint_bits)
        The new waypoint; 0 if there is none. Both are steady from one ``store`` to the next.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, kind, *, crossovers, waypoint_bits, min_waypoints, max_waypoints):
        self.kind = MutationKind(kind)
        check_integer("Crossovers", crossovers, 2)
        check_integer("Waypoint width", waypoint_bits, 1)
        check_integer("Min waypoints", min_waypoints, 1)
        check_integer("Max waypoints", max_waypoints, 3)

        self.crossovers = crossovers
        self.waypoint_bits = waypoint_bits
        self.min_waypoints = min_waypoints
        self.max_waypoints = max_waypoints
        plan = plan_layout(crossovers, max_waypoints)
        record = mutation_layout(2 * crossovers, max_waypoints)
        patch = {
            "made": In(1),
            "waypoint": In(waypoint_bits),
            "patch": Out(waypoint_bits),
        }
        super().__init__(
            {
                "planned": In(1),
                "plan": In(plan),
                "kept": Out(plan),
                "allowed": Out(1),
                "result": Out(record),
                "store": In(1),
                "record": Out(record),
                **({} if self.kind is MutationKind.DELETE else patch),
            }
        )

    def elaborate(self, platform):
        m = Module()

        allowed = {
            MutationKind.PERTURB: C(1),
            MutationKind.INSERT: self.plan.length < self.max_waypoints,
            MutationKind.DELETE: self.plan.length > self.min_waypoints,
        }
        with m.If(self.planned):
            m.d.sync += [self.kept.eq(self.plan), self.allowed.eq(allowed[self.kind])]

        # It reaches all children: a register.
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
