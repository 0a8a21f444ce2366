"""Fitness of fixed paths."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from bench.scenarios import problem
from pathgene.host.evaluation import Evaluator
from tools.recording.commands import MAPS, plan


__all__ = ["draw_fixed_paths", "evaluate"]

_PLANNERS = {"astar": 8, "ga-pc": 60}
_DRAWN_WAYPOINTS = 4
#: Heights of drawn waypoints above the ground, metres.
_HEIGHTS_M = (-50.0, 250.0)


def evaluate(name: str, path: list[list[float]]) -> dict[str, float]:
    """Return every term of a path in metres on a map of :data:`MAPS`."""
    terms = Evaluator(problem(name), threads=1).evaluate(np.array(path)).to_dict()
    return {key: float(value) for key, value in terms.items()}


def draw_fixed_paths() -> list[dict[str, Any]]:
    """Return paths that planners find, straight ones and random ones, with every term."""
    fixed = []
    for name in MAPS:
        scenario = problem(name)
        paths = [
            plan(name, planner, "--seed", "1", "--generations", str(generations))[1]["waypoints"]
            for planner, generations in _PLANNERS.items()
        ]
        start, goal = list(scenario.start), list(scenario.goal)
        paths += [[start, goal], [start, *_drawn(name), goal]]
        fixed += [{"map": name, "path": path, "terms": evaluate(name, path)} for path in paths]
    return fixed


def _drawn(name: str) -> list[list[float]]:
    rng = random.Random(6)
    terrain = problem(name).terrain
    low, high = _HEIGHTS_M
    waypoints = []
    for _ in range(_DRAWN_WAYPOINTS):
        x, y = rng.random() * terrain.width_m, rng.random() * terrain.height_m
        height = low + (high - low) * rng.random()
        waypoints.append([x, y, float(terrain.ground(x, y)) + height])
    return waypoints
