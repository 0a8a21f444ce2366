"""One mutator: its plan, the change of a child, and the perturbed waypoint."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.layouts import mutation_layout
from pathgene.hdl.primitives.logic import multiplex, one_hot_multiplex
from pathgene.hdl.primitives.unit import Count, Given, Unit, Width
from pathgene.hdl.protocol.random_words import RandomWordLayout


__all__ = ["MutationPlan", "Mutator", "WaypointPerturber", "plan_layout", "within"]


def plan_layout(crossovers: int, max_waypoints: int) -> data.StructLayout:
    """Return the layout of one mutator's plan.

    ``length`` is the length of ``child``, and ``index`` the index of the waypoint in it. The
    waypoint comes from ``parent``, where its index is ``position``.
    """
    return data.StructLayout(
        {
            "child": range(2 * crossovers),
            "length": range(max_waypoints + 1),
            "index": range(max_waypoints),
            "parent": range(crossovers),
            "position": range(max_waypoints),
        }
    )


class MutationPlan(Unit):
    """Plans the mutators' work, one mutator per cycle, from the draws and the parents' lengths.

    It is a pipeline, so that one multiplier and one multiplexer of lengths serve all mutators. The
    plan of mutator ``i`` is valid ``i + 8`` cycles after ``start``.

    Members
    -------
    start : In(1)
        The inputs below are complete. They must stay until the last plan.
    clear : In(1)
        Stop planning. Overrides ``start``.
    children : In(ArrayLayout(range(2 * crossovers), mutators))
        Child of each mutator.
    draws : In(ArrayLayout(16, mutators))
        Draw of each mutator's waypoint.
    lengths : In(range(max_waypoints + 1)).array(crossovers)
        Length of each parent.
    valid : Out(1)
    number : Out(range(mutators))
        While ``valid``: the mutator that ``plan`` belongs to.
    plan : Out(plan_layout)
    """

    mutators: Count(1)
    crossovers: Count(2, text="Crossover modules. Each has a parent and breeds two children.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    @staticmethod
    def latency_of(mutators: int) -> int:
        """Return the cycles from ``start`` to the last plan."""
        return mutators + 7

    def interface(self):
        return {
            "start": In(1),
            "clear": In(1),
            "children": In(data.ArrayLayout(range(2 * self.crossovers), self.mutators)),
            "draws": In(data.ArrayLayout(RandomWordLayout.OFFSET_BITS, self.mutators)),
            "lengths": In(range(self.max_waypoints + 1)).array(self.crossovers),
            "valid": Out(1),
            "number": Out(range(self.mutators)),
            "plan": Out(plan_layout(self.crossovers, self.max_waypoints)),
        }

    def elaborate(self, platform):
        m = Module()

        def stage(name, valid, **fields):
            """Register the values ``fields`` with their ``valid``, which ``clear`` clears."""
            registers = {}
            for field, value in {"valid": valid & ~self.clear, **fields}.items():
                value = Value.cast(value)
                registers[field] = Signal(
                    value.shape(), name=f"{name}_{field}", reset_less=field != "valid"
                )
                m.d.sync += registers[field].eq(value)
            return registers

        def kept(registers, *names):
            """Return the ``registers`` of a stage for the next stage to pass on unchanged."""
            return {name: registers[name] for name in names}

        number = Signal(range(self.mutators + 1), init=self.mutators)
        running = number != self.mutators
        with m.If(self.clear):
            m.d.sync += number.eq(self.mutators)
        with m.Elif(self.start):
            m.d.sync += number.eq(0)
        with m.Elif(running):
            m.d.sync += number.eq(number + 1)

        drawn = stage(
            "drawn",
            running,
            number=number[: len(self.number)],
            child=multiplex(number, list(self.children)),
            draw=multiplex(number, list(self.draws)),
        )

        # The lengths come from the whole population, so the child is decoded one cycle earlier.
        decoded = stage(
            "decoded",
            drawn["valid"],
            **kept(drawn, "number", "child", "draw"),
            select=(1 << (drawn["child"] >> 1))[: self.crossovers],
        )
        # Even children get the head of the first parent of their module, odd children the head of
        # the second, which is the first parent of the next module.
        select = decoded["select"]
        first = (decoded["child"] >> 1)[: ceil_log2(self.crossovers)]
        second = Mux(select[-1], 0, first + 1)[: len(first)]
        looked_up = stage(
            "looked_up",
            decoded["valid"],
            **kept(decoded, "number", "child", "draw"),
            odd=decoded["child"][0],
            first=first,
            second=second,
            first_length=one_hot_multiplex(select, self.lengths),
            second_length=one_hot_multiplex(select, [*self.lengths[1:], self.lengths[0]]),
        )

        head_length = Mux(looked_up["odd"], looked_up["second_length"], looked_up["first_length"])
        tail_length = Mux(looked_up["odd"], looked_up["first_length"], looked_up["second_length"])
        length = Signal(range(self.max_waypoints + 1))
        m.d.comb += length.eq((head_length >> 1) + ((tail_length + 1) >> 1))
        joined = stage(
            "joined",
            looked_up["valid"],
            **kept(looked_up, "number", "child", "draw"),
            length=length,
            head=head_length >> 1,
            skipped=tail_length >> 1,
            head_parent=Mux(looked_up["odd"], looked_up["second"], looked_up["first"]),
            tail_parent=Mux(looked_up["odd"], looked_up["first"], looked_up["second"]),
        )

        # Two products of half the width, then their sum.
        half = len(length) // 2
        passed = ("number", "child", "length", "head", "skipped", "head_parent", "tail_parent")
        multiplied = stage(
            "multiplied",
            joined["valid"],
            low=joined["draw"] * joined["length"][:half],
            high=joined["draw"] * joined["length"][half:],
            **kept(joined, *passed),
        )
        product = multiplied["low"] + (multiplied["high"] << half)
        aimed = stage(
            "aimed",
            multiplied["valid"],
            index=(product >> RandomWordLayout.OFFSET_BITS)[: len(self.plan.index)],
            **kept(multiplied, *passed),
        )

        in_head = aimed["index"] < aimed["head"]
        found = stage(
            "found",
            aimed["valid"],
            **kept(aimed, "number", "child", "length", "index"),
            parent=Mux(in_head, aimed["head_parent"], aimed["tail_parent"]),
            position=Mux(
                in_head, aimed["index"], aimed["index"] - aimed["head"] + aimed["skipped"]
            )[: len(self.plan.index)],
        )
        m.d.comb += [
            self.valid.eq(found["valid"]),
            self.number.eq(found["number"]),
            *(
                self.plan[name].eq(found[name])
                for name in ("child", "length", "index", "parent", "position")
            ),
        ]

        return m


class Mutator(Unit):
    """Keeps its plan, and records at the end of a mutation whether it was applied.

    Source: *allaire-2008*, section 4.6.

    Members
    -------
    planned : In(1)
        ``plan`` is for this mutator.
    plan : In(plan_layout)
    kept : Out(plan_layout)
        Its latest plan.
    allowed : Out(1)
        The length limits allow the plan.
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
        Result of the latest mutation. Like ``patch``, it only changes with ``store``.
    patch : Out(waypoint_bits)
        New waypoint of the latest mutation, or 0 if it was not applied.
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

        # A register, because it reaches all children.
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


