"""The genetic algorithm of *allaire-2008*, section 4: the chip breeds, the host evaluates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild, GeneticCore
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device.boards import entered, known_config, require_chip, url_of
from pathgene.host.device.chip import Chip
from pathgene.host.device.paths import pack_waypoints, unpack_waypoints
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import NO_FLYABLE_CELL
from pathgene.host.planners.allaire.counting import BoardCollisionCounter
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.grid.initial import astar_paths, check_init
from pathgene.host.planners.registry import DEFAULT_BOARD
from pathgene.host.problem.chip_map import ChipMap


if TYPE_CHECKING:
    from pathgene.hdl.config import Config

__all__ = ["FpgaGeneticPlanner", "draw_paths", "ranking"]

Path = NDArray[np.float64]

# All first draws are evaluated at once: this many fill a few hundred megabytes.
_MOST_DRAWS = 1000

# Counters of the chip by their names in a summary.
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

    The host draws the first population. In each generation it evaluates the new paths, sorts,
    sends the ranking and receives the new population (section 4.2). The chip draws all random
    numbers of breeding from the seed, so every board gives the same result.

    Source: *allaire-2008*, section 4. The paper leaves some points open; here, the two waypoints of
    a first path are drawn uniformly over the free cells, at altitudes uniform between the ground
    and the top of the map, and equal fitnesses are sorted by slot. An addition: the first
    population is the best of ``initial_draws`` times as many paths.

    Parameters
    ----------
    board : str or Chip
        URL of the board, see :func:`pathgene.host.device.boards.open_board`, or an open board.
    link_mode : str
        ``rank``, ``population`` or ``recipe``: the data sent over the link. The result is the same.
    initial_draws : int
        Paths drawn and evaluated for each path of the first population, 1 to 1000; 1 in the paper.
    feasibility : str
        ``host``: the host samples d_ut and d_nf along the smoothed path. ``board``: the chip's
        collision checker counts them along the straight path (see
        :class:`~pathgene.host.planners.allaire.counting.BoardCollisionCounter`), and its mutations
        reject points in the ground.
    init : str
        ``random``, or ``astar``: the paths come from
        :func:`pathgene.host.planners.grid.initial.astar_paths`, on the cells and altitude steps of
        the chip.
    open_board : callable, optional
        Returns a context manager that yields the :class:`~pathgene.host.device.chip.Chip` at a URL;
        each run exits it at its end. If it keeps the chip open, the next run finds its map there.

    Raises
    ------
    InputError
        If there is no such link mode or feasibility mode, or ``initial_draws`` is outside its
        range.
    """

    def __init__(
        self,
        *,
        board: str | Chip = DEFAULT_BOARD,
        link_mode: str = "rank",
        initial_draws: int = 4,
        feasibility: str = "host",
        init: str = "random",
        open_board: Callable[[str], AbstractContextManager[Chip]] | None = None,
    ) -> None:
        names = [mode.name.lower() for mode in LinkMode]
        if link_mode not in names:
            raise InputError(f"The link mode must be one of {', '.join(names)}, not {link_mode!r}.")
        if not 1 <= initial_draws <= _MOST_DRAWS:
            raise InputError(
                f"The initial draws must be from 1 to {_MOST_DRAWS}, not {initial_draws}."
            )
        if feasibility not in ("host", "board"):
            raise InputError(f"The feasibility must be host or board, not {feasibility!r}.")
        self.board = board
        self.on_board = feasibility == "board"
        self.initial_draws = initial_draws
        self.from_astar = check_init(init)
        self.link_mode = LinkMode[link_mode.upper()]
        self._open_board = open_board

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        ``hardware`` of the result has the chip's counters for the run, the mapping from metres to
        its cells, and the bytes in both directions. ``seconds`` has ``link``, the time spent
        waiting for the board, and ``board``, the time of its units by the chip's clock.

        Raises
        ------
        InputError
            If nothing answers at the URL, the population is not the chip's, or the map has no free
            cell.
        JobError
            If the board cannot be started, or is lost before the first evaluation.
        """
        # If the URL gives the configuration, refuse bad options before a simulated board is built.
        known = known_config(url_of(self.board)) if self._open_board is None else None
        grid = None if known is None else _map_for(known, evaluator, options, self.on_board)
        with self._open() as chip:
            config = chip.config
            if grid is None or config != known:
                grid = _map_for(config, evaluator, options, self.on_board)
            run = Run(evaluator, options, progress, stop)
            drawn = self._first_paths(run, grid, config)
            loop = _Loop(chip, grid, run, self.link_mode, self.on_board)
            loop.start(drawn)
            try:
                with run.search():
                    loop.breed()
                    run.hardware = loop.hardware()
                    run.seconds["board"] = loop.units_cycles() / config.clock_hz
            except JobError as error:
                # The best path from before the loss of the board is reported.
                run.failure = str(error)
            return run.result()

    def _first_paths(self, run: Run, grid: ChipMap, config: Config) -> list[list[int]]:
        """Return packed paths; the best of them become the first population."""
        rng = np.random.default_rng(run.options.seed)
        count = self.initial_draws * config.population
        if self.from_astar:
            found = astar_paths(
                run, rng, count, config.max_waypoints, fewest=config.MIN_WAYPOINTS, lattice=grid
            )
            if found is not None:
                with run.phase("map"):
                    return [pack_waypoints(config, grid.to_cells(path[1:-1])) for path in found]
        with run.phase("map"):
            return draw_paths(grid, config, rng, count)

    def _open(self) -> AbstractContextManager[Chip]:
        return entered(self.board, self._open_board)


def _map_for(config: Config, evaluator: Evaluator, options: Options, on_board: bool) -> ChipMap:
    """Return the map of a chip of ``config``, or refuse options that the chip does not support."""
    require_chip(config, GeneticCore.PAPER, options.population)
    if on_board and config.checker is CheckerBuild.NONE:
        raise InputError(
            "This board has no collision checker; count on the host (--feasibility host), or "
            "use one that was built with a checker."
        )
    return ChipMap(config, evaluator.problem)


class _Loop:
    """The generations of one run."""

    def __init__(self, chip: Chip, grid: ChipMap, run: Run, mode: LinkMode, on_board: bool) -> None:
        problem = run.evaluator.problem
        self._chip, self._grid, self._run, self._mode = chip, grid, run, mode
        self._start, self._goal = np.array([problem.start]), np.array([problem.goal])
        self._after: dict[str, int] = {}
        self._traffic_before = replace(chip.link.traffic)
        with run.phase("link"):
            self._before = chip.counters()
            chip.start(run.options.seed, grid.limits, avoid_ground=on_board)
        self._counts = BoardCollisionCounter(chip, grid, run) if on_board else None

    def start(self, drawn: list[list[int]]) -> None:
        """Evaluate the paths ``drawn`` and load the best of them, best first."""
        run, chip = self._run, self._chip
        size = chip.config.population
        if self._counts is None:
            fitness = self._evaluated(drawn)
        else:
            parts = []
            for first in range(0, len(drawn), size):
                part = drawn[first : first + size]
                with run.phase("link"):
                    chip.load(part)
                parts.append(self._evaluated(part))
            fitness = np.concatenate(parts)
        with run.phase("sort"):
            best = ranking(fitness)[:size]
        self._fitness = fitness[best]
        self._settled = np.zeros(size, dtype=np.bool_)
        loaded = [drawn[number] for number in best]
        with run.phase("link"):
            chip.load(loaded)
        self._record(0, loaded)

    def breed(self) -> None:
        """Run generations until a stop criterion is met."""
        run = self._run
        generation = 0
        while run.stopped_by() is None:
            with run.phase("sort"):
                order = ranking(self._fitness)
            with run.phase("link"):
                step = self._chip.step(order, self._mode)
            # Elites and survivors keep their fitness if the chip reports them.
            kept = [] if step.origin is None else list(step.origin)
            fresh = self._evaluated(step.paths[len(kept) :], slot=len(kept))
            self._fitness = np.concatenate((self._fitness[kept], fresh))
            self._settled = np.concatenate((self._settled[kept], np.zeros(len(fresh), np.bool_)))
            generation += 1
            self._record(generation, step.paths)
        with run.phase("link"):
            self._after = self._chip.counters()

    def _record(self, generation: int, packed: Sequence[Sequence[int]]) -> None:
        """Record a generation whose paths are in the chip's slots, given ``packed``."""
        if self._counts is not None:
            self._counts.settle(
                self._fitness, self._settled, lambda slot: self._metres([packed[slot]])[0]
            )
        self._run.record(generation, self._fitness)

    def _evaluated(self, packed: Sequence[Sequence[int]], slot: int = 0) -> NDArray[np.float64]:
        """Return the fitness of paths; with chip counts, they lie in slots from ``slot`` on."""
        with self._run.phase("evaluation"):
            paths = self._metres(packed)
        if self._counts is None:
            return self._run.fitness(paths)
        return self._counts.fitness(paths, slot)

    def _metres(self, packed: Sequence[Sequence[int]]) -> list[Path]:
        """Return paths in metres, start and goal included."""
        config, grid = self._chip.config, self._grid
        lengths = [len(path) for path in packed]
        cells = unpack_waypoints(config, [waypoint for path in packed for waypoint in path])
        points = np.split(grid.to_metres(cells), np.cumsum(lengths)[:-1])
        return [np.concatenate((self._start, inner, self._goal)) for inner in points]

    def counted(self, name: str) -> int:
        """Return the increase of the chip's counter ``name``; 0 for a unit the chip lacks."""
        return self._after.get(name, 0) - self._before.get(name, 0)

    def units_cycles(self) -> int:
        """Return the cycles that the chip's units spent breeding."""
        return sum(map(self.counted, ("crossover", "mutation", "update")))

    def hardware(self) -> dict[str, Any]:
        """Return the block ``hardware`` of a summary."""
        chip, before = self._chip, self._traffic_before
        traffic = chip.link.traffic
        hardware = {
            "clock_hz": chip.config.clock_hz,
            "build_id": f"{chip.config.build_id:08x}",
            "link_mode": self._mode.name.lower(),
            "map": self._grid.report(),
            "cycles": {name: self.counted(counter) for name, counter in _CYCLES.items()},
            "bytes": {
                "to_board": self.counted("bytes_received"),
                "from_board": self.counted("bytes_sent"),
            },
            "frames": {
                "repeated": traffic.frames_repeated - before.frames_repeated,
                "damaged": traffic.frames_damaged - before.frames_damaged,
            },
            "generations": self.counted("generations"),
            "longest_generation_cycles": self._after["longest"],
            "refused_mutations": self.counted("refused_mutations"),
        }
        if self._counts is not None:
            of_chip = ("paths", "cells", "reads", "redrawn", "left_out")
            hardware["feasibility"] = {
                name: self.counted(name) for name in of_chip
            } | self._counts.report()
        return hardware


