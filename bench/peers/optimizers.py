"""Optimizers and planners of other projects, applied to the evaluation."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.jit import compiled
from pathgene.host.planners.airspace import Airspace


Vectors = NDArray[np.float64]


class BudgetSpentError(Exception):
    """Ends an optimizer that has used up its evaluations."""


class Objective:
    """The negated fitness of paths of free waypoints, for a limited number of evaluations.

    A vector has x, y and z of each waypoint in metres, between the airspace's bounds ``low`` and
    ``high``.

    Attributes
    ----------
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


#: Solutions of every optimizer, as in *roberge*, table 3.
POPULATION = 512
_SWITCHING = 0.5


@dataclass(frozen=True)
class Optimizer:
    """An optimizer of another project."""

    package: str
    #: True if it evaluates a population at once instead of path by path.
    batches: bool
    #: Minimizes an :class:`~bench.peers.optimizers.Objective` from a seed within some evaluations;
    #: imports the package.
    run: Callable[[Objective, int, int], object]


def _mealpy_fpa(objective: Objective, seed: int, evaluations: int) -> None:
    from mealpy import FPA, FloatVar

    problem = {
        "obj_func": objective.one,
        "bounds": FloatVar(lb=objective.low, ub=objective.high),
        "minmax": "min",
        "log_to": None,
    }
    model = FPA.OriginalFPA(
        epoch=ceil(evaluations / POPULATION), pop_size=POPULATION, p_s=_SWITCHING
    )
    model.solve(problem, seed=seed)


def _pymoo(algorithm: str) -> Callable[[Objective, int, int], None]:
    def run(objective: Objective, seed: int, evaluations: int) -> None:
        from pymoo.algorithms.soo.nonconvex.de import DE
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize

        class Paths(Problem):  # type: ignore[misc]  # pymoo has no types.
            def __init__(self) -> None:
                super().__init__(
                    n_var=len(objective.low), n_obj=1, xl=objective.low, xu=objective.high
                )

            def _evaluate(
                self, x: NDArray[np.float64], out: dict[str, Any], *args: Any, **kwargs: Any
            ) -> None:
                out["F"] = objective.batch(x)

        chosen = {"GA": GA, "DE": DE}[algorithm](pop_size=POPULATION)
        minimize(Paths(), chosen, ("n_eval", evaluations), seed=seed, verbose=False)

    return run


def _deap(objective: Objective, seed: int, evaluations: int) -> None:
    from deap import algorithms, base, creator, tools

    if not hasattr(creator, "Path"):
        creator.create("Least", base.Fitness, weights=(-1.0,))
        creator.create("Path", list, fitness=creator.Least)
    random.seed(seed)  # DEAP draws from the module's own generator.
    low, high = objective.low.tolist(), objective.high.tolist()
    box = {"low": low, "up": high, "eta": 20.0}
    toolbox = base.Toolbox()
    toolbox.register("individual", lambda: creator.Path(map(random.uniform, low, high)))
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    toolbox.register("evaluate", lambda path: (objective.one(np.array(path)),))
    toolbox.register("mate", tools.cxSimulatedBinaryBounded, **box)
    toolbox.register("mutate", tools.mutPolynomialBounded, indpb=1 / len(low), **box)
    toolbox.register("select", tools.selTournament, tournsize=3)
    # Nine in ten members of a generation are crossed or mutated, and therefore evaluated.
    algorithms.eaSimple(
        toolbox.population(POPULATION),
        toolbox,
        cxpb=0.9,
        mutpb=0.2,
        ngen=2 * ceil(evaluations / POPULATION),
        verbose=False,
    )


def _scipy_de(objective: Objective, seed: int, evaluations: int) -> None:
    from scipy.optimize import differential_evolution

    dimensions = len(objective.low)
    differential_evolution(
        lambda columns: objective.batch(columns.T),
        list(zip(objective.low, objective.high, strict=True)),
        popsize=ceil(POPULATION / dimensions),
        maxiter=ceil(evaluations / POPULATION),
        tol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=seed,
    )


#: Every optimizer, by the name in the table.
OPTIMIZERS: Mapping[str, Optimizer] = MappingProxyType(
    {
        "mealpy FPA": Optimizer("mealpy", False, _mealpy_fpa),
        "DEAP GA": Optimizer("deap", False, _deap),
        "pymoo GA": Optimizer("pymoo", True, _pymoo("GA")),
        "pymoo DE": Optimizer("pymoo", True, _pymoo("DE")),
        "SciPy DE": Optimizer("scipy", True, _scipy_de),
    }
)


#: Names of the planners in ``ompl.geometric``.
PLANNERS = ("RRTConnect", "AORRTC", "RRTstar", "BITstar")

# Unit of length for OMPL, because AORRTC of OMPL 2.0.1 fails at costs in the thousands.
_UNIT_M = 1000.0
# Margin over the ground and around zones: the checker tests points, the evaluation whole segments.
_CLEARANCE_M = 5.0


@compiled
def _is_free(
    floor: NDArray[np.float64], dx: float, dy: float, x: float, y: float, z: float
) -> bool:
    """Return whether a point of the map is above its nearest node's ``floor``."""
    rows, columns = floor.shape
    row, column = min(int(y / dy + 0.5), rows - 1), min(int(x / dx + 0.5), columns - 1)
    return bool(z >= floor[row, column])


def solve(
    evaluator: Evaluator, planner: str, seed: int, seconds: float
) -> NDArray[np.float64] | None:
    """Return a path (n, 3), including start and goal, or None if none was found.

    The planner knows the airspace and minimizes the length; it does not know turns, climbs and
    fuel. OMPL simplifies the path found within the same seconds.
    """
    from ompl import base, geometric, util

    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)  # 0 is not a valid seed.
    problem = evaluator.problem
    airspace = Airspace(problem)
    floor, dx, dy = airspace.floor, float(problem.terrain.dx_m), float(problem.terrain.dy_m)
    _is_free(floor, dx, dy, *problem.start)  # Compiles.
    space = base.RealVectorStateSpace(3)
    bounds = base.RealVectorBounds(3)
    for axis in range(3):
        bounds.setLow(axis, float(airspace.low[axis]) / _UNIT_M)
        bounds.setHigh(axis, float(airspace.high[axis]) / _UNIT_M)
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)

    def is_free(state: Sequence[float]) -> bool:
        x, y, z = (_UNIT_M * state[axis] for axis in range(3))
        return _is_free(floor, dx, dy, x, y, z - _CLEARANCE_M)

    setup.setStateValidityChecker(is_free)
    information = setup.getSpaceInformation()
    step = evaluator.ds_m / _UNIT_M / space.getMaximumExtent()
    information.setStateValidityCheckingResolution(step)
    ends = []
    for point in (problem.start, problem.goal):
        end = space.allocState()
        for axis in range(3):
            end[axis] = float(point[axis]) / _UNIT_M
        ends.append(end)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(getattr(geometric, planner)(information))
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None
    left = seconds - setup.getLastPlanComputationTime()
    if left > 0:
        setup.simplifySolution(left)
    states = setup.getSolutionPath().getStates()
    path = _UNIT_M * np.array([[state[axis] for axis in range(3)] for state in states])
    if not np.allclose(path[0], problem.start):
        # Where the straight line is free, AORRTC of OMPL 2.0.1 returns the goal twice.
        return np.array([problem.start, problem.goal])
    return path
