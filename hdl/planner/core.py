"""The planner core: map, problem and runs, driven by decoded commands."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.ga_core.random_source import RandomSource
from pathgene.hdl.layouts import cell_layout, record_layout, struct
from pathgene.hdl.planner.best_reader import BestReader
from pathgene.hdl.planner.evolver import Evolver
from pathgene.hdl.planner.first_paths import FirstPaths
from pathgene.hdl.planner.layouts import (
    KEY_BITS,
    corner_layout,
    frame_layout,
    problem_layout,
    shape_layout,
)
from pathgene.hdl.planner.path_evaluator import PathEvaluator
from pathgene.hdl.planner.run_control import RunControl
from pathgene.hdl.planner.shape_drawer import ShapeDrawer
from pathgene.hdl.planner.wavefront.seed_source import SeedSource
from pathgene.hdl.primitives.logic import fanout
from pathgene.hdl.primitives.unit import InstanceOf, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    MEMO_ROWS,
    POSITION_FRACTION,
    VALUE_BITS,
    PathClass,
)
from pathgene.hdl.protocol.runs import ISLANDS, guide_request, run_request


__all__ = ["NearestCorner", "PlannerCore", "RunStatus", "run_status_layout"]


class NearestCorner(Unit):
    """Outputs the corner nearest to a position, and the altitude step at or below it.

    The corner is within the limits. It follows position and limits by one cycle. Equals
    :func:`pathgene.sim.model.planner.definition.score.corner_of`.

    Members
    -------
    position : In(position_layout)
        ``x``, ``y`` and ``altitude``, as in a problem.
    limits : In(corner_layout)
        The altitude is ignored.
    corner : Out(corner_layout)
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        corner = corner_layout(self.coordinate_bits, self.altitude_bits)
        self.position_layout = data.StructLayout(
            {
                "x": self.coordinate_bits + POSITION_FRACTION,
                "y": self.coordinate_bits + POSITION_FRACTION,
                "altitude": self.altitude_bits + ALTITUDE_FRACTION,
            }
        )
        return {"position": In(self.position_layout), "limits": In(corner), "corner": Out(corner)}

    def elaborate(self, platform):
        m = Module()

        position = self.position
        m.d.sync += self.corner.altitude.eq(position.altitude >> ALTITUDE_FRACTION)
        for axis in "xy":
            limit = self.limits[axis]
            nearest = (position[axis] + (1 << POSITION_FRACTION - 1)) >> POSITION_FRACTION
            m.d.sync += self.corner[axis].eq(Mux(nearest > limit, limit, nearest))

        return m


_COUNTER_BITS = 32


def run_status_layout() -> data.StructLayout:
    """Return the layout of the status of a run: its fields in the reply to STATUS."""
    counters = ("generation", "cycles", "key", *UNITS)
    return data.StructLayout({"running": 1, **dict.fromkeys(counters, _COUNTER_BITS)})


