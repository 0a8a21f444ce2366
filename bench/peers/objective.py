"""The objective of the peers: the evaluation as a function of a vector."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.airspace import Airspace


__all__ = ["BudgetSpentError", "Objective"]

Vectors = NDArray[np.float64]


class BudgetSpentError(Exception):
    """Ends an optimizer that has used up its evaluations."""


class Objective:
    """The negated fitness of paths of free waypoints, for a limited number of evaluations.

    Parameters
    ----------
    evaluator : Evaluator
    waypoints : int
        Free waypoints of a path; x, y and z of each are three numbers of a vector, metres.
    evaluations : int
        Maximum number of evaluations.

    Attributes
    ----------
    low, high : ndarray
        Bounds of a vector, (3 * waypoints,) float64, from the airspace.
    evaluations : int
        Number of evaluations made.
    history : list of (int, float, float)
        At each improvement: evaluations, seconds since the first one began, best fitness.
    best : ndarray
        The best path evaluated, (waypoints + 2, 3), including start and goal.
    """

    def __init__(self, evaluator: Evaluator, waypoints: int, evaluations: int) -> None:
        problem = evaluator.problem
        space = Airspace(problem)
        self.low, self.high = (np.tile(corner, waypoints) for corner in (space.low, space.high))
        self.evaluations = 0
        self.history: list[tuple[int, float, float]] = []
        self._evaluator, self._granted = evaluator, evaluations
        self._ends = np.array(problem.start), np.array(problem.goal)
        self._waypoints = waypoints
        self._started: float | None = None
        self.best = np.array(self._ends)

    def one(self, vector: Vectors) -> float:
        """Return the objective of one vector, (d,); less is better.

        Raises
        ------
        BudgetSpentError
            If no evaluation is left.
        """
        return float(self.batch(np.asarray(vector)[None])[0])

    def batch(self, vectors: Vectors) -> NDArray[np.float64]:
        """Return the objective of vectors, (m, d), as (m,) float64; see :meth:`one`."""
        if self._started is None:
            self._started = time.perf_counter()
        if self.evaluations >= self._granted:
            raise BudgetSpentError
        count, last = len(vectors), self._waypoints + 1
        paths = np.empty((count, last + 1, 3))
        paths[:, 0], paths[:, last] = self._ends
        paths[:, 1:last] = vectors.reshape(count, self._waypoints, 3)
        fitness = self._evaluator.fitness(paths, np.full(count, last + 1))
        self.evaluations += count
        best = int(fitness.argmax())
        if not self.history or fitness[best] > self.history[-1][2]:
            seconds = time.perf_counter() - self._started
            self.history.append((self.evaluations, seconds, float(fitness[best])))
            self.best = paths[best]
        return -fitness

    def fitness_after(self, seconds: float) -> float:
        """Return the best fitness after a number of seconds from the first evaluation."""
        return max((best for _, at, best in self.history if at <= seconds), default=0.0)
