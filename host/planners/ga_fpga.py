"""The genetic algorithm of *allaire-2008*, section 4: the chip breeds, the host evaluates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hdl.protocol import LinkMode
from host.chip import Chip, pack_waypoints, unpack_waypoints
from host.errors import InputError, JobError
from host.evaluation import Evaluator
from host.planners.base import Options, Progress, Result, Run, Stop
from host.terrain import ChipMap


if TYPE_CHECKING:
    from hdl.config import Config

__all__ = ["FpgaGeneticPlanner", "draw_paths", "ranking"]

Path = NDArray[np.float64]

# Counters of the chip under the names of a summary.
_CYCLES = {
    "selection_crossover": "crossover",
    "mutation": "mutation",
    "population_update": "update",
    "receive": "receive",
    "transmit": "transmit",
    "feasibility": "feasibility",
}


class FpgaGeneticPlanner:
    """Genetic algorithm whose population lives on a chip.

    The host draws the first population, then again and again evaluates what is new, sorts, sends
    the order and takes the new population, as section 4.2 says. All that is random about breeding
    is drawn on the chip from the seed, so that every board gives the same result.

    Source: *allaire-2008*, section 4. Settled here where it is silent: the two waypoints of a first
    path are drawn uniformly over the cells that are free, at altitudes uniform between the ground
    and the top of the map; equal fitnesses are sorted by slot. Added: the first population is the
    best of ``initial_draws`` times as many paths.

    Parameters
    ----------
    board : str
        URL of the board; see :func:`host.board.open_board`.
    link_mode : str
        ``rank``, ``population`` or ``recipe``: what goes over the link. The result is the same.
    initial_draws : int
        Paths drawn and evaluated for each of the first population, 1 or more; the paper's is 1.
    open_board : callable, optional
        Returns the :class:`~host.chip.Chip` at a URL.

    Raises
    ------
    InputError
        If there is no such link mode, or ``initial_draws`` is below 1.
    """

    def __init__(
        self, *, board: str = "model:", link_mode: str = "rank", initial_draws: int = 4,
        open_board: Callable[[str], Chip] | None = None,
    ) -> None:
        names = [mode.name.lower() for mode in LinkMode]
        if link_mode not in names:
            raise InputError(f"The link mode must be one of {', '.join(names)}, not "
                             f"{link_mode!r}.")
        if initial_draws < 1:
            raise InputError(f"The initial draws must be 1 or more, not {initial_draws}.")
        self.board = board
        self.initial_draws = initial_draws
        self.link_mode = LinkMode[link_mode.upper()]
        self._open_board = open_board

    def plan(
        self, evaluator: Evaluator, options: Options,
        progress: Progress | None = None, stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`host.planners.base.Planner`.

        ``hardware`` of the result has what the chip counted during the run, the map from metres to
        its cells, and the bytes of both directions. ``seconds`` has ``link``, the waiting for the
        board, and ``board``, the time of its units by its own clock.

        Raises
        ------
        InputError
            If nothing answers at the URL, the population is not the chip's, or the map has no free
            cell.
        JobError
            If the board cannot be started, or is lost before anything was evaluated.
        """
        with self._open() as chip:
            config = chip.config
            if options.population not in (None, config.population):
                raise InputError(f"The population of this board is {config.population}, not "
                                 f"{options.population}; leave out --population or build another "
                                 "board.")
            run = Run(evaluator, options, progress, stop)
            with run.phase("map"):
                grid = ChipMap(config, evaluator.problem)
                rng = np.random.default_rng(options.seed)
                drawn = draw_paths(grid, config, rng, self.initial_draws * config.population)
            loop = _Loop(chip, grid, run, self.link_mode)
            loop.start(drawn)
            try:
                loop.breed()
            except JobError as error:
                # What was found before the board was lost is worth a report.
                run.failure = str(error)
            else:
                run.hardware = loop.hardware()
                run.seconds["board"] = loop.units_clocks() / config.clock_hz
            return run.result()

    def _open(self) -> Chip:
        if self._open_board is None:
            from host.board import open_board

            return open_board(self.board)
        return self._open_board(self.board)


