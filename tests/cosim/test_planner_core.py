"""The exported planner in Verilator: whole runs against the model, all they report included."""

import dataclasses
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from amaranth.back import verilog

from hdl.layouts import struct as struct_of
from hdl.planner.core import PlannerCore
from hdl.planner.layouts import problem_layout, shape_layout
from hdl.planner.run_status import run_status_layout
from hdl.protocol.planner import VALUE_BITS, NoFlyShape, PathClass
from hdl.protocol.runs import ISLANDS, RETURNED, RunOptions, pack_best, run_request
from hdl.verilog import strip_zero_init
from sim.cache import BuildCache, build_root
from sim.exported import cached_verilog
from sim.model.block_marks import BlockMarks
from sim.model.planner.definition.no_fly import drawn
from sim.model.planner.drawing_cycles import drawing
from sim.model.planner.run import plan
from sim.verilator import build_verilator
from tests import planner_cases
from tests.planner_cases import SMALL, USUAL


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

#: A chip of longer paths on a larger map.
MEDIUM = SMALL.replace(
    population=16, children=10, elites=2, survivors=4, max_waypoints=16, map_size=128,
    altitude_bits=10,
)  # fmt: skip
COUNTERS = "breed", "score", "walk", "sort", "wavefront"


def planner_verilog(config, rows):
    """Return the Verilog of the planner."""
    dut = PlannerCore(config, rows)
    return strip_zero_init(verilog.convert(dut, name="planner_core", emit_src=False))