class RunStatus(Unit):
    """Counts the cycles of the units in a run, and stores the key of its best path.

    Members
    -------
    launch : In(1)
        Pulse: a run begins.
    running : In(1)
    generations, cycles, score, walk : In(32)
        Counts of the latest run.
    planning, sorting, spreading : In(1)
        Children are being planned, populations sorted, blocks scanned or routes found.
    bred : In(1)
        Pulse: a generation begins. ``best`` is the key of its population 3 cycles later.
    best : In(KEY_BITS)
        Key of the best path of the population last bred from.
    first : In(KEY_BITS)
        Key of the best path, if ``is_first``.
    is_first : In(1)
    void : In(1)
        Pulse: there are no more paths.
    status : Out(run_status_layout)
        Counters stay until the next run. ``running`` and the counts of planning, sorting and
        spreading lag by one cycle; the counts are complete once it is low. ``key`` is void until a
        generation has begun or the run is over, and again from two cycles after ``void`` on.
    """

    def interface(self):
        inputs = {name: In(_COUNTER_BITS) for name in ("generations", "cycles", "score", "walk")}
        flags = ("launch", "running", "planning", "sorting", "spreading", "bred", "is_first")
        return {
            **inputs,
            **{name: In(1) for name in (*flags, "void")},
            "best": In(KEY_BITS),
            "first": In(KEY_BITS),
            "status": Out(run_status_layout()),
        }

    def elaborate(self, platform):
        m = Module()

        status = self.status
        m.d.comb += [
            status.generation.eq(self.generations),
            status.cycles.eq(self.cycles),
            status.score.eq(self.score),
            status.walk.eq(self.walk),
        ]
        # Delay all inputs by one cycle, because they arrive late.
        launched = Signal()
        m.d.sync += [launched.eq(self.launch), status.running.eq(self.running)]
        counted = {"breed": self.planning, "sort": self.sorting, "wavefront": self.spreading}
        for name, is_busy in counted.items():
            counts = Signal(name=f"counts_{name}")
            counter = Signal(_COUNTER_BITS, name=name)
            m.d.sync += [
                counts.eq(is_busy & self.running),
                counter.eq(Mux(launched, 0, counter + counts)),
            ]
            m.d.comb += status[name].eq(counter)

        key = Signal(KEY_BITS, init=PathClass.VOID << VALUE_BITS)
        since = Signal(3)
        m.d.comb += status.key.eq(key)
        m.d.sync += since.eq(Cat(self.bred, since))
        with m.If(since[-1]):
            m.d.sync += key.eq(self.best)
        with m.If(self.is_first):
            m.d.sync += key.eq(self.first)
        # Delay both by one cycle, because they arrive late.
        voids = Signal()
        m.d.sync += voids.eq(self.launch | self.void)
        with m.If(voids):
            m.d.sync += key.eq(PathClass.VOID << VALUE_BITS)

        return m


_AXES = "x", "y", "altitude"


