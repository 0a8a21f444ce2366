"""Problems that contradict themselves are refused with a sentence."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.heights import geoid_m
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.way import WayProblem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


FLAT = Terrain("flat", np.full((31, 31), 100.0), 100.0, 100.0)
START, GOAL = (500.0, 500.0, 300.0), (2500.0, 2500.0, 300.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"as_paper": True, "start_heading_deg": 90}, "knows no headings"),
        ({"as_paper": True, "goal_heading_deg": 90}, "knows no headings"),
        ({"as_paper": True, "rules": Rules(clearance_m=1)}, "has no rules"),
        ({"rules": {"clearance_m": 1}}, "The rules must be Rules"),
        ({"ds_m": 1e-3}, "makes more than"),
    ],
)
def test_options_that_contradict_each_other_are_refused(options, words):
    with pytest.raises(InputError, match=words):
        Problem(FLAT, START, GOAL, **options)
    kept = {"as_paper": True} if options.get("as_paper") else {}
    assert Problem(FLAT, START, GOAL, **kept).as_paper == bool(kept)


def test_two_equal_points_of_a_way_are_refused():
    with pytest.raises(InputError, match="are the same"):
        WayProblem(FLAT, [START, (1500.0, 500.0, 300.0), (1500.0, 500.0, 300.0), GOAL])
    assert len(WayProblem(FLAT, [START, (1500.0, 500.0, 300.0), GOAL]).way) == 3


def test_an_aircraft_without_its_ending_is_refused(tmp_path):
    file = tmp_path / "mine"
    file.write_text("")
    with pytest.raises(InputError, match=r"must end in \.toml"):
        aircraft.load(str(file))


@pytest.mark.parametrize("limit", ["lower", "upper"])
def test_a_limit_is_above_the_sea_or_above_the_ground(limit):
    with pytest.raises(InputError, match="not both"):
        Circle(1500, 1500, 100, **{f"{limit}_m": 150, f"{limit}_agl_m": 50})
    zone = Circle(1500, 1500, 100, **{f"{limit}_agl_m": 50})
    assert zone.follows_ground
    assert limit in str(zone.to_dict())


def test_the_geoid_of_a_terrain_without_a_place_is_any():
    lowest, highest = geoid_m(FLAT)
    assert lowest < -100
    assert highest > 80


def test_a_band_over_the_ground_that_ends_before_it_begins_is_no_zone():
    """A zone from 150 m above the sea to 30 m above ground at 100 m."""
    path = np.array([(500.0, 1500.0, 160.0), (2500.0, 1500.0, 160.0)])
    for upper_agl_m, is_free in ((30.0, True), (70.0, False)):
        zone = Circle(1500, 1500, 100, lower_m=150.0, upper_agl_m=upper_agl_m)
        problem = Problem(
            FLAT, tuple(path[0]), tuple(path[1]), zones=[zone], rules=Rules(zone_margin_m=0)
        )
        assert Evaluator(problem, threads=1).evaluate(path).feasible == is_free


def test_a_zone_that_is_gone_must_have_been_there():
    problem = Problem(FLAT, START, GOAL)
    with pytest.raises(InputError, match="none of the problem"):
        changed_problem(problem, gone=[Circle(1500, 1500, 100)])
