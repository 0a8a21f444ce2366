"""A ridge with a gap, small enough for searches of milliseconds."""

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Search
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


ZONES = (Circle(4500, 1800, 300),)


def ridge(void=False):
    """Return heights (41, 61) at 100 m: a wall across of 600 m, with a gap in the north."""
    elevation = np.full((41, 61), 100.0)
    elevation[:30, 28:33] = 600.0
    if void:
        elevation[:, 10:13] = np.nan
    return elevation


@pytest.fixture
def make_evaluator():
    """Function that makes the evaluator of a flight over the ridge or ``elevation``."""

    def make(elevation=None, zones=ZONES, **options):
        terrain = Terrain(
            name="ridge",
            elevation=ridge() if elevation is None else elevation,
            dx_m=100.0,
            dy_m=100.0,
            crs=None,
            origin=(0.0, 0.0),
        )
        start, goal = options.pop("start", (500, 500, 200)), options.pop("goal", (5500, 700, 220))
        options.setdefault("as_paper", "rules" not in options)
        problem = Problem(terrain, start, goal, aircraft.load("silver-fox"), zones=zones, **options)
        return Evaluator(problem, threads=1)

    return make


@pytest.fixture
def evaluator(make_evaluator):
    """Evaluator of the flight over the ridge, around a no-fly zone."""
    return make_evaluator()


@pytest.fixture
def record():
    """Progress callback with a list ``seen`` of its arguments."""

    def progress(*values):
        progress.seen.append(list(values))

    progress.seen = []
    return progress


@pytest.fixture
def board():
    """A chip with the planner core, which stays open."""
    with open_board("model:?core=planner") as chip:
        yield chip


@pytest.fixture
def search(board):
    """The planner on it, unpolished."""
    return Search("ga-chip", board=board, chip_ms=4, polish="off", seed=3, fallback="astar")
