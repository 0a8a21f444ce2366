"""Short flights over small terrains, for reports."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Run
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain


@pytest.fixture(scope="session")
def make_run():
    """Function that returns the evaluator and result of a flight through two waypoints."""

    def make(
        shape=(41, 61),
        side_m=100.0,
        *,
        crs=None,
        origin=None,
        void=False,
        relief=500.0,
        nofly=True,
        height_m=300.0,
        history=30,
        failure=None,
        as_paper=False,
    ):
        rng = np.random.default_rng(0)
        y, x = np.mgrid[: shape[0], : shape[1]]
        elevation = (
            100
            + relief * (0.5 + 0.5 * np.sin(x / 9) * np.cos(y / 7))
            + 0.02 * relief * rng.random(shape)
        )
        if void:
            elevation[: shape[0] // 3, shape[1] // 2 : shape[1] // 2 + 4] = np.nan
        terrain = Terrain(
            name="waves", elevation=elevation, dx_m=side_m, dy_m=side_m, crs=crs, origin=origin
        )
        width, height = terrain.width_m, terrain.height_m
        ends = [(share * width, share * height) for share in (0.08, 0.92)]
        zones = (
            (
                Circle(0.5 * width, 0.52 * height, 0.07 * min(width, height)),
                Polygon(
                    (
                        (0.1 * width, 0.6 * height),
                        (0.2 * width, 0.6 * height),
                        (0.2 * width, 0.8 * height),
                    )
                ),
            )
            if nofly
            else ()
        )
        problem = Problem(
            terrain, (*ends[0], 100), (*ends[1], 100), zones=zones, agl=True, as_paper=as_paper
        )
        evaluator = Evaluator(problem, threads=1)
        run = Run(evaluator, Options())
        path = np.array(
            [
                problem.start,
                (0.3 * width, 0.2 * height, 100 + relief + height_m),
                (0.8 * width, 0.7 * height, 100 + relief + height_m),
                problem.goal,
            ]
        )
        fitness = run.fitness([path])
        for generation in range(history):
            run.record(generation, fitness * (1 - 0.5 / (generation + 1)))
        run.failure = failure
        return evaluator, run.result()

    return make