class PlannerCore(Unit):
    """Plans paths: a run breeds, scores, walks and sorts on its own, from seeds along routes.

    Cells, shapes, guides, problems and runs are taken while no run is in progress. A problem
    invalidates the paths of the previous run, but a warm run can still continue from them. Equals
    :func:`pathgene.sim.model.planner.run.plan`, cycles included.

    Members
    -------
    cells : In(stream.Signature(cell_layout))
        Corners of the map.
    shapes : In(stream.Signature(shape_layout))
        Corners to block; a shape is taken once they are blocked. Not while there are ``cells``.
    guides : In(stream.Signature(struct(guide_request(config))))
        Waypoints of the guide.
    problems : In(stream.Signature(problem_layout))
    runs : In(stream.Signature(struct(run_request(config))))
        A run on the latest problem.
    stop : In(1)
        Pulse: breed no more generations.
    running : Out(1)
    has_problem, has_population, has_best : Out(1)
        There is a problem to run on; a population for a warm run; and paths to be read.
    bred : Out(1)
        Pulse: a generation has been bred.
    status : Out(run_status_layout)
        Status of the latest run.
    best : In(1)
        Pulse: send the best paths. Only with ``has_best``, and not while ``running``.
    records : Out(stream.Signature(record_layout))
        See :class:`pathgene.hdl.planner.best_reader.BestReader`.
    """

    config: InstanceOf(Config)
    memo_rows: PowerOfTwo(2, 1 << 16, "Segments of the memo.", name="Rows", also=(0,)) = MEMO_ROWS

    def interface(self):
        config = self.config
        sizes = config.coordinate_bits, config.altitude_bits
        return {
            "cells": In(stream.Signature(cell_layout(*sizes))),
            "shapes": In(stream.Signature(shape_layout(config.coordinate_bits))),
            "guides": In(stream.Signature(struct(guide_request(config)))),
            "problems": In(stream.Signature(problem_layout(config))),
            "runs": In(stream.Signature(struct(run_request(config)))),
            "stop": In(1),
            "running": Out(1),
            "has_problem": Out(1),
            "has_population": Out(1),
            "has_best": Out(1),
            "bred": Out(1),
            "status": Out(run_status_layout()),
            "best": In(1),
            "records": Out(stream.Signature(record_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config
        sizes = config.coordinate_bits, config.altitude_bits

        m.submodules.control = self._control = RunControl(config)
        m.submodules.source = self._source = RandomSource()
        m.submodules.evolver = self._evolver = evolver = Evolver(config, ISLANDS)
        m.submodules.evaluator = self._evaluator = evaluator = PathEvaluator(
            config, evolver.slot_count, self.memo_rows
        )
        m.submodules.seeds = self._seeds = SeedSource(config, evaluator.walker.row_latency)
        places = evolver.slot_count, config.population, config.max_waypoints, *sizes
        m.submodules.first_paths = self._first_paths = FirstPaths(*places)
        m.submodules.reader = self._reader = BestReader(*places)
        m.submodules.drawer = self._drawer = ShapeDrawer(*sizes)
        m.submodules.status = self._status = RunStatus()

        self._take_problems(m)
        self._write_map(m)
        self._run(m)
        self._make_first_paths(m)
        self._evaluate(m)
        self._report(m)

        return m

    def _take_problems(self, m):
        """Keep the problem, and give it to all units."""
        config, control = self.config, self._control
        problem = Signal(problem_layout(config))
        taken = Signal()
        # A run begins a few cycles later, when all of these are steady.
        sizes = config.coordinate_bits, config.altitude_bits
        limits = Signal(corner_layout(*sizes))
        frame = Signal(frame_layout(*sizes))
        m.d.sync += [limits[axis].eq(problem[f"{axis}_limit"]) for axis in _AXES]
        m.d.comb += [
            self.problems.ready.eq(~control.running),
            taken.eq(self.problems.valid & self.problems.ready),
            *(unit.problem.eq(problem) for unit in (self._seeds, self._evaluator)),
            frame.limits.eq(limits),
            *(unit.frame.eq(frame) for unit in (self._evolver, self._seeds, self._first_paths)),
        ]
        for end in ("start", "goal"):
            m.submodules[f"nearest_{end}"] = nearest = NearestCorner(*sizes)
            m.d.comb += [
                nearest.limits.eq(limits),
                *(nearest.position[axis].eq(problem[f"{end}_{axis}"]) for axis in _AXES),
                frame[end].eq(nearest.corner),
            ]
        with m.If(control.ends):
            m.d.sync += [self.has_population.eq(1), self.has_best.eq(1)]
        with m.If(taken):
            m.d.sync += [problem.eq(self.problems.p), self.has_problem.eq(1), self.has_best.eq(0)]
        m.d.comb += self._status.void.eq(taken)

    def _write_map(self, m):
        """Write cells and shapes to the map, and mark their blocks; write the guide."""
        control, drawer, seeds = self._control, self._drawer, self._seeds
        writes, drawn = self._evaluator.writes, drawer.cells
        m.d.comb += [
            self.cells.ready.eq(~control.running),
            drawer.shapes.p.eq(self.shapes.p),
            drawer.shapes.valid.eq(self.shapes.valid & ~control.running),
            self.shapes.ready.eq(drawer.shapes.ready & ~control.running),
            drawn.ready.eq(1),
            writes.p.eq(Mux(drawn.valid, drawn.p, self.cells.p)),
            writes.valid.eq(drawn.valid | (self.cells.valid & self.cells.ready)),
            seeds.write.valid.eq(writes.valid),
            *(seeds.write[axis].eq(writes.p[axis]) for axis in "xy"),
            self._evaluator.row.eq(seeds.row),
            *(
                own.eq(corner)
                for own, corner in zip(seeds.corners, self._evaluator.corners, strict=True)
            ),
            self.guides.ready.eq(~control.running),
            seeds.guide.valid.eq(self.guides.valid & self.guides.ready),
            *(seeds.guide[name].eq(self.guides.p[name]) for name in ("index", *_AXES)),
        ]

    def _run(self, m):
        """Connect the control unit, which goes through the steps of a run."""
        control, source, seeds = self._control, self._source, self._seeds
        evolver, evaluator = self._evolver, self._evaluator
        options = control.options
        # The scorer has its own copy, because it is far from the control unit.
        (phase,) = fanout(m, ~control.phase, name="scorer_phase")
        m.d.comb += [
            # The memo is cleared after a reset.
            control.runs.p.eq(self.runs.p),
            control.runs.valid.eq(self.runs.valid & ~evaluator.busy),
            self.runs.ready.eq(control.runs.ready & ~evaluator.busy),
            control.stop.eq(self.stop),
            self.running.eq(control.running),
            self.bred.eq(control.begin),
            source.load.eq(control.launch),
            source.seed.eq(options.seed),
            source.step.eq(seeds.step | (evolver.words.valid & evolver.words.ready)),
            seeds.word.eq(source.words[0]),
            seeds.word_ready.eq(source.ready),
            evolver.words.p.eq(source.words),
            evolver.words.valid.eq(source.ready),
            evaluator.clear.eq(control.launch),
            evaluator.clear_counters.eq(control.launch),
            evaluator.phase.eq(phase),
            control.source_ready.eq(source.ready),
            control.memo_busy.eq(evaluator.busy),
            control.seeds_busy.eq(seeds.busy),
            seeds.scan.eq(control.launch),
            seeds.by_turns.eq(control.by_turns),
            seeds.guided.eq(control.guided),
            seeds.launch.eq(control.find_route),
            seeds.limit.eq(control.slope),
            control.evaluator_idle.eq(evaluator.idle),
            control.evolver_ready.eq(evolver.ready),
            control.feasible.eq(evolver.feasible),
            evolver.give_up_rank.eq(options.give_up_rank),
            *(
                getattr(evolver, name).eq(getattr(control, name))
                for name in ("clear", "fills", "store", "begin", "finish", "merge", "island")
            ),
        ]

    def _make_first_paths(self, m):
        """Connect the units that make and read paths with the memory of the populations."""
        control, seeds, evolver = self._control, self._seeds, self._evolver
        first_paths, reader = self._first_paths, self._reader
        m.d.comb += [
            first_paths.launch.eq(control.make_paths),
            first_paths.kind.eq(control.kind),
            first_paths.count.eq(control.count),
            control.paths_busy.eq(first_paths.busy),
            seeds.begin.eq(first_paths.begin_seed),
            first_paths.seed_busy.eq(seeds.busy),
            first_paths.seed.eq(seeds.found),
            evolver.write.eq(first_paths.write),
            evolver.rank.eq(Mux(control.running, first_paths.rank, reader.rank)),
            evolver.read.eq(Mux(control.running, first_paths.read, reader.read)),
        ]
        connect(m, evolver.slots, first_paths.free_slots)
        for unit in (first_paths, reader):
            m.d.comb += [unit.member.eq(evolver.member), unit.waypoint.eq(evolver.waypoint)]

    def _evaluate(self, m):
        """Evaluate first paths or children."""
        evolver, evaluator, first_paths = self._evolver, self._evaluator, self._first_paths
        fills = self._control.fills
        paths, points = evaluator.paths, evaluator.points
        m.d.comb += [
            paths.valid.eq(Mux(fills, first_paths.paths.valid, evolver.children.valid)),
            paths.p.eq(evolver.children.p),
            points.valid.eq(Mux(fills, first_paths.points.valid, evolver.points.valid)),
            points.p.eq(Mux(fills, first_paths.points.p, evolver.points.p)),
            first_paths.paths.ready.eq(paths.ready & fills),
            evolver.children.ready.eq(paths.ready & ~fills),
            first_paths.points.ready.eq(points.ready & fills),
            evolver.points.ready.eq(points.ready & ~fills),
        ]
        with m.If(fills):
            m.d.comb += [
                paths.p.slot.eq(first_paths.paths.p),
                paths.p.first.eq(0),
                paths.p.limited.eq(0),
            ]
        connect(m, evaluator.evaluated, evolver.evaluated)
        m.d.comb += [
            evolver.decided.eq(evaluator.decided),
            evolver.margin.eq(evaluator.margin),
        ]

    def _report(self, m):
        """Report the status of the run, and its best paths."""
        control, evolver, evaluator = self._control, self._evolver, self._evaluator
        reader, status = self._reader, self._status
        connect(m, reader.records, flipped(self.records))
        m.d.comb += [
            reader.best.eq(self.best),
            reader.count.eq(control.options.paths),
            status.launch.eq(control.launch),
            status.running.eq(control.running),
            status.generations.eq(control.generations),
            status.cycles.eq(control.cycles),
            status.score.eq(evaluator.score),
            status.walk.eq(evaluator.walk),
            status.planning.eq(evolver.planning),
            status.sorting.eq(evolver.sorting),
            status.spreading.eq(control.spreading),
            status.bred.eq(control.begin),
            status.best.eq(evolver.best),
            # Without a request, the best member is read.
            status.first.eq(evolver.member.key),
            status.is_first.eq(self.has_best & ~control.running & ~reader.busy),
            self.status.eq(status.status),
        ]
