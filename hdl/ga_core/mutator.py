"""One mutator: what it is to do, and what it did."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config, MutationKind
from hdl.ga_core.layouts import mutation_layout
from hdl.ga_core.mutation_plan import plan_layout


__all__ = ["Mutator"]


class Mutator(wiring.Component):
    """Keeps its plan, and says at the end of a mutation what has become of it.

    Source: *allaire-2008*, section 4.6.

    Parameters
    ----------
    config : Config
    kind : MutationKind

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
    """

    def __init__(self, config, kind):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        self.kind = MutationKind(kind)
        patch = {
            "made": In(1),
            "waypoint": In(config.waypoint_bits),
            "patch": Out(config.waypoint_bits),
        }
        super().__init__(
            {
                "planned": In(1),
                "plan": In(plan_layout(config)),
                "kept": Out(plan_layout(config)),
                "allowed": Out(1),
                "result": Out(mutation_layout(config)),
                "store": In(1),
                "record": Out(mutation_layout(config)),
                **({} if self.kind is MutationKind.DELETE else patch),
            }
        )

    def elaborate(self, platform):
        m = Module()

        allowed = {
            MutationKind.PERTURB: C(1),
            MutationKind.INSERT: self.plan.length < self.config.max_waypoints,
            MutationKind.DELETE: self.plan.length > self.config.MIN_WAYPOINTS,
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
