"""Control of a run: its steps, from the blocks of the map to the last generation; its limits."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import struct
from pathgene.hdl.planner.first_paths import FirstPathKind
from pathgene.hdl.primitives.unit import InstanceOf, Unit, Width
from pathgene.hdl.protocol.runs import ISLANDS, SLOPE_BITS, run_request


__all__ = ["RunControl", "RunLimits"]


class RunLimits(Unit):
    """Counts the cycles and generations of a run, and says when to stop breeding.

    ``split`` takes an island's part: ``share / 2**share_bits`` of the remaining cycles, and of the
    generations of the run, rounded down. ``aim`` sets the limits of the run, or the limits of an
    island: the current counts plus its parts, clamped to the maximum count.

    Members
    -------
    launch : In(1)
        Pulse: a run begins in the next cycle, which is cycle 0.
    running : In(1)
        High from that cycle to the last cycle of the run.
    bred : In(1)
        Pulse: a generation has been bred.
    stop : In(1)
        Pulse: breed no more generations. Ignored unless ``running``.
    most_cycles, most_generations : In(counter_bits)
    share : In(share_bits)
        Limits of the run, and the share of an island. Steady while ``running``.
    split : In(1)
        Pulse: take an island's part of the cycles that remain after this cycle.
    splitting : Out(1)
        High for ``share_bits`` cycles, from the cycle after ``split`` on.
    aim : In(1)
        Pulse: set limits that apply from the next cycle on. Not while ``splitting``.
    waits : In(1)
        The limit on generations does not count yet.
    final : In(1)
        With ``aim``: set the limits of the run; otherwise the current counts plus the island's
        parts.
    reached : Out(1)
        In the previous cycle, a limit was reached, or the run had been stopped.
    cycles : Out(counter_bits)
        Number of this cycle; after the run, its number of cycles. Saturates.
    generations : Out(counter_bits)
        Generations bred before this cycle.
    """

    counter_bits: Width(1)
    share_bits: Width(1)

    def interface(self):
        return {
            "launch": In(1),
            "running": In(1),
            "bred": In(1),
            "stop": In(1),
            "most_cycles": In(self.counter_bits),
            "most_generations": In(self.counter_bits),
            "share": In(self.share_bits),
            "split": In(1),
            "splitting": Out(1),
            "aim": In(1),
            "waits": In(1),
            "final": In(1),
            "reached": Out(1),
            "cycles": Out(self.counter_bits),
            "generations": Out(self.counter_bits),
        }

    def elaborate(self, platform):
        m = Module()

        stopped = Signal()
        with m.If(self.running):
            m.d.sync += [
                self.cycles.eq(self.cycles + ~self.cycles.all()),
                self.generations.eq(self.generations + self.bred),
                stopped.eq(stopped | self.stop),
            ]
        with m.If(self.launch):
            m.d.sync += [self.cycles.eq(0), self.generations.eq(0), stopped.eq(0)]

        # A part is a product with the share, computed one bit of the share per cycle, lowest first.
        bits = self.counter_bits
        left = Signal(bits, reset_less=True)
        difference = Signal(bits + 1)
        share = Signal(self.share_bits, reset_less=True)
        number = Signal(range(self.share_bits + 1))
        m.d.comb += [
            difference.eq(self.most_cycles - self.cycles),
            self.splitting.eq(number != 0),
        ]
        parts = []
        for name, whole in (("cycles", left), ("generations", self.most_generations)):
            part = Signal(bits, name=f"part_of_{name}", reset_less=True)
            with m.If(self.splitting):
                m.d.sync += part.eq((part + Mux(share[0], whole, 0)) >> 1)
            with m.If(self.split):
                m.d.sync += part.eq(0)
            parts.append(part)
        with m.If(self.splitting):
            m.d.sync += [number.eq(number - 1), share.eq(share >> 1)]
        with m.If(self.split):
            m.d.sync += [
                left.eq(Mux(difference[-1], 0, difference)),
                share.eq(self.share),
                number.eq(self.share_bits),
            ]

        limits = []
        for name, count, part, most in (
            ("cycles", self.cycles, parts[0], self.most_cycles),
            ("generations", self.generations, parts[1], self.most_generations),
        ):
            limit = Signal(bits, name=f"limit_of_{name}", reset_less=True)
            end = Signal(bits + 1, name=f"end_of_{name}")
            m.d.comb += end.eq(count + part)
            with m.If(self.aim):
                m.d.sync += limit.eq(Mux(self.final, most, end | end[-1].replicate(len(end))))
            limits.append(limit)
        m.d.sync += self.reached.eq(
            stopped | (self.cycles >= limits[0]) | ((self.generations >= limits[1]) & ~self.waits)
        )

        return m


class RunControl(Unit):
    """Sequences the steps of a run, each when the previous one is done.

    Blocks are scanned while the random source warms up and the memo is cleared. In a warm run, the
    earlier population is revived as island 0. Each island of new paths gets a route, seeds, and
    passes that lift its population; the first of them needs no route if it is guided. If there are
    two islands, each is bred for its share of the remaining cycles and generations, then the best
    of both become one population, which is bred to the limits of the run. If the limits wait for a
    feasible path, generations do not count until there is one.

    A generation begins in the cycle after ``evolver_ready``, unless a limit was reached in that
    cycle or the run had been stopped; then the last generation is finished instead. All other
    numbers of cycles are in :mod:`pathgene.sim.model.planner.run_cycles`. A run ends if the units
    do: ``make formal PROOF=run_control``.

    Members
    -------
    runs : In(stream.Signature(struct(run_request(config))))
        The options of a run. Taken while no run is ``running``, in cycles with ``phase``.
    stop : In(1)
        Pulse: breed no more generations. Ignored unless ``running``.
    running : Out(1)
        High from cycle 0 of the run, the cycle after it is taken, to its last cycle.
    ends : Out(1)
        The last cycle of the run.
    phase : Out(1)
        Alternates; 0 in cycle 0 of a run.
    options : Out(struct(run_request(config)))
        Options of the latest run. Registers.
    cycles, generations : Out(32)
        Counts of the latest run, even while it is in progress.
    launch : Out(1)
        Cycle 0: load the random source, clear the memo, scan the blocks.
    clear : Out(1)
        With ``launch``: free all slots.
    source_ready, memo_busy, seeds_busy : In(1)
        State of the random source, the memo, and the source of seeds.
    find_route : Out(1)
        Pulse: find a route along ``slope``.
    slope : Out(SLOPE_BITS)
        Steady until the next route.
    by_turns : Out(1)
        Its seeds have their waypoints at its turns: the first island, unless the start is warm.
        Steady like ``slope``.
    guided : Out(8)
        Number of waypoints of the guide if they are the waypoints of the seeds, otherwise 0. Steady
        like ``slope``.
    spreading : Out(1)
        Blocks are being scanned, or a route is being found.
    make_paths : Out(1)
        Pulse: make first paths.
    kind : Out(FirstPathKind)
    count : Out(16)
        Kind and number of the paths. Steady until they are stored.
    paths_busy : In(1)
        High from the cycle after ``make_paths`` until the last path has been output.
    evaluator_idle : In(1)
        No path is being evaluated.
    fills : Out(1)
        First populations are being filled, from the cycle after ``launch`` on.
    store : Out(1)
        Pulse: the first population of ``island`` is complete.
    begin, finish : Out(1)
        Pulses: breed a generation of ``island``; collect the last one without breeding.
    merge : Out(1)
        Pulse: make the best of both islands the population of island 0.
    island : Out(range(ISLANDS))
        Steady while a population is being filled, bred or merged.
    evolver_ready : In(1)
        A generation may begin, because any population that was stored, finished or merged is
        complete. Undefined in the cycle after a pulse, like the answers of all units.
    feasible : In(1)
        With ``evolver_ready``: the best path of the population is feasible.
    """

    config: InstanceOf(Config)

    #: Width of counters, and of the share of an island.
    COUNTER_BITS, SHARE_BITS = 32, 5

    def interface(self):
        options = struct(run_request(self.config))
        return {
            "runs": In(stream.Signature(options)),
            "stop": In(1),
            "running": Out(1),
            "ends": Out(1),
            "phase": Out(1),
            "options": Out(options),
            "cycles": Out(self.COUNTER_BITS),
            "generations": Out(self.COUNTER_BITS),
            "launch": Out(1),
            "clear": Out(1),
            "source_ready": In(1),
            "memo_busy": In(1),
            "seeds_busy": In(1),
            "find_route": Out(1),
            "slope": Out(SLOPE_BITS),
            "by_turns": Out(1),
            "guided": Out(8),
            "spreading": Out(1),
            "make_paths": Out(1),
            "kind": Out(FirstPathKind),
            "count": Out(16),
            "paths_busy": In(1),
            "evaluator_idle": In(1),
            "fills": Out(1),
            "store": Out(1),
            "begin": Out(1),
            "finish": Out(1),
            "merge": Out(1),
            "island": Out(range(ISLANDS)),
            "evolver_ready": In(1),
            "feasible": In(1),
        }

    def elaborate(self, platform):
        m = Module()
        options = self.options
        m.submodules.limits = limits = RunLimits(self.COUNTER_BITS, self.SHARE_BITS)
        taken = self.runs.valid & self.runs.ready
        m.d.comb += [
            limits.launch.eq(taken),
            limits.running.eq(self.running),
            limits.bred.eq(self.begin),
            limits.stop.eq(self.stop),
            limits.most_cycles.eq(options.cycles),
            limits.most_generations.eq(options.generations),
            limits.share.eq(options.share),
            self.cycles.eq(limits.cycles),
            self.generations.eq(limits.generations),
        ]
        m.d.sync += self.phase.eq(~self.phase)

        # `settled`: this is not the cycle after a pulse, in which units do not respond yet.
        settled = Signal()
        last_island = Signal()
        lifts = Signal(len(options.lifts), reset_less=True)
        # There is one population; a generation is not yet collected.
        is_final = Signal()
        pending = Signal()
        m.d.comb += [
            limits.final.eq(is_final),
            limits.waits.eq(is_final & options.until_feasible & ~self.feasible),
            self.by_turns.eq(~self.island.any() & ~options.warm),
            self.guided.eq(Mux(self.island.any() & ~options.warm, 0, options.guided)),
            self.slope.eq(Mux(self.island.any() & ~options.warm, options.slope_1, options.slope_0)),
            self.count.eq(
                Mux(self.kind == FirstPathKind.SEED, options.seeds, self.config.population)
            ),
        ]
        m.d.sync += settled.eq(~Cat(getattr(self, name) for name in _PULSES).any())

        with m.FSM():
            with m.State("IDLE"):
                m.d.comb += self.runs.ready.eq(self.phase)
                with m.If(taken):
                    m.d.sync += [options.eq(self.runs.p), self.running.eq(1)]
                    m.next = "START"
            with m.State("START"):
                m.d.comb += [self.launch.eq(1), self.clear.eq(~options.warm)]
                m.d.sync += [
                    self.fills.eq(1),
                    self.island.eq(0),
                    last_island.eq(options.warm + options.islands == ISLANDS),
                    self.kind.eq(Mux(options.warm, FirstPathKind.REVIVED, FirstPathKind.SEED)),
                    lifts.eq(Mux(options.warm, 0, options.lifts)),
                    pending.eq(0),
                ]
                m.next = "SCAN"
            with m.State("SCAN"):
                m.d.comb += self.spreading.eq(self.seeds_busy)
                m.d.sync += is_final.eq(~last_island)
                with m.If(settled & self.source_ready & ~self.memo_busy & ~self.seeds_busy):
                    m.next = "ROUTE"
                    with m.If(options.warm | options.guided.any()):
                        m.next = "PATHS"
            self._make_first_population(m, settled, last_island, lifts)
            self._breed(m, limits, settled, is_final, pending)
            with m.State("END"):
                m.d.comb += self.ends.eq(1)
                m.d.sync += self.running.eq(0)
                m.next = "IDLE"

        return m

    def _make_first_population(self, m, settled, last_island, lifts):
        """Add the states of an island's first population."""
        options = self.options
        with m.State("ROUTE"):
            m.d.comb += self.find_route.eq(1)
            m.next = "ROUTED"
        with m.State("ROUTED"):
            m.d.comb += self.spreading.eq(self.seeds_busy)
            with m.If(settled & ~self.seeds_busy):
                m.next = "PATHS"
        with m.State("PATHS"):
            m.d.comb += self.make_paths.eq(1)
            m.next = "EVALUATED"
        with m.State("EVALUATED"):
            with m.If(settled & ~self.paths_busy & self.evaluator_idle):
                m.next = "STORE"
        with m.State("STORE"):
            m.d.comb += self.store.eq(1)
            m.next = "STORED"
        with m.State("STORED"):
            with m.If(settled & self.evolver_ready):
                with m.If(lifts != 0):
                    m.d.sync += [lifts.eq(lifts - 1), self.kind.eq(FirstPathKind.LIFTED)]
                    m.next = "PATHS"
                with m.Elif(self.island != last_island):
                    m.d.sync += [
                        self.island.eq(1),
                        self.kind.eq(FirstPathKind.SEED),
                        lifts.eq(options.lifts),
                    ]
                    m.next = "ROUTE"
                    with m.If(options.warm & options.guided.any()):
                        m.next = "PATHS"
                with m.Else():
                    m.d.sync += [self.fills.eq(0), self.island.eq(0)]
                    m.next = "AIM"
                    with m.If(last_island):
                        m.next = "SPLIT"

    def _breed(self, m, limits, settled, is_final, pending):
        """Add the states of generations, for an island or for the one population."""
        with m.State("SPLIT"):
            m.d.comb += limits.split.eq(1)
            m.next = "SPLITTING"
        with m.State("SPLITTING"):
            with m.If(~limits.splitting):
                m.next = "AIM"
        with m.State("AIM"):
            m.d.comb += limits.aim.eq(1)
            m.next = "EVOLVE"
        with m.State("EVOLVE"):
            with m.If(settled & self.evolver_ready):
                m.next = "DECIDE"
        with m.State("DECIDE"):
            with m.If(~limits.reached):
                m.d.comb += self.begin.eq(1)
                m.d.sync += pending.eq(1)
                m.next = "EVOLVE"
            with m.Elif(pending):
                m.d.comb += self.finish.eq(1)
                m.d.sync += pending.eq(0)
                m.next = "EVOLVE"
            with m.Elif(is_final):
                m.next = "END"
            with m.Elif(self.island == 0):
                m.d.sync += self.island.eq(1)
                m.next = "AIM"
            with m.Else():
                m.next = "MERGE"
        with m.State("MERGE"):
            m.d.comb += self.merge.eq(1)
            m.d.sync += [self.island.eq(0), is_final.eq(1)]
            m.next = "AIM"


#: Pulses to which units respond in the second cycle after them or later.
_PULSES = ("launch", "find_route", "make_paths", "store", "begin", "finish", "merge")
