"""The PC-only genetic algorithm of *allaire-2008*, section 3, in metres: the baseline."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.grid.initial import Variation, astar_paths, check_init
from pathgene.host.planners.roulette import roulette


__all__ = ["PcGeneticPlanner", "crossover", "smooth_turn"]

Path = NDArray[np.float64]

#: Minimum transitional waypoints of a path (section 3.1).
MIN_WAYPOINTS = 2
#: Paths in the population by default (section 4.1.1); section 3.1 found 30 to 40 good.
POPULATION = 32

_CROSSOVER_SHARE = 0.70  # Share of the population replaced by children (section 3.3).
_ELITE_SHARE = 0.05  # Share of the population kept for being best (section 3.5).
_MUTATION_RATE = 0.05  # Probability that a child is mutated, in one of five ways (3.4).
_BOX_SHARE = 0.15  # Edge of the mutation box divided by the edge of the map (3.4.1).
_SHARP_TURN_RAD = math.radians(45)
# Above these limits a generation takes minutes and soon exhausts the memory.
_LARGEST_POPULATION = 100_000
_MOST_WAYPOINTS = 1000
_REFITS = 2  # Refits in a generation, with astar.
_DRAWS = 8  # Maximum draws for a waypoint that is not in the ground.


class PcGeneticPlanner:
    """Genetic algorithm with fitness roulette, run only on the PC.

    In each generation, 70 % of the population is replaced by children of parents that are drawn in
    proportion to their fitness and cut at their middles; each child is mutated with a chance of 5
    %, in one of five ways drawn uniformly (perturb, insert, delete, smooth-turn, swap); the best 5
    % survive, and a roulette without replacement chooses the remaining survivors from the rest.

    An addition, by default if the first population is not random: some children of a generation,
    the refits, are copies of the best path with one or two waypoints moved slightly and all
    altitudes as low as the ground and the climb limits allow
    (:meth:`~pathgene.host.planners.grid.initial.Variation.nudged`). The paper's mutations move a
    waypoint far and keep its altitude; they rarely improve a good path, which flies close to the
    ground.

    Source: *allaire-2008*, section 3. The paper leaves some points open; here, the edges of the
    mutation box are 15 % of the map's; a new waypoint in the ground, in a no-fly zone or over a
    void is redrawn 7 times, then the mutation is skipped; a turn is sharp above 45 degrees;
    children to mutate are drawn uniformly. The swap is one of the five of section 3.4 here,
    although section 3.4.5 keeps it for missions of several objectives.

    Parameters
    ----------
    max_waypoints : int
        Maximum number of transitional waypoints of a path, 3 to 1000.
    mutation_rate : float
        Probability that a child is mutated, 0 to 1.
    init : str
        ``random``, or ``astar``: the first population comes from
        :func:`pathgene.host.planners.grid.initial.astar_paths`.
    refits : int, optional
        Number of children of a generation that are refits, from 0 to all; each takes about 10 ms.
        By default 2 with ``astar`` and 0 with ``random``.

    Raises
    ------
    InputError
        If a parameter is outside its range.
    """

    def __init__(
        self,
        *,
        max_waypoints: int = 20,
        mutation_rate: float = _MUTATION_RATE,
        init: str = "random",
        refits: int | None = None,
    ) -> None:
        if not 3 <= max_waypoints <= _MOST_WAYPOINTS:
            raise InputError(
                f"The most waypoints of a path must be from 3 to {_MOST_WAYPOINTS}, "
                f"not {max_waypoints}."
            )
        if not 0 <= mutation_rate <= 1:
            raise InputError(f"The mutation rate must be from 0 to 1, not {mutation_rate:g}.")
        self.max_waypoints = max_waypoints
        self.mutation_rate = mutation_rate
        self.from_astar = check_init(init)
        self.refits = (_REFITS if self.from_astar else 0) if refits is None else refits
        if self.refits < 0:
            raise InputError(f"The refits of a generation must be 0 or more, not {refits}.")

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Planner`.

        Raises
        ------
        InputError
            If the population is not from 8 to 100,000, a generation has fewer children than refits,
            or the map has no flyable cell.
        """
        count = POPULATION if options.population is None else options.population
        if not 8 <= count <= _LARGEST_POPULATION:
            raise InputError(
                f"The population of ga-pc must be from 8 to {_LARGEST_POPULATION}, not {count}."
            )
        children_count = 2 * _pairs(count)
        if self.refits > children_count:
            raise InputError(
                f"A generation has {children_count} children, so there can be at most "
                f"as many refits, not {self.refits}."
            )
        problem = evaluator.problem
        rng = np.random.default_rng(options.seed)
        space = Airspace(problem)
        ends = np.array([problem.start]), np.array([problem.goal])

        run = Run(evaluator, options, progress, stop)
        found = None
        if self.from_astar:
            found = astar_paths(run, rng, count, self.max_waypoints, fewest=MIN_WAYPOINTS)
        paths = (
            [space.draw(rng, MIN_WAYPOINTS) for _ in range(count)]
            if found is None
            else [path[1:-1] for path in found]
        )
        vary = Variation(problem, rng, self.max_waypoints, MIN_WAYPOINTS) if self.refits else None

        def evaluate(some: list[Path]) -> NDArray[np.float64]:
            return run.fitness([np.concatenate((ends[0], path, ends[1])) for path in some])

        fitness = evaluate(paths)
        generation = 0
        run.record(generation, fitness)
        with run.search():
            while run.stopped_by() is None:
                # The phases of table 1.
                with run.phase("selection_crossover"):
                    children = self._children(paths, fitness, rng)
                with run.phase("mutation"):
                    for i in np.flatnonzero(rng.random(len(children)) < self.mutation_rate):
                        children[i] = self._mutated(children[i], space, rng)
                if vary is not None:
                    best = paths[int(np.argmax(fitness))]
                    with run.phase("refits"):
                        children[-self.refits :] = [
                            vary.nudged(np.concatenate((ends[0], best, ends[1])))[1:-1]
                            for _ in range(self.refits)
                        ]
                with run.phase("population_update"):
                    kept = _kept(fitness, count - len(children), rng)
                    paths = [*(paths[i] for i in kept), *children]
                fitness = np.concatenate((fitness[kept], evaluate(children)))
                generation += 1
                run.record(generation, fitness)
        return run.result()

    def _children(
        self, paths: list[Path], fitness: NDArray[np.float64], rng: np.random.Generator
    ) -> list[Path]:
        parents = roulette(fitness, 2 * _pairs(len(paths)), rng)
        children: list[Path] = []
        for one, other in zip(parents[::2], parents[1::2], strict=True):
            children += crossover(paths[one], paths[other], self.max_waypoints, rng)
        return children

    def _mutated(self, path: Path, space: Airspace, rng: np.random.Generator) -> Path:
        """Return ``path`` mutated in one of five ways, or unchanged if a limit forbids it."""
        kind = rng.choice(("perturb", "insert", "delete", "smooth-turn", "swap"))
        at = int(rng.integers(len(path)))
        full = len(path) >= self.max_waypoints
        if kind == "delete":
            return np.delete(path, at, axis=0) if len(path) > MIN_WAYPOINTS else path
        if kind == "swap":
            one, other = rng.choice(len(path), 2, replace=False)
            swapped = path.copy()
            swapped[[one, other]] = path[[other, one]]
            return swapped
        if kind == "perturb" or (kind == "insert" and not full):
            moved = space.draw_near(rng, path[at], _BOX_SHARE, _DRAWS)
            if moved is None:
                return path
            if kind == "insert":
                return np.insert(path, at + 1, moved, axis=0)
            perturbed = path.copy()
            perturbed[at] = moved
            return perturbed
        if kind == "smooth-turn" and not full:
            return smooth_turn(path, space)
        return path


