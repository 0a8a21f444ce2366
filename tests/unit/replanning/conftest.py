"""Terrain, missions and planners of flights with replans."""

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.replanning.planner import InFlightPlanner
from pathgene.host.terrain import Terrain


FOX = aircraft.load("silver-fox")


@pytest.fixture(scope="session")
def hills():
    """Hills of 60 m around 100 m, 9 x 9 km."""
    y, x = np.mgrid[:151, :151]
    elevation = 100 + 30 * (np.sin(x / 11) * np.cos(y / 9) + 1)
    return Terrain("hills", elevation, dx_m=60.0, dy_m=60.0)


@pytest.fixture(scope="session")
def mission(hills):
    """A flight of 5 km over them."""
    return Problem(hills, (1500.0, 4500.0, 250.0), (6500.0, 4500.0, 250.0), FOX, rules=Rules())


@pytest.fixture(scope="session")
def straight(mission):
    """Its straight path, which is safe."""
    path = np.array([mission.start, mission.goal])
    assert Evaluator(mission, threads=1).evaluate(path).feasible
    return path


@pytest.fixture(scope="module")
def board():
    """A chip with the planner core, which stays open."""
    with open_board("model:?core=planner") as chip:
        yield chip


@pytest.fixture
def on_chip(board, mission):
    """The planner core, prepared."""
    planner = InFlightPlanner("ga-chip", board=board)
    planner.prepare(Evaluator(mission, threads=1))
    return planner


@pytest.fixture
def on_processor(mission):
    """A planner on the processor that takes a given time, prepared."""

    def prepared(seconds):
        planner = InFlightPlanner("astar", seconds=seconds)
        planner.prepare(Evaluator(mission, threads=1))
        return planner

    return prepared
