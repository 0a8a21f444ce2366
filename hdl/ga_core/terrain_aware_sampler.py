"""Makes the new waypoints of a chip with a map, none of them in the ground."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.ga_core.layouts import limits_layout, offset_layout
from hdl.ga_core.mutation_plan import plan_layout
from hdl.ga_core.read_pointer import PEEK_LATENCY
from hdl.ga_core.waypoint_perturber import within
from hdl.primitives.multiplexer import multiplex, one_hot_multiplex


__all__ = ["TerrainAwareSampler"]


class TerrainAwareSampler(wiring.Component):
    """Makes new waypoints that are above the ground, with one look at the map a clock.

    Before a generation, as soon as the mutators' plans are there, the waypoints that they work on
    are read ahead through the ports: ``fetched`` is high :meth:`latency_of` clocks after ``fetch``,
    if the population is ``settled``.

    While the parents pass, a candidate a clock is moved, kept within the limits and looked up: the
    first of every patch, then the second of every patch, and so on. A patch becomes its first
    candidate that is above the ground: higher than its cell. It is *decided* when that has been
    found, or none: after candidate ``n`` of all, counted from 0, ``n + lookup_latency + 5`` clocks
    after ``run`` rose.

    Source: none; *allaire-2008*, section 4.6, mutates without a look at the ground.

    Parameters
    ----------
    config : Config
        With a map.

    Members
    -------
    plans : In(plan_layout).array(patches)
    needed : In(patches)
        Which patches are to be made. Both must stay from ``fetch`` to the end of ``run``.
    fetch : In(1)
        Pulse: the plans are complete.
    clear : In(1)
        What has been fetched is void. Stronger than ``fetch``.
    settled : In(1)
    peeks, peek : Out(1)
    peek_position : Out(index_bits)
    waypoints : In(waypoint_bits).array(crossovers)
        See :class:`hdl.ga_core.population.Population`; its ports of the parents.
    fetched : Out(1)
        Pulse: a generation may start.
    run : In(1)
        From the next clock on a generation is under way, and what has been decided is wanted. What
        is said below holds from two clocks after ``run`` rises to the second clock after it falls.
    offset : In(offset_layout)
        Of the next candidate.
    offset_taken : Out(1)
        It has been taken: the following one is wanted in the next clock.
    limits : In(limits_layout)
    avoid : In(1)
        Whether to refuse candidates in the ground; otherwise every first one is taken.
    lookup_valid : Out(1)
    lookup_x, lookup_y : Out(coordinate_bits)
        The cell of a candidate.
    lookup_altitude : In(altitude_bits)
        The ground of the cell of ``config.lookup_latency`` clocks ago.
    decided : Out(1)
        All patches that are needed have been decided.
    found : Out(patches)
        Which of them have been made; 0 for one that is not needed.
    patches : Out(waypoint_bits).array(patches)
        The new waypoints that have been found.
    redrawn : Out(range(patches * candidates))
        Candidates that took the place of one in the ground.
    """

    @staticmethod
    def latency_of(config: Config) -> int:
        """Return the clocks from ``fetch`` to ``fetched``."""
        return config.patches + PEEK_LATENCY + 1

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        super().__init__(
            {
                "plans": In(plan_layout(config)).array(config.patches),
                "needed": In(config.patches),
                "fetch": In(1),
                "clear": In(1),
                "settled": In(1),
                "peeks": Out(1),
                "peek": Out(1),
                "peek_position": Out(config.index_bits),
                "waypoints": In(config.waypoint_bits).array(config.crossovers),
                "fetched": Out(1),
                "run": In(1),
                "offset": In(offset_layout(config)),
                "offset_taken": Out(1),
                "limits": In(limits_layout(config)),
                "avoid": In(1),
                "lookup_valid": Out(1),
                "lookup_x": Out(config.coordinate_bits),
                "lookup_y": Out(config.coordinate_bits),
                "lookup_altitude": In(config.altitude_bits),
                "decided": Out(1),
                "found": Out(config.patches),
                "patches": Out(config.waypoint_bits).array(config.patches),
                "redrawn": Out(range(config.patches * config.candidates)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        running = Signal()
        m.d.sync += running.eq(self.run)

        # A queue of the waypoints to be moved. The one that is moved goes to its end.
        axes = limits_layout(self.config)
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
        """Read the waypoints ahead; return whether the next is there, and that waypoint."""
        config = self.config

        wanted = Signal()
        number = Signal(range(config.patches))
        last = number == config.patches - 1
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
            delayed = Signal(range(config.crossovers), name=f"parent_{stage}", reset_less=True)
            m.d.sync += delayed.eq(parent)
            parent = delayed
        select = Signal(config.crossovers, reset_less=True)
        m.d.sync += [
            select.eq(1 << parent),
            self.fetched.eq(valid[-1] & ~valid[-2] & ~self.clear),
        ]
        return valid[-1], one_hot_multiplex(select, self.waypoints)

    def _candidates(self, m, running, base):
        """Make and look up the candidates; return what is known of the one looked up last.

        These are: whether there is one, its patch (one-hot), whether it is the patch's last, and
        the waypoint. Each step ends in registers.
        """
        config = self.config
        axes = limits_layout(config)

        turn = Signal(config.patches, init=1)
        candidate = Signal(range(max(2, config.candidates)))
        exhausted = Signal()
        last = candidate == config.candidates - 1
        exhausts = Signal()
        m.d.comb += exhausts.eq(exhausted | (self.offset_taken & turn[-1] & last))
        # It enables all bases and all offsets: a register.
        m.d.sync += self.offset_taken.eq(self.run & ~exhausts)
        with m.If(~running):
            m.d.sync += [turn.eq(1), candidate.eq(0), exhausted.eq(0)]
        with m.Else():
            m.d.sync += [turn.eq(turn.rotate_left(1)), exhausted.eq(exhausts)]
            with m.If(turn[-1]):
                m.d.sync += candidate.eq(candidate + 1)

        valid = self.offset_taken
        known = data.StructLayout({"turn": config.patches, "last": 1})
        facts = Signal(known)
        m.d.comb += [facts.turn.eq(turn), facts.last.eq(last)]

        def after(stage, valid, facts):
            """Return ``valid`` and ``facts`` of a clock ago. None outlives its generation."""
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

        for stage in range(1, config.lookup_latency + 1):
            valid, facts = after(stage, valid, facts)
            later_waypoint = Signal(axes, name=f"waypoint_{stage}", reset_less=True)
            m.d.sync += later_waypoint.eq(waypoint)
            waypoint = later_waypoint
        return valid, facts, waypoint

    def _decide(self, m, running, valid, facts, waypoint):
        """Compare a candidate with the ground, then take it or not."""
        # A register of its own: the altitude comes out of many banks of memory.
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
            for number in range(self.config.patches)
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
