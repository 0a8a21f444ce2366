"""Optimizers of other projects, applied to the evaluation."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.peers.objective import Objective


__all__ = ["OPTIMIZERS", "POPULATION", "Optimizer"]

#: Solutions of every optimizer, as in *roberge*, table 3.
POPULATION = 512
_SWITCHING = 0.5


@dataclass(frozen=True)
class Optimizer:
    """An optimizer of another project.

    Parameters
    ----------
    package : str
        Name of its distribution.
    batches : bool
        True if it evaluates a population at once instead of path by path.
    run : callable
        Minimizes an :class:`~bench.peers.objective.Objective` from a seed within some evaluations;
        imports the package.
    """

    package: str
    batches: bool
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