class VerilatedPlanner:
    """The planner, simulated by Verilator in another process, and its map.

    With ``builds``, it compiles quickly and simulates slowly. ``text`` is other Verilog of it.
    """

    def __init__(self, config, rows, builds=None, text=None):
        def export():
            return planner_verilog(config, rows)

        kept = builds is None
        if text is None:
            key = "planner_core", repr(config), str(rows)
            text = cached_verilog(export, *key) if kept else export()
        program = build_verilator(
            BuildCache(build_root() / "sim") if kept else builds,
            text,
            "planner_core",
            main=Path(__file__).with_name("planner_core.cpp"),
            optimize="-O1" if kept else "-O0",
        )
        self.config = config
        self.status_layout = run_status_layout()
        self._process = subprocess.Popen(
            [str(program)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.terminate()
        self._process.wait()

    def write(self, ground, x, y):
        """Write these corners of the ground."""
        bits = self.config.coordinate_bits
        words = x | y << bits | ground[y, x].astype(np.int64) << 2 * bits
        self._send(1, len(words), *words.tolist())

    def pose(self, record):
        self._send(2, *self._words(problem_layout(self.config), vars(record)))

    def draw(self, shape):
        """Draw a shape; return the cycles."""
        layout = shape_layout(self.config.coordinate_bits)
        values = {name: getattr(shape, name) for name, _ in layout if hasattr(shape, name)}
        for i, edge in enumerate(shape.edges):
            values |= {f"{name}_{i}": part for name, part in zip(_EDGE, edge, strict=True)}
        self._send(3, *self._words(layout, values))
        return self._receive(1)[0]

    def run(self, options, *, gap=0, stop=0):
        """Run to the end; return the cycles, and the generations that were told."""
        request = run_request(self.config)
        values = request.unpack(options.pack(self.config))
        self._send(4, gap, stop, *self._words(struct_of(request), values))
        return tuple(self._receive(2))

    def stop(self):
        """Stop, where there is no run."""
        self._send(8)

    def reset_in_run(self, options, cycles):
        """Start a run, and reset the chip so many cycles later."""
        request = run_request(self.config)
        values = request.unpack(options.pack(self.config))
        self._send(7, cycles, *self._words(struct_of(request), values))

    def status(self):
        """Return what there is, and the fields of the status."""
        self._send(5)
        flags = self._receive(3)
        size = -(-self.status_layout.size // 32)
        bits = sum(word << 32 * i for i, word in enumerate(self._receive(size)))
        fields = {
            name: bits >> field.offset & (1 << field.width) - 1
            for name, field in self.status_layout
        }
        return flags, fields

    def best(self, stall=0):
        self._send(6, stall)
        return bytes(self._receive(self._receive(1)[0]))

    def _words(self, layout, values):
        bits = layout.const(values).as_bits()
        return [bits >> 32 * i & 0xFFFFFFFF for i in range(-(-layout.size // 32))]

    def _send(self, *numbers):
        self._process.stdin.write(struct.pack(f"<{len(numbers)}Q", *numbers))
        self._process.stdin.flush()

    def _receive(self, numbers):
        data = self._process.stdout.read(8 * numbers)
        if len(data) < 8 * numbers:
            raise EOFError("the simulated planner has ended")
        return list(struct.unpack(f"<{numbers}Q", data))


_EDGE = "at", "east", "north"


class Flight:
    """A planner and its model, which get the same maps, problems and runs."""

    def __init__(self, config, rows, seed, chip):
        self.config, self.rows, self.chip = config, rows, chip
        self.rng = np.random.default_rng(seed)
        self.marks = BlockMarks()
        self.ground = self.record = self.outcome = None
        self.kinds = set()

    def choose(self, *values):
        return values[int(self.rng.integers(len(values)))]

    def upload(self):
        """Upload a new map."""
        blocked = self.choose(0, 0.001, 0.02)
        self.ground = planner_cases.ground(self.config, self.rng, blocked=blocked)
        y, x = np.indices(self.ground.shape)
        self._write(x.ravel(), y.ravel())

    def change(self):
        """Write some corners, or draw a shape."""
        config, size = self.config, self.config.map_size
        if self.rng.random() < 0.5:
            x, y = self.rng.integers(size, size=(2, int(self.rng.integers(30))))
            heights = self.rng.integers(config.blocked_altitude + 1, size=len(x))
            self.ground[y, x] = heights
            self._write(x, y)
        else:
            # As the chip gets it: with all edges.
            shape = NoFlyShape.unpack(config, planner_cases.shape(config, self.rng).pack(config))
            corners = np.array(drawn(shape), dtype=int).reshape(-1, 2)
            self.ground[corners[:, 1], corners[:, 0]] = config.blocked_altitude
            assert self.chip.draw(shape) == drawing(shape) - 1
            self.marks.write(corners[:, 0], corners[:, 1])

    def _write(self, x, y):
        self.chip.write(self.ground, x, y)
        self.marks.write(x, y)

    def pose(self, **changes):
        """Pose a problem; entry and exit are there in some."""
        self.record = planner_cases.record(self.config, self.rng, **changes)
        if self.rng.random() < 0.6:
            self.record = planner_cases.headed(self.config, self.rng, self.record)
        self.chip.pose(self.record)
        self.marks.shift = self.record.block_shift
        flags, status = self.chip.status()
        assert flags == [1, self.outcome is not None, 0]
        assert status["running"] == 0
        assert status["key"] >> VALUE_BITS == PathClass.VOID

    def options(self, generations):
        rng = self.rng
        warm = self.outcome is not None and rng.random() < 0.4
        slopes = rng.integers(16, size=int(rng.integers(1 - warm, ISLANDS + 1 - warm))).tolist()
        cycles = self.choose(0, 30_000, 100_000, 10**9)
        return RunOptions(
            seed=int(rng.integers(1 << 63)),
            cycles=cycles,
            generations=int(rng.integers(generations)),
            # Some problems have no feasible path.
            until_feasible=cycles < 10**9 and rng.random() < 0.5,
            give_up_rank=int(rng.integers(self.config.population)),
            slopes=tuple(slopes),
            seeds=self.config.population + int(rng.integers(40)),
            lifts=int(rng.integers(5)),
            share=int(rng.integers(17)),
            paths=int(rng.integers(1, RETURNED + 1)),
            warm=warm,
            memo=self.rows,
        )

    def run(self, options):
        """Run both and compare everything."""
        before = self.outcome.population if options.warm else None
        marked = self.marks.scan()
        self.outcome = out = plan(
            self.config, self.ground, self.record, options, before, marked=marked
        )
        done = self.chip.run(options, gap=int(self.rng.integers(3)))
        assert done == (out.cycles, out.generations), options
        self.compare(options)
        islands = len(options.slopes) + options.warm
        waited = out.generations > options.generations
        self.kinds.add((islands, options.warm, self.record.has_entry, self.record.has_exit, waited))

    def compare(self, note):
        out = self.outcome
        flags, status = self.chip.status()
        assert flags == [1, 1, 1]
        assert status == {
            "running": 0,
            "generation": out.generations,
            "cycles": out.cycles,
            "key": out.keys[0],
            **{name: getattr(out, name) for name in COUNTERS},
        }, note
        bits = self.config.coordinate_bits
        packed = [[x | y << bits | z << 2 * bits for x, y, z in path] for path in out.paths]
        stall = self.choose(0, 0, 3)
        assert self.chip.best(stall) == pack_best(self.config, packed, out.keys), note


def fly(config, rows, seed, runs, generations, builds=None, text=None):
    """Do runs on changing maps and problems; return the kinds of runs."""
    with VerilatedPlanner(config, rows, builds, text) as chip:
        flight = Flight(config, rows, seed, chip)
        assert chip.status()[0] == [0, 0, 0]
        for number in range(runs):
            if number % 8 == 0:
                flight.upload()
            elif flight.rng.random() < 0.6:
                flight.change()
            if number % 8 == 0 or flight.rng.random() < 0.6:
                flight.pose()
            flight.run(flight.options(generations))
        return flight.kinds


@pytest.mark.parametrize(
    ("config", "rows", "runs", "generations"),
    [
        pytest.param(SMALL, 64, 60, 120, id="small"),
        pytest.param(MEDIUM, 256, 60, 100, id="medium"),
        pytest.param(USUAL, 512, 4, 40, id="usual"),
        pytest.param(
            SMALL.replace(lanes=1, memory_latency=1),
            0,
            200,
            60,
            id="long-no-memo",
            marks=pytest.mark.long,
        ),
        pytest.param(SMALL.replace(lanes=16), 16, 200, 60, id="long-lanes", marks=pytest.mark.long),
        pytest.param(SMALL, 64, 3000, 150, id="long-small", marks=pytest.mark.long),
        pytest.param(MEDIUM, 256, 400, 200, id="long-medium", marks=pytest.mark.long),
        pytest.param(USUAL, 512, 60, 400, id="long-usual", marks=pytest.mark.long),
    ],
)
def test_runs_equal_the_model(config, rows, runs, generations):
    kinds = fly(config, rows, runs, runs, generations)
    if runs >= 40:
        assert {kind[:2] for kind in kinds} == {(1, False), (2, False), (1, True), (2, True)}
        assert {kind[2:4] for kind in kinds} == {(0, 0), (0, 1), (1, 0), (1, 1)}
        assert {kind[4] for kind in kinds} == {False, True}


@pytest.mark.long
def test_ten_thousand_generations_of_the_usual_chip():
    with VerilatedPlanner(USUAL, 512) as chip:
        flight = Flight(USUAL, 512, 10, chip)
        flight.upload()
        flight.pose()
        options = RunOptions(seed=1, cycles=10**9, generations=10_000, slopes=(3, 0))
        flight.run(options)
        assert flight.outcome.generations == 10_000


@pytest.mark.parametrize("slopes", [(3,), (3, 0)], ids=["one-island", "two-islands"])
@pytest.mark.parametrize("step", [97, pytest.param(1, marks=pytest.mark.long)])
def test_a_stop_in_any_cycle_of_a_run(slopes, step):
    """Nothing is bred from the next cycle on, in whatever part of the run."""
    with VerilatedPlanner(SMALL, 64) as chip:
        flight = Flight(SMALL, 64, 7, chip)
        flight.upload()
        flight.pose()
        options = RunOptions(
            seed=5, cycles=10**9, generations=12, give_up_rank=3, slopes=slopes, seeds=10, lifts=1,
            share=8, memo=64,
        )  # fmt: skip
        flight.run(options)
        end = plan(SMALL, flight.ground, flight.record, options, marked=0).cycles
        told = []
        for stop in range(1, end, step):
            flight.outcome = out = plan(
                SMALL, flight.ground, flight.record, options, marked=0, stop=stop
            )
            assert chip.run(options, stop=stop) == (out.cycles, out.generations)
            flight.compare(stop)
            told.append(out.generations)
        assert told == sorted(told)
        assert (told[0], told[-1]) == (0, 12)
        assert step > 1 or set(told) == set(range(13))


def test_a_stop_without_a_run_means_nothing():
    with VerilatedPlanner(SMALL, 64) as chip:
        flight = Flight(SMALL, 64, 8, chip)
        flight.upload()
        flight.pose()
        chip.stop()
        flight.run(flight.options(20))
        before = chip.status()
        chip.stop()
        assert chip.status() == before
        flight.run(flight.options(20))


@pytest.mark.parametrize("runs", [12, pytest.param(300, marks=pytest.mark.long)])
def test_a_reset_in_the_middle_of_a_run_leaves_a_new_chip(runs):
    """It has neither problem, population nor paths; the map stays, and is scanned anew."""
    with VerilatedPlanner(SMALL, 64) as chip:
        flight = Flight(SMALL, 64, 9, chip)
        flight.upload()
        flight.pose()
        for number in range(runs):
            options = flight.options(40)
            flight.run(options)
            cold = dataclasses.replace(options, warm=False, slopes=(3,), seed=number)
            chip.reset_in_run(cold, int(flight.rng.integers(flight.outcome.cycles + 100)))
            flags, status = chip.status()
            assert flags == [0, 0, 0]
            assert status["running"] == 0
            assert status["generation"] == status["cycles"] == 0
            assert status["key"] >> VALUE_BITS == PathClass.VOID
            flight.marks, flight.outcome = BlockMarks(), None
            flight.pose()


def a_config(rng):
    """A small chip of random sizes."""
    population = int(rng.choice([8, 16]))
    survivors = int(rng.integers(1, population // 4 + 1))
    elites = int(rng.integers(1, population // 4 + 1))
    elites += (population - survivors - elites) % 2
    size = int(rng.choice([16, 32, 64, 128]))
    return SMALL.replace(
        population=population,
        survivors=survivors,
        elites=elites,
        children=population - survivors - elites,
        max_waypoints=int(rng.integers(3, 18)),
        map_size=size,
        altitude_bits=int(rng.integers(5, 13)),
        box_percent=int(rng.integers(5, 40)),
        lanes=int(rng.choice([1, 2, 4, 8, 16])),
        memory_latency=int(rng.integers(1, 3)),
    )


@pytest.mark.long
@pytest.mark.parametrize("first", range(0, 1000, 25))
def test_random_configurations(first, tmp_path):
    """Six runs each on 25 chips of random sizes; their programs are not kept."""
    builds = BuildCache(tmp_path)
    for seed in range(first, first + 25):
        rng = np.random.default_rng(seed)
        config, rows = a_config(rng), int(rng.choice([0, 2, 16, 64, 256]))
        fly(config, rows, seed, 6, 60, builds)
        for program in tmp_path.glob("verilator-*/"):
            shutil.rmtree(program)
