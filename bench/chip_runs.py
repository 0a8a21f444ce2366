"""Plans by runs of the planner core, on its compiled model, over the nine terrains."""

from __future__ import annotations

import dataclasses
import functools
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from bench.campaign import Alteration, measure
from bench.scenarios import SYNTHETIC, names, problem
from pathgene.hdl.boards import find_board
from pathgene.hdl.config import Config, GeneticCore
from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.runs import Outcome as RunOutcome
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.chip.problem_record import chip_ends, problem_record, whole_path
from pathgene.host.planners.chip.schedule import blocks_of
from pathgene.host.planners.choice import choose
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.rules import Rules
from pathgene.sim.model.planner.run import plan


#: The modelled chip: 8 lanes, 100 MHz.
CHIP = Config(core=GeneticCore.PLANNER)
#: The chip of the board that is routed for that clock, and the URL of its model.
BOARD_CHIP = find_board("ulx3s-85f", "planner").config
BOARD_URL = (
    f"model:?core=planner&altitude_bits={BOARD_CHIP.altitude_bits}"
    f"&max_waypoints={BOARD_CHIP.max_waypoints}"
)


@dataclass(frozen=True)
class Task:
    """Runs of a chip on a terrain; each run after the first continues from the previous one.

    ``clearance_m`` is None in paper mode.
    """

    terrain: str
    clearance_m: float | None
    runs: tuple[RunOptions, ...]
    config: Config = CHIP


@dataclass(frozen=True)
class Outcome:
    """Result of the runs of a task, judged by the host."""

    #: F of the best path that is feasible by the strict rule, or of the best path if there is none.
    fitness: float
    feasible: bool
    #: Sums over all runs.
    generations: int
    cycles: int
    #: Processor time of the model or of the plan.
    seconds: float
    #: Cycles of the chip's units, which overlap; empty without a chip that counts them.
    units: Mapping[str, int] = field(default_factory=dict)
    #: Share of the seconds in which only the host works; NaN for a run of the model.
    host_share: float = math.nan


def terrains() -> list[str]:
    """Return the names of the available terrains of ``BENCH=quality``."""
    return [*names(), *SYNTHETIC]


def run_all(tasks: Sequence[Task], alteration: Alteration | None = None) -> list[Outcome]:
    """Execute all tasks in one process per core, with an altered definition if one is given."""
    runs = [(task,) for task in tasks]

    def name(run: tuple[Task]) -> str:
        return f"runs over {run[0].terrain}"

    if alteration is None:
        return measure("chip", runs, _run, name=name, prepare=_compile)
    with TemporaryDirectory() as folder:
        return measure(
            "chip",
            runs,
            _run,
            name=name,
            prepare=alteration.apply,
            prepare_arguments=(Path(folder),),
            spawned=True,
        )


def share(outcomes: Iterable[Outcome]) -> str:
    """Return the number of outcomes with a feasible path."""
    found = [outcome.feasible for outcome in outcomes]
    return f"{sum(found)} of {len(found)}"


def through_terrains(by_terrain: Sequence[Sequence[Outcome]]) -> tuple[list[str], str]:
    """Return the mean F of each terrain's feasible paths, and the mean of the means."""
    means = [
        mean(fitness) if (fitness := [each.fitness for each in some if each.feasible]) else None
        for some in by_terrain
    ]
    known = [value for value in means if value is not None]
    cells = ["none" if value is None else f"{value:.4f}" for value in means]
    return cells, f"{mean(known):.4f}" if known else "none"


def _compile() -> None:
    _run(Task(SYNTHETIC[0], None, (RunOptions(generations=1),)))


@functools.cache
def _prepared(
    terrain: str, clearance_m: float | None, config: Config
) -> tuple[Evaluator, CornerMap]:
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    task = dataclasses.replace(problem(terrain), rules=rules)
    return Evaluator(task, threads=1), CornerMap(config, task)


def _run(task: Task) -> Outcome:
    config = task.config
    evaluator, grid = _prepared(task.terrain, task.clearance_m, config)
    blocks = blocks_of(task.runs[0].cycles)
    record = problem_record(config, evaluator.problem, grid, blocks)
    corners = grid.corners(chip_ends(evaluator.problem))
    outcomes: list[RunOutcome] = []
    began = time.process_time()
    for options in task.runs:
        population = outcomes[-1].population if options.warm else None
        # The model scans all blocks before the first run, like the chip with a new map.
        marked = 0 if outcomes else None
        outcomes.append(plan(config, corners, record, options, population, marked=marked))
    seconds = time.process_time() - began
    archive: list[tuple[float, NDArray[np.float64]]] = []
    for path in (path for found in outcomes for path in found.paths):
        metres = whole_path(evaluator.problem, grid.corners_to_metres(np.array(path)))
        lengths = np.array([len(metres)])
        archive.append((float(evaluator.fitness(metres[None], lengths, strict=True)[0]), metres))
    archive.sort(key=lambda kept: -kept[0])
    _, evaluation = choose(evaluator, archive)
    return Outcome(
        evaluation.fitness,
        evaluation.feasible,
        sum(found.generations for found in outcomes),
        sum(found.cycles for found in outcomes),
        seconds,
        {unit: sum(getattr(found, unit) for found in outcomes) for unit in UNITS},
    )
