"""The genetic algorithm as a run of the planner on the chip; the host has the last word."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hdl.protocol.planner import PathClass
from hdl.protocol.runs import RunOptions
from host.device.boards import known_config, open_board, with_core
from host.device.chip import Chip, unpack_waypoints
from host.device.runs import RunStatus
from host.errors import InputError, JobError
from host.evaluation import Evaluator
from host.planners.base import Options, Progress, Result, Run, Stop
from host.planners.chip_problem import chip_ends, problem_record, whole_path
from host.planners.options import DEFAULT_BOARD
from host.problem.corner_map import EASES, CornerMap


if TYPE_CHECKING:
    from hdl.config import Config

__all__ = ["MOST_CHIP_MS", "MOST_RUNS", "ChipGeneticPlanner", "run_options"]

Path = NDArray[np.float64]

#: Runs of a plan at most: another seed where none of a run's paths is feasible.
MOST_RUNS = 4
#: Longest run, milliseconds.
MOST_CHIP_MS = 20_000
#: Time between two looks at a run, seconds.
_LOOK_S = 0.001


class ChipGeneticPlanner:
    """Genetic algorithm that a chip runs by itself: first population, scores, sorting, loop.

    The host sends map and problem, starts a run, and reads up to eight paths. It evaluates them in
    full and reports the best that is feasible by the strict rule. Where none is, it starts another
    run, with the next seed, up to four in all. docs/chip_planner.md defines a run; all random
    numbers of it follow from the seed, so every board of the same sizes gives the same result.

    With ``polish``, each path read is also given the lowest altitudes that ground and limits allow
    (:func:`host.planners.altitudes.lowest_altitudes`), some 10 ms a path, which makes some paths
    feasible that are not.

    Parameters
    ----------
    board : str
        URL of the board; see :func:`host.device.boards.open_board`. A simulated one is built with
        the streaming core unless the URL names a core.
    chip_ms : int, optional
        Most time of a run by the chip's clock, 1 to 20,000 milliseconds; by default only the
        generations limit it.
    polish : str
        ``on`` or ``off``.
    open_board : callable, optional
        As for :class:`host.planners.ga_fpga.FpgaGeneticPlanner`.

    Raises
    ------
    InputError
        If ``chip_ms`` is outside its range, or ``polish`` is neither.
    """

    def __init__(
        self,
        *,
        board: str = DEFAULT_BOARD,
        chip_ms: int | None = None,
        polish: str = "on",
        open_board: Callable[[str], AbstractContextManager[Chip]] | None = None,
    ) -> None:
        if chip_ms is not None and not 1 <= chip_ms <= MOST_CHIP_MS:
            raise InputError(
                f"The time on the chip must be from 1 to {MOST_CHIP_MS} ms, not {chip_ms}."
            )
        if polish not in ("on", "off"):
            raise InputError(f"The polish must be on or off, not {polish!r}.")
        self.board = board
        self.chip_ms = chip_ms
        self.polishes = polish == "on"
        self._open_board = open_board

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`host.planners.base.Planner`.

        Generation 0 is the straight line; a record follows after each run. The generations of the
        options are those of one run. A time limit ends the search after a run; an interrupt ends
        the run.

        ``hardware`` of the result has the cycles and generations of each run, the map from metres
        to corners, and the bytes of both directions. ``seconds`` has ``link``, the time spent
        waiting for the board, and ``board``, the time of the runs by its own clock.

        Raises
        ------
        InputError
            If nothing answers at the URL, the board has no streaming core, or a population is given
            that is not the chip's.
        JobError
            If the board cannot be started, or is lost before anything was evaluated.
        """
        board = with_core(self.board, "streaming")
        # If the URL says enough, refuse what is wrong before a simulated board is built.
        known = known_config(board) if self._open_board is None else None
        grid = None if known is None else _map_for(known, evaluator, options)
        with (self._open_board or open_board)(board) as chip:
            if grid is None or chip.config != known:
                grid = _map_for(chip.config, evaluator, options)
            run = Run(evaluator, options, progress, stop)
            problem = evaluator.problem
            run.record(0, run.fitness([np.array([problem.start, problem.goal])]))
            runs = _Runs(chip, grid, run, self.chip_ms, self.polishes)
            try:
                with run.search():
                    runs.search()
                run.hardware = runs.hardware()
                run.seconds["board"] = runs.cycles / chip.config.clock_hz
            except JobError as error:
                # The best path from before the loss of the board is reported.
                run.failure = str(error)
            return run.result()


