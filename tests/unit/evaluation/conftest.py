"""Small problems in which the terms of a path can be computed by hand."""

from collections.abc import Callable

import numpy as np
import pytest

from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


MakeProblem = Callable[..., Problem]


@pytest.fixture
def make_problem() -> MakeProblem:
    """Function that makes a problem over the given heights, or flat ground of 5 x 5 km at 100 m."""

    def make(start, goal, elevation=None, *, dx_m=100.0, dy_m=100.0, **options):
        elevation = np.full((51, 51), 100.0) if elevation is None else elevation
        terrain = Terrain(
            name="world", elevation=elevation, dx_m=dx_m, dy_m=dy_m, crs=None, origin=(0.0, 0.0)
        )
        options.setdefault("as_paper", "rules" not in options)
        options.setdefault("aircraft", aircraft.load("silver-fox"))
        return Problem(terrain, start, goal, **options)

    return make
