"""``python -m pathgene.host.kernels``: compile the kernels of all planners before the first plan.

A set-up calls it while packages are downloaded; otherwise the first plan on a machine waits for
them. One process compiles the kernels of the host, about 50 processor seconds, and another the
kernels of the model, about 30. Kernels that are on disk already are only loaded.
"""

from __future__ import annotations

import itertools
import subprocess
import sys
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from pathgene.hdl.config import GeneticCore
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.auv import PLANNERS as AUV_PLANNERS
from pathgene.host.auv.field import PAPER_SAMPLES, AuvField, whole_angle
from pathgene.host.auv.plan import evolve, terms
from pathgene.host.compiling import compile_evaluation
from pathgene.host.device.boards import open_board, with_core
from pathgene.host.device.checker_boards import order_board
from pathgene.host.device.paths import pack_waypoints
from pathgene.host.diagnosis.ladder import diagnose
from pathgene.host.mission.foreign.check import check_path
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.mission.plan import plan
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.chip.problem_record import committed_points
from pathgene.host.planners.routes.field import READINGS
from pathgene.host.problem.compiled import corners
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["compile_chip", "compile_host"]
_Kind = TypeVar("_Kind", bound=Problem)

# Planners that have kernels in addition to the evaluation, with options for a short search.
_PLANNERS: dict[str, dict[str, Any]] = {
    "astar": {},
    "fpa-2opt": {"generations": 1},
    "ga-dp": {"generations": 1},
}


def compile_host() -> None:
    """Compile the kernels of the evaluation and of all planners on the host, `auv` included."""
    for as_paper in (False, True):
        compile_evaluation(as_paper)
    for planner, options in _PLANNERS.items():
        found = plan(_problem(Problem), planner=planner, seed=0, **options)
        # The report on a path is computed when it is read.
        str(found.evaluation)
    # A start with a heading, as in a replan.
    committed_points(replace(_problem(Problem), start_heading_deg=45.0))
    # Why there is no path.
    diagnose(_problem(Problem))
    # Faults of a mission, whose zones are judged one by one.
    problem = _problem(FlightProblem)
    check_path(problem, np.array([problem.start, problem.goal], dtype=np.float64))
    for samples, reading, kind in itertools.product((None, PAPER_SAMPLES), READINGS, AUV_PLANNERS):
        field = AuvField(1, reading=reading, samples=samples)
        (generation,) = itertools.islice(evolve(field, kind), 1, 2)
        terms(field, generation.best)
        whole_angle(generation.best)


def compile_chip() -> None:
    """Compile the kernels of the model: of the planner core, and of the collision checker.

    The kernels of the chip's map are among them, without those that the evaluation needs, too.
    """
    problem = _problem(Problem, as_paper=True)
    with open_board(with_core("model:", GeneticCore.PLANNER)) as chip:
        task = ProblemOnChip(chip, problem, CornerMap(chip.config, problem))
        task.run(RunOptions(generations=10), ends=lambda _: False)
    # A replan draws new zones on parts of the map.
    heights, flags, first = np.zeros((2, 2)), np.zeros((2, 2), dtype=bool), np.arange(3)
    corners.cell_heights(heights, flags, (first, first), (0.0, 1.0, 9), heights.astype(np.uint16))
    corners.mark_beside(flags, (first, first), flags)
    corners.extent(flags)
    corners.least_values(flags, (0, 0), np.ones((1, 2), dtype=np.int64), (0, 0), first)
    corners.draw(np.ones((1, 3), dtype=np.int64), (0, 0), flags)
    url, _ = order_board("model:", None)
    with open_board(url) as chip:
        chip.upload_map(np.zeros((16, 16), dtype=np.uint16))
        chip.check_path(pack_waypoints(chip.config, np.array([(1, 1, 9), (14, 12, 9)])))


def _problem(kind: type[_Kind], **rules: Any) -> _Kind:
    terrain = Terrain("flat", np.full((60, 60), 100.0), 100.0, 100.0)
    zone = Zone.circle(3000, 3000, 500)
    return kind(terrain, (500, 500, 200), (5500, 5500, 200), zones=(zone,), **rules)


def _main(arguments: list[str]) -> int:
    if not arguments:
        command = [sys.executable, "-m", "pathgene.host.kernels"]
        with subprocess.Popen([*command, "chip"]) as chip:
            compile_host()
        return chip.returncode
    compile_chip()
    return 0


if __name__ == "__main__":
    sys.exit(_main(sys.argv[1:]))