class _Loop:
    """The generations of one run."""

    def __init__(self, chip: Chip, grid: ChipMap, run: Run, mode: LinkMode) -> None:
        problem = run.evaluator.problem
        self._chip, self._grid, self._run, self._mode = chip, grid, run, mode
        self._start, self._goal = np.array([problem.start]), np.array([problem.goal])
        self._before: dict[str, int] = {}
        self._after: dict[str, int] = {}

    def start(self, drawn: list[list[int]]) -> None:
        """Evaluate the paths ``drawn`` and load the best of them, best first."""
        run, chip = self._run, self._chip
        fitness = self._evaluated(drawn)
        with run.phase("sort"):
            best = ranking(fitness)[: chip.config.population]
        self._fitness = fitness[best]
        with run.phase("link"):
            self._before = chip.counters()
            chip.start(run.options.seed, self._grid.limits)
            chip.load([drawn[number] for number in best])
        run.record(0, self._fitness)

    def breed(self) -> None:
        """Run generations until a stop criterion is met."""
        run = self._run
        generation = 0
        while run.stopped_by() is None:
            with run.phase("sort"):
                order = ranking(self._fitness)
            with run.phase("link"):
                step = self._chip.step(order, self._mode)
            # Elites and survivors keep their fitness where the chip tells which they are.
            kept = [] if step.origin is None else list(step.origin)
            fresh = self._evaluated(step.paths[len(kept) :])
            self._fitness = np.concatenate((self._fitness[kept], fresh))
            generation += 1
            run.record(generation, self._fitness)
        with run.phase("link"):
            self._after = self._chip.counters()

    def _evaluated(self, packed: Sequence[Sequence[int]]) -> NDArray[np.float64]:
        config, grid = self._chip.config, self._grid
        with self._run.phase("evaluation"):
            lengths = [len(path) for path in packed]
            cells = unpack_waypoints(config, [waypoint for path in packed for waypoint in path])
            points = np.split(grid.to_metres(cells), np.cumsum(lengths)[:-1])
            paths = [np.concatenate((self._start, inner, self._goal)) for inner in points]
        return self._run.fitness(paths)

    def counted(self, name: str) -> int:
        """What the chip's counter ``name`` went up by; 0 for a unit the chip does not have."""
        return self._after.get(name, 0) - self._before.get(name, 0)

    def units_clocks(self) -> int:
        """Clocks in which the chip's units bred."""
        return sum(map(self.counted, ("crossover", "mutation", "update")))

    def hardware(self) -> dict[str, Any]:
        """The block ``hardware`` of a summary."""
        chip = self._chip
        return {
            "clock_hz": chip.config.clock_hz,
            "build_id": f"{chip.config.build_id:08x}",
            "link_mode": self._mode.name.lower(),
            "map": self._grid.report(),
            "cycles": {name: self.counted(counter) for name, counter in _CYCLES.items()},
            "bytes": {"to_board": self.counted("bytes_received"),
                      "from_board": self.counted("bytes_sent")},
            "frames": {"repeated": chip.link.traffic.frames_repeated,
                       "damaged": chip.link.traffic.frames_damaged},
            "generations": self.counted("generations"),
            "longest_generation_cycles_since_reset": self._after["longest"],
            "refused_mutations": self.counted("refused_mutations"),
        }


def ranking(fitness: NDArray[np.float64]) -> list[int]:
    """QuickSort: slots from the best ``fitness`` (m,) to the worst; of equals, the lower first."""
    # No two keys are equal, so that every machine sorts them alike.
    keys = np.empty(len(fitness), dtype=[("worth", np.float64), ("slot", np.int64)])
    keys["worth"], keys["slot"] = -fitness, np.arange(len(fitness))
    order: list[int] = np.argsort(keys, kind="quicksort", order=("worth", "slot")).tolist()
    return order


def draw_paths(
    grid: ChipMap, config: Config, rng: np.random.Generator, paths: int
) -> list[list[int]]:
    """Draw ``paths`` of two packed waypoints each, none in the ground (section 3.1).

    Raises
    ------
    InputError
        If no cell of the map is free.
    """
    top = grid.limits[2]
    rows, columns = np.nonzero(grid.heights < top)
    if not len(rows):
        raise InputError("Nothing of the map is free to fly over; lessen the no-fly zones or fill "
                         "the voids with --fill-voids.")
    count = paths * config.MIN_WAYPOINTS
    at = rng.integers(len(rows), size=count)
    ground = grid.heights[rows[at], columns[at]].astype(np.int64)
    altitude = rng.integers(ground + 1, top, endpoint=True)
    packed = pack_waypoints(config, np.stack((columns[at], rows[at], altitude), axis=1))
    size = config.MIN_WAYPOINTS
    return [packed[first : first + size] for first in range(0, count, size)]
