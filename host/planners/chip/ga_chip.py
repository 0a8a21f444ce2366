"""The genetic algorithm as a run of the planner core; the host makes the final decision."""

from __future__ import annotations

import contextlib
import importlib
import itertools
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np

from pathgene.hdl.config import Config, GeneticCore
from pathgene.host.device.boards import entered, known_config, require_chip, url_of, with_core
from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.boxed import plan_in_box
from pathgene.host.planners.chip.astar_route import Routes
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.chip.problem_record import whole_path
from pathgene.host.planners.chip.replanner import ChipReplanner
from pathgene.host.planners.chip.runs import ChipRuns
from pathgene.host.planners.chip.schedule import UNGUIDED_RUNS, ChipSchedule
from pathgene.host.planners.registry import DEFAULT_BOARD
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.leg_box import leg_box


__all__ = ["MOST_CHIP_MS", "ChipGeneticPlanner"]

#: Longest time on the chip, milliseconds.
MOST_CHIP_MS = 20_000


class ChipGeneticPlanner:
    """Genetic algorithm that runs entirely on a chip: first population, scores, sorting, loop.

    The host sends the map and the problem, starts a run, and reads up to eight paths. It evaluates
    them in full and reports the best that is feasible by the strict rule. If none is, it starts
    another run with the next seed and other surfaces, up to eight runs in all. After the second,
    ``astar`` searches, unless it is proven that there is no path; if it finds one, up to three runs
    along it follow instead. A small terrain is divided into smaller cells, except in short runs and
    as paper. If the map holds a box of the terrain
    (:func:`~pathgene.host.problem.leg_box.leg_box`) and no path is feasible there, as many runs
    follow on a map of the whole terrain. On large terrain, the rasters of the search cover a box as
    well (:func:`~pathgene.host.planners.boxed.plan_in_box`), unless the board stays open. A long
    plan is split into parts, each of which continues from the previous one: see
    :class:`pathgene.host.planners.chip.schedule.ChipSchedule`. docs/chip_planner.md defines a run;
    the seed determines all its random numbers, so every board with the same sizes gives the same
    result.

    With ``polish``, each path of the last run, and of a run without a feasible path, also gets more
    waypoints on its straight pieces, up to 32 in all, and then the lowest altitudes that the ground
    and the limits allow (:func:`~pathgene.host.planners.chip.polish.polished`). This takes about
    10 ms per path and makes some infeasible paths feasible. ``astar`` searches, too, and the better
    path is reported: see :class:`pathgene.host.planners.chip.astar_route.Routes`.

    Parameters
    ----------
    board : str or Chip
        URL of the board, see :func:`pathgene.host.device.boards.open_board`, or an open board. A
        simulated board is built with the planner core unless the URL names a core. On a board that
        stays open, a changed problem is planned from the population of the previous run: see
        :class:`pathgene.host.planners.chip.replanner.ChipReplanner`.
    chip_ms : int, optional
        Maximum time of a plan by the chip's clock, if the first run finds a path: 1 to 20,000
        milliseconds. By default only the generations limit it.
    polish : str
        ``on``, ``chip``, which only polishes the chip's paths, without a search by ``astar``, or
        ``off``.
    open_board : callable, optional
        As for :class:`pathgene.host.planners.allaire.ga_fpga.FpgaGeneticPlanner`.

    Raises
    ------
    InputError
        If ``chip_ms`` is outside its range, or ``polish`` is not one of these words.
    """

    def __init__(
        self,
        *,
        board: str | Chip = DEFAULT_BOARD,
        chip_ms: int | None = None,
        polish: str = "on",
        open_board: Callable[[str], AbstractContextManager[Chip]] | None = None,
    ) -> None:
        if chip_ms is not None and not 1 <= chip_ms <= MOST_CHIP_MS:
            raise InputError(
                f"The time on the chip must be from 1 to {MOST_CHIP_MS} ms, not {chip_ms}."
            )
        if polish not in ("on", "chip", "off"):
            raise InputError(f"The polish must be on, chip or off, not {polish!r}.")
        self.board = board
        self.chip_ms = chip_ms
        self.polishes, self.adds_astar = polish != "off", polish == "on"
        self._open_board = open_board

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Generation 0 is the straight line, along the headings; a record follows after each run. The
        generations of the options apply to a plan whose first run finds a path. A run ends early at
        an interrupt or at the time limit, which also limits the time by the chip's clock. The
        target fitness is only checked between runs, because the chip does not know fitness. The
        history is the chip's; the search by ``astar`` has no entry there.

        ``hardware`` of the result has the cycles and generations of each run, the mapping from
        metres to corners, the bytes in both directions, and whose route the result has.
        ``seconds`` has ``link``, the time
        spent waiting for the board, and ``board``, the time of the runs by the chip's clock.

        Raises
        ------
        InputError
            If nothing answers at the URL, the board has no planner core, or the given population is
            not the chip's.
        JobError
            If the board cannot be started, or is lost before the first evaluation.
        """
        if isinstance(self.board, Chip):  # A replan may continue anywhere on the terrain.
            return self._plan(evaluator, options, progress, stop)
        plans = itertools.count()

        def search(
            inner: Evaluator,
            options: Options,
            progress: Progress | None = None,
            stop: Stop | None = None,
        ) -> Result:
            # After a box, which holds the leg, the whole map follows at once.
            return self._plan(inner, options, progress, stop, whole=next(plans) > 0)

        return plan_in_box(search, evaluator, options, progress, stop, most=1)

    def _plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None,
        stop: Stop | None,
        *,
        whole: bool = False,
    ) -> Result:
        # If the URL gives the configuration, refuse bad options before a simulated board is built.
        url = with_core(url_of(self.board), GeneticCore.PLANNER)
        known = known_config(url) if self._open_board is None else None
        grid = None if known is None else self._map_for(known, evaluator, options, whole)
        with entered(self.board, self._open_board, core=GeneticCore.PLANNER) as chip:
            if grid is None or chip.config != known:
                grid = self._map_for(chip.config, evaluator, options, whole)
            run = Run(evaluator, options, progress, stop)
            problem = evaluator.problem
            run.record(0, run.fitness([whole_path(problem, np.empty((0, 3)))]))
            schedule = self._schedule(chip.config, options)
            with run.phase("map"):
                task = ProblemOnChip(chip, problem, grid, schedule.blocks)
            runs, routes = ChipRuns(task, run, polishes=self.polishes), Routes(run)
            try:
                with run.search():
                    first, further = schedule.first(), schedule.further()
                    is_over = runs.search(first[:UNGUIDED_RUNS], further)
                    if self.adds_astar and (is_over or not _is_impossible(run)):
                        routes.search()
                    if not is_over and routes.path is not None:
                        # If no run along it finds a better one, the route itself is the result.
                        is_over = True
                        if waypoints := task.lead(routes.path):
                            runs.search(schedule.guided(waypoints), further)
                    if not is_over:
                        is_over = runs.search(first[UNGUIDED_RUNS:], further)
                    if not (is_over or grid.is_whole):
                        with run.phase("map"):
                            grid = CornerMap(chip.config, problem)
                            task = ProblemOnChip(chip, problem, grid, schedule.blocks)
                        runs.move_to(task)
                        runs.search(first, further)
                    if self.adds_astar:
                        routes.add()
                        routes.refine()
                run.hardware = runs.hardware()
                run.seconds["board"] = runs.cycles / chip.config.clock_hz
            except JobError as error:
                # The best path from before the loss of the board is reported.
                run.failure = str(error)
            result = run.result()
            if result.hardware is not None:
                result.hardware.update(routes.describe(result))
            # A board that was opened here is closed now, without a changed problem.
            if isinstance(self.board, Chip) and task.is_warm:
                with contextlib.suppress(JobError):
                    task.coarsen()
                # Loads SciPy, for which a first replan must not wait.
                importlib.import_module("pathgene.host.problem.no_fly_shape")
        if task.is_warm:
            result = replace(result, replanner=ChipReplanner(task))
        return result

    def _schedule(self, config: Config, options: Options) -> ChipSchedule:
        return ChipSchedule(
            config=config,
            seed=options.seed,
            generations=options.generations,
            chip_ms=_least_ms(self.chip_ms, options.time_limit_s),
        )

    def _map_for(
        self, config: Config, evaluator: Evaluator, options: Options, whole: bool
    ) -> CornerMap:
        """Return a map for a chip of ``config``, or refuse options that it does not support.

        Where the map has room, its cells are parts of the terrain's.
        """
        require_chip(config, GeneticCore.PLANNER, options.population)
        problem, size = evaluator.problem, config.map_size
        box = None if whole else leg_box(problem, size)
        parts = 1
        if box is None and not problem.as_paper:
            most = self._schedule(config, options).most_parts_of_cells
            parts = min(most, max((size - 1) // (max(problem.terrain.shape) - 1), 1))
        return CornerMap(config, problem, box, parts)


def _is_impossible(run: Run) -> bool:
    """Return whether it is proven that the problem has no path: no search would find one."""
    # Loads SciPy.
    from pathgene.host.diagnosis import diagnose

    with run.phase("diagnosis"):
        return diagnose(run.evaluator.problem).proven


def _least_ms(chip_ms: int | None, time_limit_s: float | None) -> float | None:
    """Return the shorter of two limits, milliseconds; None if neither is given."""
    limits = [chip_ms, None if time_limit_s is None else 1000 * time_limit_s]
    return min((limit for limit in limits if limit is not None), default=None)
