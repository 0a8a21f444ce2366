"""Missions that pathgene writes are read back and found feasible."""

import numpy as np
import pytest

import pathgene
from pathgene.host.formats.registry import read_mission
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.mission.export import exported
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import load
from pathgene.host.terrain.origin import at_origin
from tests.support.host.foreign import NOWHERE


FORMATS = ("plan", "waypoints", "kml")


def planned(name, seed):
    """Return a problem among zones, and its path by astar; None if there is no path."""
    rng = np.random.default_rng(seed)
    terrain = load(name)
    if terrain.crs is None:
        terrain = at_origin(terrain, 46.0, 7.0)
    size = np.array((terrain.width_m, terrain.height_m))
    start, goal = rng.uniform(0.08, 0.4, 2) * size, rng.uniform(0.6, 0.92, 2) * size
    zones = [
        Circle(*rng.uniform(0.3, 0.7, 2) * size, rng.uniform(100, 400))
        for _ in range(rng.integers(0, 3))
    ]
    heights = rng.uniform(35, 120, 2)
    wind = rng.uniform(-4, 4, 2) if seed % 2 else (0.0, 0.0)
    try:
        problem = Problem(
            terrain, (*start, heights[0]), (*goal, heights[1]), zones=zones, wind=wind, agl=True
        )
    except pathgene.InputError:
        return None
    found = pathgene.plan(problem, planner="astar")
    return (problem, found.path) if found.evaluation.feasible else None


def faults_of(tmp_path, name, seed):
    """Check the files of a plan; return the faults, or None without a plan."""
    found = planned(name, seed)
    if found is None:
        return None
    problem, path = found
    try:
        files = exported(problem, path, FORMATS, lambda _: None)
    except NoRoomError:
        return None
    same = FlightProblem(problem.terrain, NOWHERE, NOWHERE, zones=problem.zones, wind=problem.wind)
    lines = []
    for file, content in files.items():
        (tmp_path / file).write_bytes(content)
        check = check_mission(read_mission(tmp_path / file), same)
        lines += [(name, seed, file, line) for line in check.lines]
    return lines


@pytest.mark.ci
def test_a_mission_of_our_own_passes(tmp_path):
    assert faults_of(tmp_path, "canyon", 2) == []


@pytest.mark.long
def test_missions_of_our_own_pass(tmp_path):
    found = [
        faults
        for name in ("canyon", "jacksboro", "river")
        for seed in range(100, 140)
        if (faults := faults_of(tmp_path, name, seed)) is not None
    ]
    assert [faults for faults in found if faults] == []
    assert len(found) > 60
