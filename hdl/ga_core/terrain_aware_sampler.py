"""Sampler of new waypoints above the ground, on a chip with a map."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.ga_core.mutator import plan_layout, within
from pathgene.hdl.ga_core.read_ports import PEEK_LATENCY
from pathgene.hdl.primitives.logic import multiplex, one_hot_multiplex
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["TerrainAwareSampler"]


class TerrainAwareSampler(Unit):
    """Makes new waypoints above the ground, with one lookup in the map per cycle.

    Before a generation, as soon as the mutators have planned, their waypoints are read ahead
    through the ports: ``fetched`` is high :meth:`latency_of` cycles after ``fetch`` if the
    population is ``settled``.

    While the parents pass, one candidate per cycle is moved, kept within the limits and looked up:
    the first of every patch, then the second of every patch, and so on. A patch becomes its first
    candidate above the ground, that is, higher than its cell. It is *decided* by that candidate, or
    by its last one if there is none. Candidate ``n``, counted over all from 0, decides
    ``n + lookup_latency + 5`` cycles after ``run`` rose.

    Source: none; *allaire-2008*, section 4.6, ignores the ground in mutations.

    Members
    -------
    plans : In(plan_layout).array(patch_count)
    needed : In(patch_count)
        Patches to be made. Plans and ``needed`` must stay from ``fetch`` to the end of ``run``.
    fetch : In(1)
        Pulse: the plans are complete.
    clear : In(1)
        Discard the fetched waypoints. Overrides ``fetch``.
    settled : In(1)
    peeks, peek : Out(1)
    peek_position : Out(range(max_waypoints))
    waypoints : In(waypoint_bits).array(crossovers)
        See :class:`pathgene.hdl.ga_core.population.Population`, of which these are the ports of
        parents.
    fetched : Out(1)
        Pulse: a generation may start.
    run : In(1)
        A generation runs from the next cycle on. The outputs below are valid from two cycles after
        ``run`` rises to the second cycle after it falls.
    offset : In(offset_layout)
        Offset of the next candidate.
    offset_taken : Out(1)
        The offset is taken; the next one must be offered in the next cycle.
    limits : In(limits_layout)
    avoid : In(1)
        Reject candidates in the ground. Otherwise every first candidate is taken.
    lookup_valid : Out(1)
    lookup_x, lookup_y : Out(limits_layout["x"]), Out(limits_layout["y"])
        Cell of a candidate.
    lookup_altitude : In(limits_layout["altitude"])
        Ground of the cell from ``lookup_latency`` cycles ago.
    decided : Out(1)
        All needed patches have been decided.
    found : Out(patch_count)
        Patches that have been made; 0 for a patch that is not needed.
    patches : Out(waypoint_bits).array(patch_count)
        The new waypoints found.
    redrawn : Out(range(patch_count * candidates))
        Candidates that replaced a candidate in the ground.
    """

    patch_count: Count(1, text="New waypoints of the children.")
    candidates: Count(1, text="Draws of each new waypoint.")
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
    lookup_latency: Count(1, text="Cycles from a cell to its altitude.")

    @staticmethod
    def latency_of(patch_count: int) -> int:
        """Return the cycles from ``fetch`` to ``fetched``."""
        return patch_count + PEEK_LATENCY + 1

    def interface(self):
        return {
            "plans": In(plan_layout(self.crossovers, self.max_waypoints)).array(self.patch_count),
            "needed": In(self.patch_count),
            "fetch": In(1),
            "clear": In(1),
            "settled": In(1),
            "peeks": Out(1),
            "peek": Out(1),
            "peek_position": Out(range(self.max_waypoints)),
            "waypoints": In(self.limits_layout.size).array(self.crossovers),
            "fetched": Out(1),
            "run": In(1),
            "offset": In(self.offset_layout),
            "offset_taken": Out(1),
            "limits": In(self.limits_layout),
            "avoid": In(1),
            "lookup_valid": Out(1),
            "lookup_x": Out(self.limits_layout["x"].shape),
            "lookup_y": Out(self.limits_layout["y"].shape),
            "lookup_altitude": In(self.limits_layout["altitude"].shape),
            "decided": Out(1),
            "found": Out(self.patch_count),
            "patches": Out(self.limits_layout.size).array(self.patch_count),
            "redrawn": Out(range(self.patch_count * self.candidates)),
        }

    def elaborate(self, platform):
        m = Module()

        running = Signal()
        m.d.sync += running.eq(self.run)

        # A queue of the waypoints to be moved. The first waypoint is moved and goes to the end.
        axes = self.limits_layout
        bases = [Signal(axes, name=f"base_{i}", reset_less=True) for i in range(len(self.plans))]
        fetched, waypoint = self._fetch(m)
        following = Signal(axes)
        m.d.comb += following.eq(bases[0])
        with m.If(fetched):
            m.d.comb += following.eq(waypoint)
        with m.If(fetched | self.offset_taken):
            for base, following_base in zip(bases, [*bases[1:], following], strict=True):
                m.d.sync += base.eq(following_base)

        self._decide(m, running, *self._candidates(m, running, bases[0]))
        return m

    def _fetch(self, m):
        """Read the waypoints ahead; return a flag that the next has arrived, and the waypoint."""
        wanted = Signal()
        number = Signal(range(self.patch_count))
        last = number == self.patch_count - 1
        m.d.comb += [
            self.peeks.eq(wanted),
            self.peek.eq(wanted & (self.settled | (number != 0))),
            self.peek_position.eq(multiplex(number, [plan.position for plan in self.plans])),
        ]
        with m.If(self.peek):
            m.d.sync += number.eq(number + 1)
            with m.If(last):
                m.d.sync += [number.eq(0), wanted.eq(0)]
        with m.If(self.clear):
            m.d.sync += [number.eq(0), wanted.eq(0)]
        with m.Elif(self.fetch):
            m.d.sync += wanted.eq(1)

        latency = PEEK_LATENCY
        valid = Signal(latency)
        m.d.sync += valid.eq(Mux(self.clear, 0, Cat(self.peek, valid)))
        parent = multiplex(number, [plan.parent for plan in self.plans])
        for stage in range(latency - 1):
            delayed = Signal(range(self.crossovers), name=f"parent_{stage}", reset_less=True)
            m.d.sync += delayed.eq(parent)
            parent = delayed
        select = Signal(self.crossovers, reset_less=True)
        m.d.sync += [
            select.eq(1 << parent),
            self.fetched.eq(valid[-1] & ~valid[-2] & ~self.clear),
        ]
        return valid[-1], one_hot_multiplex(select, self.waypoints)

    def _candidates(self, m, running, base):
        """Make and look up the candidates; return the one whose altitude arrives.

        The result is a flag that there is one, its facts (the patch, one-hot, and whether it is the
        last of the patch), and the waypoint. Each step ends in registers.
        """
        axes = self.limits_layout

        turn = Signal(self.patch_count, init=1)
        candidate = Signal(range(max(2, self.candidates)))
        exhausted = Signal()
        last = candidate == self.candidates - 1
        exhausts = Signal()
        m.d.comb += exhausts.eq(exhausted | (self.offset_taken & turn[-1] & last))
        # A register, because it enables all bases and all offsets.
        m.d.sync += self.offset_taken.eq(self.run & ~exhausts)
        with m.If(~running):
            m.d.sync += [turn.eq(1), candidate.eq(0), exhausted.eq(0)]
        with m.Else():
            m.d.sync += [turn.eq(turn.rotate_left(1)), exhausted.eq(exhausts)]
            with m.If(turn[-1]):
                m.d.sync += candidate.eq(candidate + 1)

        valid = self.offset_taken
        known = data.StructLayout({"turn": self.patch_count, "last": 1})
        facts = Signal(known)
        m.d.comb += [facts.turn.eq(turn), facts.last.eq(last)]

        def after(stage, valid, facts):
            """Return ``valid`` and ``facts`` of the previous cycle, of the same generation only."""
            later_valid = Signal(name=f"valid_{stage}")
            later_facts = Signal(known, name=f"facts_{stage}", reset_less=True)
            m.d.sync += [later_valid.eq(valid & running), later_facts.eq(facts)]
            return later_valid, later_facts

        moved = {}
        for axis in ("x", "y", "altitude"):
            total = base[axis] + self.offset[axis]
            moved[axis] = Signal(total.shape(), name=f"moved_{axis}", reset_less=True)
            m.d.sync += moved[axis].eq(total)
        valid, facts = after("moved", valid, facts)

        waypoint = Signal(axes, name="waypoint_0", reset_less=True)
        for axis, total in moved.items():
            m.d.sync += waypoint[axis].eq(within(m, total, self.limits[axis]))
        valid, facts = after(0, valid, facts)
        m.d.comb += [
            self.lookup_valid.eq(valid),
            self.lookup_x.eq(waypoint.x),
            self.lookup_y.eq(waypoint.y),
        ]

        for stage in range(1, self.lookup_latency + 1):
            valid, facts = after(stage, valid, facts)
            later_waypoint = Signal(axes, name=f"waypoint_{stage}", reset_less=True)
            m.d.sync += later_waypoint.eq(waypoint)
            waypoint = later_waypoint
        return valid, facts, waypoint

    def _decide(self, m, running, valid, facts, waypoint):
        """Compare a candidate with the ground, then accept or reject it."""
        # A register before the decision, because the altitude comes from many memory banks.
        grounded = Signal()
        judged = Signal.like(valid)
        judged_facts = Signal.like(facts, reset_less=True)
        judged_waypoint = Signal.like(waypoint, reset_less=True)
        m.d.sync += [
            grounded.eq(self.avoid & (waypoint.altitude <= self.lookup_altitude)),
            judged.eq(valid & running),
            judged_facts.eq(facts),
            judged_waypoint.eq(waypoint),
        ]

        patches = [
            Signal.like(judged_waypoint, name=f"patch_{number}", reset_less=True)
            for number in range(self.patch_count)
        ]
        m.d.comb += [port.eq(patch) for port, patch in zip(self.patches, patches, strict=True)]
        decided = Signal(len(self.needed))
        concerned = Signal.like(decided)
        m.d.comb += [
            concerned.eq(judged_facts.turn & ~decided & judged.replicate(len(decided))),
            self.decided.eq(decided.all()),
        ]
        with m.If(~running):
            m.d.sync += [decided.eq(~self.needed), self.found.eq(0), self.redrawn.eq(0)]
        with m.Elif(~grounded):
            m.d.sync += [decided.eq(decided | concerned), self.found.eq(self.found | concerned)]
            for concerns, patch in zip(concerned, patches, strict=True):
                with m.If(concerns):
                    m.d.sync += patch.eq(judged_waypoint)
        with m.Elif(judged_facts.last):
            m.d.sync += decided.eq(decided | concerned)
        with m.Else():
            m.d.sync += self.redrawn.eq(self.redrawn + concerned.any())