def ranking(fitness: NDArray[np.float64]) -> list[int]:
    """Return the slots from the best ``fitness`` (m,) to the worst; ties go to the lower slot."""
    # No two keys are equal, so every machine sorts them in the same order.
    keys = np.empty(len(fitness), dtype=[("worth", np.float64), ("slot", np.int64)])
    keys["worth"], keys["slot"] = -fitness, np.arange(len(fitness))
    order: list[int] = np.argsort(keys, kind="quicksort", order=("worth", "slot")).tolist()
    return order


def draw_paths(
    grid: ChipMap, config: Config, rng: np.random.Generator, paths: int
) -> list[list[int]]:
    """Draw ``paths`` paths of two packed waypoints each, none in the ground (section 3.1).

    Raises
    ------
    InputError
        If no cell of the map is free.
    """
    top = grid.limits[2]
    rows, columns = np.nonzero(grid.heights < top)
    if not len(rows):
        raise InputError(NO_FLYABLE_CELL)
    count = paths * config.MIN_WAYPOINTS
    at = rng.integers(len(rows), size=count)
    ground = grid.heights[rows[at], columns[at]].astype(np.int64)
    altitude = rng.integers(ground + 1, top, endpoint=True)
    packed = pack_waypoints(config, np.stack((columns[at], rows[at], altitude), axis=1))
    size = config.MIN_WAYPOINTS
    return [packed[first : first + size] for first in range(0, count, size)]
