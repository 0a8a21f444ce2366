"""The ample search of the replan benchmark, at the instant of a change."""

import pytest

from bench import replan
from bench.replan import Question, is_there_a_path
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.zones import Circle
from pathgene.host.replanning.departure import Departure
from pathgene.host.replanning.present import Present


LEAVES_M = 1000.0
# Centre of the zone ahead, east of where the plan begins.
AHEAD = 1500.0 + LEAVES_M, 4500.0


@pytest.fixture
def asked(mission, straight):
    """Function that returns a question: a zone at a distance ahead of the aircraft."""
    track = Evaluator(mission, threads=1).track(straight).pieces

    def question(zones, goal=mission.goal):
        present = Present(mission, zones, goal, (0.0, 0.0))
        departure = Departure(track, LEAVES_M, None)
        return Question(departure, present, mission.aircraft, LEAVES_M - 5.0)

    return question


def test_a_way_around_a_zone_is_found(asked, board):
    x, y = AHEAD
    assert is_there_a_path(asked([Circle(x + 1000.0, y, 300.0)]), board)


def test_a_zone_that_no_turn_avoids_leaves_no_path(asked, board):
    x, y = AHEAD
    assert not is_there_a_path(asked([Circle(x + 325.0, y, 280.0)]), board)


def test_a_goal_in_a_zone_has_no_path(asked, board, mission):
    x, y = mission.goal[:2]
    assert not is_there_a_path(asked([Circle(x, y, 200.0)]), board)


def test_a_path_that_cannot_be_joined_is_none(asked, board, monkeypatch):
    monkeypatch.setattr(replan, "fault_of", lambda *_: "The path turns too sharply.")
    assert not is_there_a_path(asked([]), board)
