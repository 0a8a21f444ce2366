"""The exported planner in Verilator: complete runs and their reports, compared with the model."""

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.planner.core import PlannerCore, run_status_layout
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.hdl.verilog import convert
from pathgene.sim.cache import BuildCache
from pathgene.sim.exported import cached_verilog
from pathgene.sim.harness.program import VerilatedProgram
from pathgene.sim.model.planner.run import plan
from pathgene.sim.model.run_commands import BlockMarks
from tests.support.planner.cases import SMALL, USUAL, words
from tests.support.planner.flight import (
    Flight,
    guide_payload,
    problem_payload,
    run_payload,
    shape_payload,
    status_fields,
)


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

#: A chip of longer paths on a larger map.
MEDIUM = SMALL.replace(
    population=16, children=10, elites=2, survivors=4, max_waypoints=16, map_size=128,
    altitude_bits=10,
)  # fmt: skip


def planner_verilog(config, rows):
    """Return the Verilog of the planner."""
    return convert(PlannerCore(config, rows), "planner_core")


class VerilatedPlanner(VerilatedProgram):
    """The planner, simulated by Verilator in another process, and its map.

    With ``builds``, it compiles quickly and simulates slowly. ``text`` replaces its Verilog.
    """

    def __init__(self, config, rows, builds=None, text=None):
        def export():
            return planner_verilog(config, rows)

        if text is None:
            key = "planner_core", repr(config), str(rows)
            text = export() if builds else cached_verilog(export, *key)
        main = Path(__file__).with_name("planner_core.cpp")
        optimize = "-O0" if builds else "-O1"
        super().__init__(text, "planner_core", main, builds=builds, optimize=optimize)
        self.config = config

    def write(self, ground, x, y):
        """Write these corners of the ground."""
        bits = self.config.coordinate_bits
        words = x | y << bits | ground[y, x].astype(np.int64) << 2 * bits
        self.send(1, len(words), words)

    def pose(self, record):
        self.send(2, words(problem_payload(self.config, record)))

    def draw(self, shape):
        """Draw a shape; return the cycles."""
        self.send(3, words(shape_payload(self.config, shape)))
        return int(self.receive(1)[0])

    def lead(self, index, waypoint):
        """Write a waypoint of the guide."""
        bits = guide_payload(self.config, index, waypoint).as_bits()
        self.send(9, bits & 0xFFFFFFFF, bits >> 32)

    def run(self, options, *, gap=0, stop=0):
        """Run to the end; return the cycles, and the generations that were told."""
        self.send(4, gap, stop, words(run_payload(self.config, options)))
        return tuple(self.receive(2).tolist())

    def stop(self):
        """Send a stop while no run is in progress."""
        self.send(8)

    def reset_in_run(self, options, cycles):
        """Start a run, and reset the chip after ``cycles`` cycles."""
        self.send(7, cycles, words(run_payload(self.config, options)))

    def status(self):
        """Return the flags of its contents, and the fields of the status."""
        self.send(5)
        flags = self.receive(3).tolist()
        words = self.receive(-(-run_status_layout().size // 32)).tolist()
        return flags, status_fields(sum(word << 32 * i for i, word in enumerate(words)))

    def best(self, stall=0):
        self.send(6, stall)
        return bytes(self.receive(int(self.receive(1)[0])).tolist())


def fly(config, rows, seed, runs, generations, builds=None, text=None):
    """Execute runs on changing maps and problems; return the kinds of runs."""
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
            if flight.rng.random() < 0.5:
                flight.lead()
            flight.run(flight.options(generations))
        return flight.kinds


@pytest.mark.parametrize(
    ("config", "rows", "runs", "generations"),
    [
        # The usual chip has the same parts, and a stop in many cycles is one of a small chip.
        pytest.param(SMALL, 64, 60, 120, id="small", marks=pytest.mark.long),
        # Longer paths and a larger map are also in the usual chip.
        pytest.param(MEDIUM, 256, 60, 100, id="medium", marks=pytest.mark.long),
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
        pytest.param(
            SMALL.replace(point_cycles=2), 64, 60, 120, id="two-cycles", marks=pytest.mark.long
        ),
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
        # The limits of runs that wait are shorter than a route over 64 x 64 blocks.
        if config.map_size < 512:
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


@pytest.mark.parametrize(
    "slopes",
    [pytest.param((3,), marks=pytest.mark.long), (3, 0)],
    ids=["one-island", "two-islands"],
)
@pytest.mark.parametrize("step", [197, pytest.param(1, marks=pytest.mark.long)])
def test_a_stop_in_any_cycle_of_a_run(slopes, step):
    """Nothing is bred after the cycle of the stop, in any part of the run."""
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
        for stop in dict.fromkeys((*range(1, end, step), end - 1)):
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


@pytest.mark.parametrize("runs", [6, pytest.param(300, marks=pytest.mark.long)])
def test_a_reset_in_the_middle_of_a_run_leaves_a_new_chip(runs):
    """The chip has no problem, population or paths; the map stays, and is scanned again."""
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
        point_cycles=int(rng.integers(1, 3)),
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
