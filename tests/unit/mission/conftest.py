"""Random missions, with their tracks and flight plans."""

import pytest

from pathgene.host.evaluation import Evaluator
from tests.support.host.missions import SEEDS, flight, make_mission


@pytest.fixture(scope="session")
def missions():
    """Return random missions."""
    return [make_mission(seed) for seed in SEEDS]


@pytest.fixture(scope="session")
def tracks(missions):
    return [Evaluator(problem, threads=1).track(path) for problem, path in missions]


@pytest.fixture(scope="session")
def plans():
    """Return the missions in the form that an autopilot accepts."""
    return [flight(seed) for seed in SEEDS]
