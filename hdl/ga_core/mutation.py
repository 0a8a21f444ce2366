"""Mutation unit: perturbs, inserts and deletes waypoints of children that are just being bred."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config, MutationKind
from hdl.draws import DrawLayout
from hdl.ga_core.layouts import mutation_layout
from hdl.ga_core.multiplexer import chosen
from hdl.ga_core.mutation_plan import MutationPlan, plan_layout


__all__ = ["Mutation", "Mutator", "limits_layout", "offset_layout"]


def offset_layout(config: Config) -> data.StructLayout:
    """Return the layout of the signed distance of a new waypoint from the one it is made of."""
    boxes = {"x": config.box_cells, "y": config.box_cells, "altitude": config.box_steps}
    return data.StructLayout(
        {axis: Shape.cast(range(-box, box + 1)) for axis, box in boxes.items()}
    )


def limits_layout(config: Config) -> data.StructLayout:
    """Return the layout of the highest x, y and altitude of a new waypoint."""
    return data.StructLayout(
        {
            "x": config.coordinate_bits,
            "y": config.coordinate_bits,
            "altitude": config.altitude_bits,
        }
    )


class Mutator(wiring.Component):
    """One mutator.

    Takes its plan, then the waypoint it works on, as that passes through the port of a parent. In
    the first of the two clocks with ``on`` it moves the waypoint, in the second it keeps it within
    the limits and says what it did.

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
    offset : In(offset_layout)
    limits : In(limits_layout)
    carrying : In(1)
    position : In(index_bits)
    waypoints : In(waypoint_bits).array(crossovers)
        While ``carrying``: waypoint of each parent at ``position``.
    on : In(1)
    second : In(1)
        With ``on``: this is the second clock.
    done : Out(mutation_layout)
    patch : Out(waypoint_bits)
        The new waypoint; 0 if there is none. Both are steady from one second clock to the next.
    """

    def __init__(self, config, kind):
        self.config = config
        self.kind = MutationKind(kind)
        super().__init__(
            {
                "planned": In(1),
                "plan": In(plan_layout(config)),
                "offset": In(offset_layout(config)),
                "limits": In(limits_layout(config)),
                "carrying": In(1),
                "position": In(config.index_bits),
                "waypoints": In(config.waypoint_bits).array(config.crossovers),
                "on": In(1),
                "second": In(1),
                "done": Out(mutation_layout(config)),
                "patch": Out(config.waypoint_bits),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        allowed = {
            MutationKind.PERTURB: C(1),
            MutationKind.INSERT: self.plan.length < config.max_waypoints,
            MutationKind.DELETE: self.plan.length > config.MIN_WAYPOINTS,
        }
        applied = Signal()
        plan = Signal.like(self.plan)
        with m.If(self.planned):
            m.d.sync += [plan.eq(self.plan), applied.eq(allowed[self.kind])]

        with m.If(self.on & self.second):
            m.d.sync += [
                self.done.applied.eq(applied),
                self.done.child.eq(plan.child),
                self.done.index.eq(plan.index),
            ]

        if self.kind is not MutationKind.DELETE:
            axes = limits_layout(config)
            passed = Signal(axes, reset_less=True)
            with m.If(self.carrying & (self.position == plan.position)):
                m.d.sync += passed.eq(chosen(plan.parent, self.waypoints))

            patch = Signal(axes)
            for axis in ("x", "y", "altitude"):
                total = passed[axis] + self.offset[axis]
                moved = Signal(total.shape(), name=f"moved_{axis}", reset_less=True)
                m.d.sync += moved.eq(total)
                with m.If(moved < 0):
                    m.d.comb += patch[axis].eq(0)
                with m.Elif(moved > self.limits[axis]):
                    m.d.comb += patch[axis].eq(self.limits[axis])
                with m.Else():
                    m.d.comb += patch[axis].eq(moved)
            with m.If(self.on & self.second):
                m.d.sync += self.patch.eq(Mux(applied, patch, 0))

        return m


class Mutation(wiring.Component):
    """All mutators of the chip, working at once.

    Before a generation it plans: ``planned`` is high :attr:`latency` clocks after ``start``. During
    the crossover the mutators take the waypoints they work on off the ports. The mutation itself
    takes two clocks. What a limit on the length forbids is not done, and counted in ``refused``.

    Source: *allaire-2008*, section 4.6.

    Parameters
    ----------
    config : Config

    Members
    -------
    start : In(1)
        All inputs up to ``lengths`` are complete; they must stay until ``over``.
    clear : In(1)
        A plan under way is void. Stronger than ``start``.
    children : In(ArrayLayout(child_bits, mutators))
    draws : In(ArrayLayout(16, mutators))
    offsets : In(ArrayLayout(offset_layout, patches))
        From the selection unit.
    lengths : In(length_bits).array(crossovers)
        Length of each parent.
    planned : Out(1)
        Pulse: a generation may start.
    limits : In(limits_layout)
    carrying : In(1)
    position : In(index_bits)
    waypoints : In(waypoint_bits).array(crossovers)
        While ``carrying``: waypoint of each parent at ``position``.
    on : In(1)
    over : Out(1)
        In the second clock with ``on``.
    mutations : Out(mutation_layout).array(mutators)
        Of the latest generation, from the clock after ``over`` on.
    patches : Out(waypoint_bits).array(patches)
        New waypoints, from then on.
    refused : Out(range(mutators + 1))
        Mutations not applied.

    Attributes
    ----------
    latency : int
        Clocks from ``start`` to ``planned``.
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        self.latency = MutationPlan.latency_of(config) + 1
        super().__init__(
            {
                "start": In(1),
                "clear": In(1),
                "children": In(data.ArrayLayout(config.child_bits, config.mutators)),
                "draws": In(data.ArrayLayout(DrawLayout.OFFSET_BITS, config.mutators)),
                "offsets": In(data.ArrayLayout(offset_layout(config), config.patches)),
                "lengths": In(config.length_bits).array(config.crossovers),
                "planned": Out(1),
                "limits": In(limits_layout(config)),
                "carrying": In(1),
                "position": In(config.index_bits),
                "waypoints": In(config.waypoint_bits).array(config.crossovers),
                "on": In(1),
                "over": Out(1),
                "mutations": Out(mutation_layout(config)).array(config.mutators),
                "patches": Out(config.waypoint_bits).array(config.patches),
                "refused": Out(range(config.mutators + 1)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.plan = plan = MutationPlan(config)
        m.d.comb += [
            plan.start.eq(self.start),
            plan.clear.eq(self.clear),
            plan.children.eq(self.children),
            plan.draws.eq(self.draws),
        ]
        for target, length in zip(plan.lengths, self.lengths, strict=True):
            m.d.comb += target.eq(length)
        m.d.sync += self.planned.eq(plan.valid & (plan.number == config.mutators - 1) & ~self.clear)

        m.d.sync += self.over.eq(self.on & ~self.over)

        for number, kind in enumerate(config.mutations):
            m.submodules[f"mutator_{number}"] = mutator = Mutator(config, kind)
            m.d.comb += [
                mutator.planned.eq(plan.valid & (plan.number == number)),
                mutator.plan.eq(plan.plan),
                mutator.limits.eq(self.limits),
                mutator.carrying.eq(self.carrying),
                mutator.position.eq(self.position),
                mutator.on.eq(self.on),
                mutator.second.eq(self.over),
                self.mutations[number].eq(mutator.done),
            ]
            for target, waypoint in zip(mutator.waypoints, self.waypoints, strict=True):
                m.d.comb += target.eq(waypoint)
            if kind is not MutationKind.DELETE:
                m.d.comb += [
                    mutator.offset.eq(self.offsets[number]),
                    self.patches[number].eq(mutator.patch),
                ]
        m.d.comb += self.refused.eq(sum(~mutation.applied for mutation in self.mutations))

        return m
