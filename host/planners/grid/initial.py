"""First populations made from the paths of a grid search."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.diagnosis import diagnose
from pathgene.host.errors import InputError
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Run
from pathgene.host.planners.grid.altitudes import lowest_altitudes
from pathgene.host.planners.grid.astar import searches
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.planners.grid.polylines import lengthened
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.problem import Problem


__all__ = ["Variation", "astar_paths", "check_init", "on_lattice"]

Path = NDArray[np.float64]

# Shares of a first population: random paths, and a maximum for unchanged paths.
_RANDOM_SHARE, _FOUND_SHARE = 1 / 8, 1 / 4
# Number of copies with optimized altitudes, which take a few hundredths of a second each.
_MOST_FITTED = 48
# Minimum and maximum size of a variation, as shares of the distance from start to goal.
_LEAST_MOVE, _GREATEST_MOVE = 1e-3, 3e-2
# Probability that a copy loses a waypoint, and that it gains one.
_CHANGE_RATE = 0.2
# Minimum size of a nudge, as a share of that distance, and the probability that it moves two
# waypoints.
_LEAST_NUDGE, _TWO_RATE = 1e-4, 0.4


def check_init(init: str) -> bool:
    """Return whether ``init`` asks for a grid search before the first population.

    Raises
    ------
    InputError
        If it is neither ``random`` nor ``astar``.
    """
    if init not in ("random", "astar"):
        raise InputError(f"The start must be random or astar, not {init!r}.")
    return init == "astar"


def astar_paths(
    run: Run,
    rng: np.random.Generator,
    count: int,
    most: int,
    *,
    fewest: int = 1,
    lattice: ChipMap | None = None,
) -> list[Path] | None:
    """Return paths for a first population, from the grid search of ``astar``.

    The best paths found come first, then varied copies, more of the better paths: one waypoint,
    several or all are moved by small or large distances, and some copies have one waypoint more or
    less. The first 48 copies get the lowest altitudes for their places, so most of them are
    feasible; the remaining ones are copies of the paths before them and are also moved up or down.
    An eighth of the population is random. Waypoints lie in the airspace.

    Parameters
    ----------
    run : Run
        Evaluates the paths found, which take part in the final choice; its evaluator holds the
        problem.
    rng : numpy.random.Generator
        Draws the copies and the random paths.
    most, fewest : int
        Maximum and minimum number of waypoints between start and goal; equal for a fixed number. A
        path found with fewer waypoints gets more on its track.
    lattice : ChipMap, optional
        Map on whose cells and altitude steps waypoints must lie.

    Returns
    -------
    list of ndarray or None
        ``count`` paths, (n, 3) float64 metres with both ends; None if there is no route through the
        grid, with a warning unless it is proven that no path exists, which the reason of the plan
        then says.
    """
    ranked = sorted(
        (pair for paths in searches(run, most, lattice) for pair in paths),
        key=lambda pair: -pair[0],
    )
    if not ranked:
        if not diagnose(run.evaluator.problem).proven:
            warnings.warn(
                "The grid search finds no way from start to goal, so the first population is "
                "random.",
                stacklevel=2,
            )
        return None
    problem = run.evaluator.problem
    with run.phase("variation"):
        vary = Variation(problem, rng, most, fewest, lattice)
        best = ranked[: max(1, int(_FOUND_SHARE * count))]
        longer = (lengthened(path, fewest, problem.limits.turn_radius_m) for _, path in best)
        paths = [vary.placed(path[1:-1]) for path in longer]
        randoms = [vary.random() for _ in range(int(_RANDOM_SHARE * count))]
        varied = count - len(paths) - len(randoms)
        fitted = min(varied, _MOST_FITTED)
        paths += [vary.fitted(vary.copy(paths)) for _ in range(fitted)]
        paths += [vary.copy(paths) for _ in range(varied - fitted)]
    return paths + randoms


class Variation:
    """Draws varied copies of paths, and random ones.

    Parameters
    ----------
    rng, most, fewest, lattice
        As for :func:`astar_paths`.
    """

    def __init__(
        self,
        problem: Problem,
        rng: np.random.Generator,
        most: int,
        fewest: int,
        lattice: ChipMap | None = None,
    ) -> None:
        self._space = Airspace(problem)
        self._rng, self._most, self._fewest, self._lattice = rng, most, fewest, lattice
        self._ends = np.array([problem.start]), np.array([problem.goal])
        self._way_m = math.dist(problem.start, problem.goal)
        self._climb = math.tan(math.radians(problem.aircraft.max_climb_deg))
        self._problem, self._prices = problem, Prices(problem)

    def random(self) -> Path:
        """Return a random path of the minimum number of waypoints, but at least two if allowed."""
        count = max(self._fewest, min(2, self._most))
        return self.placed(self._space.draw(self._rng, count))

    def copy(self, paths: Sequence[Path]) -> Path:
        """Return a copy of one of ``paths``: the first with probability 1/2, and so on."""
        rng = self._rng
        inner, _ = self._resized(paths[min(int(rng.geometric(0.5)), len(paths)) - 1])
        moved = rng.random(len(inner)) < rng.choice((0.0, 0.5, 1.0))
        if len(inner):
            moved[rng.integers(len(inner))] = True
        move = (
            self._size_m(_LEAST_MOVE) * rng.standard_normal((len(inner), 3)) * (1, 1, self._climb)
        )
        return self.placed(inner + move * moved[:, None])

    def nudged(self, path: Path) -> Path:
        """Return ``path`` with one or two waypoints moved slightly, and the lowest altitudes.

        Sometimes a waypoint is removed, or the moved waypoint is new.
        """
        rng = self._rng
        inner, new = self._resized(path)
        if len(inner):
            first = int(rng.integers(len(inner))) if new is None else new
            for at in (first, first + 1)[: 1 + (rng.random() < _TWO_RATE)]:
                if at < len(inner):
                    inner[at, :2] += self._size_m(_LEAST_NUDGE) * rng.standard_normal(2)
        return self.fitted(self.placed(inner))

    def _resized(self, path: Path) -> tuple[Path, int | None]:
        """Copy the inner waypoints, sometimes one fewer or more; return the index of a new one."""
        rng, inner = self._rng, path[1:-1].copy()
        change = rng.random()
        if change < _CHANGE_RATE and len(inner) > self._fewest:
            return np.delete(inner, rng.integers(len(inner)), axis=0), None
        if change > 1 - _CHANGE_RATE and len(inner) < self._most:
            after = int(rng.integers(len(path) - 1))
            middle = path[after : after + 2].mean(axis=0)
            return np.insert(inner, after, middle, axis=0), after
        return inner, None

    def _size_m(self, least: float) -> float:
        """Draw the size of a move; all orders of magnitude are equally likely."""
        size: float = self._way_m * least * (_GREATEST_MOVE / least) ** self._rng.random()
        return size

    def fitted(self, path: Path) -> Path:
        """Return ``path`` with the lowest altitudes, or unchanged if its turns do not fit."""
        steps = (
            {}
            if self._lattice is None
            else {"base_m": self._lattice.base_m, "step_m": self._lattice.step_m}
        )
        fitted = lowest_altitudes(self._problem, self._prices, path[:, :2], **steps)
        return path if fitted is None else self.placed(fitted[1:-1])

    def placed(self, inner: Path) -> Path:
        """Return ``inner``, (n, 3) metres, moved into airspace and lattice, with both ends."""
        inner = np.clip(inner, self._space.low, self._space.high)
        if self._lattice is not None:
            inner = on_lattice(inner, self._lattice)
        return np.concatenate((self._ends[0], inner, self._ends[1]))


def on_lattice(points: Path, lattice: ChipMap) -> Path:
    """Return the lattice points nearest to ``points``, (n, 3) metres, none below them.

    Points above or outside the map are moved to its border.
    """
    across = np.floor(points[:, :2] / lattice.scale_m + 0.5)
    up = np.ceil((points[:, 2:] - lattice.base_m) / lattice.step_m)
    cells = np.clip(np.concatenate((across, up), axis=1), 0, lattice.limits)
    return lattice.to_metres(cells.astype(np.int64))
