"""A small problem for plans on simulated boards."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


@pytest.fixture(scope="module")
def evaluator():
    """Evaluator of a flight over a wall with a gap."""
    elevation = np.full((31, 31), 100.0)
    elevation[:24, 14:17] = 500.0
    terrain = Terrain(
        name="wall", elevation=elevation, dx_m=100.0, dy_m=100.0, crs=None, origin=(0.0, 0.0)
    )
    problem = Problem(
        terrain, (200, 300, 200), (2800, 300, 200), aircraft.load("silver-fox"), as_paper=True
    )
    return Evaluator(problem, threads=1)