def within(m: Module, total: Value, limit: Value) -> Signal:
    """Return ``total`` limited to 0..``limit``. Combinational."""
    value = Signal(limit.shape(), name="within")
    with m.If(total < 0):
        m.d.comb += value.eq(0)
    with m.Elif(total > limit):
        m.d.comb += value.eq(limit)
    with m.Else():
        m.d.comb += value.eq(total)
    return value


class WaypointPerturber(Unit):
    """Takes the waypoint of a mutator while it passes the port of its parent, and moves it.

    ``moved`` follows 2 cycles later: the waypoint is registered in the first and moved in the
    second. The limits apply without a register.

    Source: *allaire-2008*, section 4.6.

    Members
    -------
    plan : In(plan_layout)
        Must stay until ``moved`` is used.
    offset : In(offset_layout)
    limits : In(limits_layout)
    carrying : In(1)
    position : In(range(max_waypoints))
    waypoints : In(waypoint_bits).array(crossovers)
        While ``carrying``: waypoint of each parent at ``position``.
    moved : Out(waypoint_bits)
        A waypoint has the width of ``limits_layout``.
    """

    crossovers: Count(2, text="Crossover modules. Each has a parent.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")
    limits_layout: Given(
        "StructLayout",
        "With ``x``, ``y`` and ``altitude``: see :mod:`pathgene.hdl.ga_core.layouts`.",
    )
    offset_layout: Given(
        "StructLayout",
        "With ``x``, ``y`` and ``altitude``: see :mod:`pathgene.hdl.ga_core.layouts`.",
    )

    def interface(self):
        return {
            "plan": In(plan_layout(self.crossovers, self.max_waypoints)),
            "offset": In(self.offset_layout),
            "limits": In(self.limits_layout),
            "carrying": In(1),
            "position": In(range(self.max_waypoints)),
            "waypoints": In(self.limits_layout.size).array(self.crossovers),
            "moved": Out(self.limits_layout.size),
        }

    def elaborate(self, platform):
        m = Module()

        passed = Signal(self.limits_layout, reset_less=True)
        with m.If(self.carrying & (self.position == self.plan.position)):
            m.d.sync += passed.eq(multiplex(self.plan.parent, self.waypoints))

        moved = Signal(self.limits_layout)
        m.d.comb += self.moved.eq(moved)
        for axis in ("x", "y", "altitude"):
            total = passed[axis] + self.offset[axis]
            far = Signal(total.shape(), name=f"far_{axis}", reset_less=True)
            m.d.sync += far.eq(total)
            m.d.comb += moved[axis].eq(within(m, far, self.limits[axis]))

        return m