def _pairs(population: int) -> int:
    """Return the pairs of children in a generation."""
    return max(1, round(_CROSSOVER_SHARE * population / 2))


def _kept(fitness: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the indices of ``count`` survivors: the best, then a roulette without replacement."""
    order = np.argsort(-fitness, kind="stable")
    elites = min(count, max(1, round(_ELITE_SHARE * len(fitness))))
    kept, left = list(order[:elites]), list(order[elites:])
    while len(kept) < count:
        kept.append(left.pop(int(roulette(fitness[left], 1, rng)[0])))
    return np.array(kept, dtype=np.intp)


def crossover(
    one: Path, other: Path, max_waypoints: int, rng: np.random.Generator
) -> tuple[Path, Path]:
    """Exchange the tails of two paths of waypoints, (n, 3), and return the children.

    Paths are cut at the middle (section 3.3); with an odd number of waypoints, at random before or
    after the middle one. If a child would have more than ``max_waypoints``, which can only happen
    with an odd limit, both paths are cut before it.
    """
    cuts = [(len(path) + int(rng.integers(2)) * (len(path) % 2)) // 2 for path in (one, other)]
    longest = max(cuts[0] + len(other) - cuts[1], cuts[1] + len(one) - cuts[0])
    if longest > max_waypoints:
        cuts = [len(one) // 2, len(other) // 2]
    return (
        np.concatenate((one[: cuts[0]], other[cuts[1] :])),
        np.concatenate((other[: cuts[1]], one[cuts[0] :])),
    )


def smooth_turn(path: Path, space: Airspace) -> Path:
    """Soften the sharpest turn of ``path`` if it is sharp (section 3.4.4).

    A waypoint is added half a leg past the corner, on the heading that bisects the turn, so that
    both remaining turns are smaller. ``path`` is returned unchanged if no turn exceeds 45 degrees,
    or if the new waypoint would not be free.

    Parameters
    ----------
    path : ndarray
        Transitional waypoints, (n, 3) float64 metres.
    """
    points = np.concatenate(([space.start], path, [space.goal]))
    legs = np.diff(points[:, :2], axis=0)
    before, after = legs[:-1], legs[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.arctan2(cross, (before * after).sum(axis=1))
    corner = int(np.argmax(np.abs(turns)))
    if abs(turns[corner]) <= _SHARP_TURN_RAD:
        return path
    heading = math.atan2(before[corner, 1], before[corner, 0]) + turns[corner] / 2
    half = np.hypot(*after[corner]) / 2
    at = points[corner + 1]
    climb = (points[corner + 2, 2] - at[2]) / 2
    added = at + np.array((half * math.cos(heading), half * math.sin(heading), climb))
    if not space.is_free(added[None])[0]:
        return path
    return np.insert(path, corner + 1, added, axis=0)
