"""Random missions with their tracks."""

import pytest

from pathgene.host.evaluation import Evaluator
from tests.support.host.missions import SEEDS, make_mission
from tests.support.host.short_flights import make_run


__all__ = ["make_run", "missions", "tracks"]


@pytest.fixture(scope="session")
def missions():
    """Return random missions."""
    return [make_mission(seed) for seed in SEEDS]


@pytest.fixture(scope="session")
def tracks(missions):
    return [Evaluator(problem, threads=1).track(path) for problem, path in missions]
