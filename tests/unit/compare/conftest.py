"""A short flight, entrants, and reports of invented runs."""

import numpy as np
import pytest

from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.compare.statistics import compare_two, describe
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


@pytest.fixture(scope="session")
def problem():
    """Problem of a flight over hills, around a zone."""
    y, x = np.mgrid[:41, :61]
    terrain = Terrain(
        name="hills", elevation=300 + 150 * np.sin(x / 8) * np.cos(y / 6), dx_m=100.0, dy_m=100.0
    )
    return Problem(
        terrain,
        (500, 500, 100),
        (5500, 3500, 100),
        zones=(Circle(3000, 2000, 400),),
        agl=True,
        as_paper=True,
    )


@pytest.fixture
def entrants():
    """Two entrants of 15 generations, one with an option."""
    return parse_entrants("ga-fpga,ga-pc:max_waypoints=8", {"generations": 15}, {})


def made_up_runs(final, *, generations=30, each=22, first=32):
    """Return runs that end with the fitnesses ``final``, feasible above 1."""
    at = np.arange(generations + 1)
    runs = []
    for seed, fitness in enumerate(final):
        best = fitness * (1 - np.exp(-at - 0.5)) if generations else np.array([fitness])
        best[-1] = fitness
        runs.append(
            {
                "seed": seed,
                "fitness": float(fitness),
                "feasible": bool(fitness > 1),
                "seconds": {"total": 0.25 * (seed + 1)},
                "generations": generations,
                "evaluations": first + each * generations,
                "history": [[int(i), float(value), 0.5] for i, value in zip(at, best, strict=True)],
                "history_evaluations": (first + each * at).tolist(),
            }
        )
    return runs


@pytest.fixture(scope="session")
def report_of():
    """Function that makes the report of planners, given as a mapping from label to runs."""

    def make(planners, runs=50):
        listed = [
            {
                "label": label,
                "planner": label,
                "options": {},
                "failures": [],
                "statistics": describe(records),
                "runs": records,
            }
            for label, records in planners.items()
        ]
        pairs = [
            {
                "planners": [one["label"], other["label"]],
                **compare_two(*([run["fitness"] for run in part["runs"]] for part in (one, other))),
            }
            for i, one in enumerate(listed)
            for other in listed[i + 1 :]
        ]
        return {
            "terrain": {"name": "hills"},
            "uav": {"name": "Silver Fox-like"},
            "ds_m": 50.0,
            "seeds": [0, runs - 1],
            "planners": listed,
            "pairs": pairs,
        }

    return make
