"""Problems after changes in flight."""

import dataclasses
import re

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


OLD, NEW = Zone.circle(2000, 2000, 100), Zone.circle(3000, 1000, 200)


@pytest.fixture
def problem():
    terrain = Terrain(
        name="flat", elevation=np.zeros((41, 61)), dx_m=100.0, dy_m=100.0, crs=None, origin=(0, 0)
    )
    return Problem(
        terrain, (500, 500, 100), (5500, 3000, 200), aircraft.load("silver-fox"), zones=[OLD],
        wind=(3, 0), start_heading_deg=45, goal_heading_deg=90,
    )  # fmt: skip


def test_all_else_stays(problem):
    changed = changed_problem(problem, [OLD, NEW], (900, 600, 120), 60)
    different = {
        field.name
        for field in dataclasses.fields(problem)
        if getattr(problem, field.name) != getattr(changed, field.name)
    }
    assert different == {"zones", "start", "start_heading_deg"}
    assert changed.zones == (OLD, NEW)
    assert changed.start == (900, 600, 120)
    assert changed.start_heading_deg == 60


def test_a_heading_belongs_to_its_start(problem):
    assert changed_problem(problem).start_heading_deg == 45
    assert changed_problem(problem, heading=-90).start_heading_deg == 270
    assert changed_problem(problem, start=(900, 600, 120)).start_heading_deg is None
    assert changed_problem(problem, start=(900, 600, 120)).goal_heading_deg == 90


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"zones": NEW}, f"The zones must be a list of no-fly zones, not {NEW!r}."),
        ({"start": (1, 2)}, "The start must be 3 finite numbers, not (1, 2)."),
        ({"start": (900, 600, np.nan)}, "The start must be 3 finite numbers, not (900, 600, nan)."),
        ({"heading": "north"}, "The start heading must be a number, not 'north'."),
        (
            {"heading": 400},
            "The start heading must be from -360 to 360 degrees from north, not 400.",
        ),
        (
            {"start": (3000, 1000, 50), "zones": [NEW]},
            "The start at (3000, 1000) is inside a no-fly zone; move it or the zone.",
        ),
    ],
)
def test_what_is_no_change_is_refused(problem, arguments, sentence):
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        changed_problem(problem, **arguments)


def test_as_paper_there_is_no_heading(problem):
    paper = dataclasses.replace(problem, rules=None, start_heading_deg=None, goal_heading_deg=None)
    assert changed_problem(paper, [NEW]).as_paper
    sentence = r"^The evaluation of the papers knows no headings; leave the heading out\.$"
    with pytest.raises(InputError, match=sentence):
        changed_problem(paper, heading=60)


def test_a_zone_above_the_ground_comes_and_goes_whole():
    y, x = np.mgrid[:41, :61]
    terrain = Terrain("steep", 10.0 * (x + y), 100.0, 100.0)
    problem = Problem(terrain, (500, 500, 300), (5500, 3000, 1000))
    zone = Zone.circle(3000, 2500, 400, name="R-7")
    zone = dataclasses.replace(zone, upper_agl_m=50.0)
    with_zone = changed_problem(problem, [zone])
    assert len(with_zone.zones) > 10
    assert changed_problem(with_zone, [zone]).zones == with_zone.zones
    assert changed_problem(with_zone, gone=[zone]).zones == ()


def test_times_of_zones_count_from_the_new_start(problem):
    ended = Zone.circle(1000, 3500, 50, t1_s=90)
    active = Zone.circle(4000, 3500, 50, t0_s=60, t1_s=200)
    later = Zone.circle(5000, 3500, 50, t0_s=150)
    given = changed_problem(problem, [ended, active, later])
    new = Zone.circle(2000, 3500, 50, t0_s=10)
    changed = changed_problem(given, [new], (900, 600, 120), gone=[OLD], elapsed_s=100)
    assert [(zone.t0_s, zone.t1_s) for zone in changed.zones] == [
        (None, 100.0),
        (50.0, None),
        (10.0, None),
    ]
    for seconds in (-1, float("nan"), "x"):
        with pytest.raises(InputError, match="The seconds flown must be a number of 0 or more"):
            changed_problem(given, elapsed_s=seconds)