def run_options(
    config: Config, *, seed: int, generations: int, chip_ms: int | None = None
) -> RunOptions:
    """Return the options of a run of so many generations, or milliseconds if they end it first."""
    most = (1 << 32) - 1
    return RunOptions(
        seed=seed,
        cycles=most if chip_ms is None else min(chip_ms * config.clock_hz // 1000, most),
        generations=min(generations, most),
        give_up_rank=min(RunOptions.give_up_rank, config.population - 1),
    )


def _map_for(config: Config, evaluator: Evaluator, options: Options) -> CornerMap:
    """Return the map of a chip of ``config``, or refuse what that chip cannot do."""
    if not config.streaming_core:
        raise InputError(
            "This board has no streaming genetic core, so it does not plan by itself; use another "
            "board, or the planner ga-fpga."
        )
    if options.population not in (None, config.population):
        raise InputError(
            f"The population of this board is {config.population}, not "
            f"{options.population}; leave the population out (--population) or "
            "use another board."
        )
    return CornerMap(config, evaluator.problem)


class _Runs:
    """The runs of one plan."""

    def __init__(
        self, chip: Chip, grid: CornerMap, run: Run, chip_ms: int | None, polishes: bool
    ) -> None:
        self._chip, self._grid, self._run = chip, grid, run
        self._chip_ms, self._polishes = chip_ms, polishes
        self._traffic_before = replace(chip.link.traffic)
        self._done: list[dict[str, Any]] = []
        self._eased = 0
        with run.phase("map"):
            self._record = problem_record(chip.config, run.evaluator.problem, grid)
            self._ends = chip_ends(run.evaluator.problem)
            corners = grid.corners(self._ends)
        with run.phase("link"):
            self._before = chip.counters()
            chip.update_map(corners)
            chip.runs.set_problem(self._record)

    @property
    def cycles(self) -> int:
        """Cycles of all runs."""
        return sum(done["cycles"] for done in self._done)

    def search(self) -> None:
        """Run until a path is feasible, a stop criterion is met, or all runs are done."""
        run = self._run
        generations = 0
        for number in range(MOST_RUNS):
            options = run_options(
                self._chip.config,
                seed=(run.options.seed + number) % (1 << 64),
                chip_ms=self._chip_ms,
                generations=run.options.generations,
            )
            with run.phase("link"):
                self._chip.runs.start(options)
                status = self._finished()
                best = self._chip.runs.best()
            generations += status.generations
            self._done.append(
                {
                    "seed": options.seed,
                    "generations": status.generations,
                    "cycles": status.cycles,
                    "ease": self._eased,
                    "classes": [each.name.lower() for each in best.classes],
                }
            )
            paths = [self._metres(path) for path in best.paths]
            fitness = run.fitness(paths, strict=True)
            if self._polishes:
                fitness = np.concatenate((fitness, self._polished(paths)))
            run.record(generations, fitness)
            if fitness.max() > 1 or run.stopped_by() not in (None, "generations"):
                return
            # The chip found no way from end to end, or one that only it believes.
            found = best.classes[0] is PathClass.FEASIBLE
            with run.phase("link"):
                self._ease(-1 if found else 1)

    def _ease(self, change: int) -> None:
        """Lower the corners of the map beside start and goal more, or less, if that is possible."""
        self._eased = min(max(self._eased + change, min(EASES)), max(EASES))
        corners = self._grid.corners(self._ends, self._eased)
        for end in self._ends:
            rows, columns = self._grid.around(end)
            self._chip.upload_map(corners[rows, columns], columns.start, rows.start)
        self._chip.runs.set_problem(self._record)

    def _finished(self) -> RunStatus:
        """Wait for the end of the run; return what it did."""
        stop, stopped = self._run.stop, False
        while (status := self._chip.runs.status()).running:
            if not stopped and stop is not None and stop.requested:
                self._chip.runs.stop()
                stopped = True
            time.sleep(_LOOK_S)
        return status

    def _metres(self, packed: list[int]) -> Path:
        """Return a path in metres, start and goal included."""
        corners = unpack_waypoints(self._chip.config, packed)
        metres = self._grid.corners_to_metres(corners)
        return whole_path(self._run.evaluator.problem, metres)

    def _polished(self, paths: list[Path]) -> NDArray[np.float64]:
        """Evaluate the paths with the lowest altitudes; return the fitness of each, (m,)."""
        # They load SciPy.
        from host.planners.altitudes import lowest_altitudes
        from host.planners.grid_search import Prices

        run = self._run
        with run.phase("polish"):
            prices = Prices(run.evaluator.problem)
            lowest = [
                lowest_altitudes(run.evaluator.problem, prices, path[:, :2]) for path in paths
            ]
        fitted = [path for path in lowest if path is not None]
        return run.fitness(fitted, strict=True) if fitted else np.zeros(0)

    def hardware(self) -> dict[str, Any]:
        """Return the block ``hardware`` of a summary."""
        chip, before = self._chip, self._traffic_before
        with self._run.phase("link"):
            after = chip.counters()
        traffic = chip.link.traffic
        return {
            "clock_hz": chip.config.clock_hz,
            "build_id": f"{chip.config.build_id:08x}",
            "map": self._grid.report(),
            "cycles": {"runs": self.cycles},
            "bytes": {
                "to_board": after["bytes_received"] - self._before["bytes_received"],
                "from_board": after["bytes_sent"] - self._before["bytes_sent"],
            },
            "frames": {
                "repeated": traffic.frames_repeated - before.frames_repeated,
                "damaged": traffic.frames_damaged - before.frames_damaged,
            },
            "generations": sum(done["generations"] for done in self._done),
            "runs": self._done,
        }
