"""Missions of values: values that are missing or contradict, and the choices for zones."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.build import (
    load_problem,
    mission_of,
    options_for_flight,
    zone_choices_of,
    zones_of,
)
from pathgene.host.mission.problem_file import template
from pathgene.host.problem.active_times import LONGEST_S
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.problem.ends import place
from pathgene.host.problem.zones import Circle, ZoneOptions
from pathgene.host.remarks import Reading
from pathgene.host.terrain import Terrain


TERRAIN = Terrain("plain", np.full((41, 61), 50.0), 100.0, 100.0, "EPSG:32632", (4e5, 5.1e6))
START, GOAL = (500.0, 500.0, 150.0), (5500.0, 3500.0, 150.0)


def refusal(call, *arguments):
    with pytest.raises(InputError) as error:
        call(*arguments)
    return str(error.value)


def test_loads_the_mission_of_a_file(tmp_path):
    file = tmp_path / "problem.toml"
    file.write_text(template())
    assert load_problem(str(file)).problem.terrain.name == "canyon"
    assert refusal(load_problem, 3) == "The problem file must be the path of a file, not 3."


@pytest.mark.parametrize(
    ("values", "terrain", "sentence"),
    [
        (
            {},
            None,
            "The terrain is missing; give --terrain (jacksboro, canyon, river, large-canyon "
            "or a file).",
        ),
        (
            {"goal": GOAL},
            TERRAIN,
            "The start is missing; give --start or --start-geo.",
        ),
        (
            {"start": START},
            TERRAIN,
            "The goal is missing; give --goal or --goal-geo.",
        ),
        (
            {"start": START, "goal": GOAL, "as_paper": True, "start_heading": 90.0},
            TERRAIN,
            "--as-paper has no rules; leave out one of --as-paper and --start-heading.",
        ),
    ],
)
def test_refuses_values_that_are_missing_or_contradict(values, terrain, sentence):
    assert refusal(mission_of, values, terrain) == sentence


def test_ends_in_degrees_are_placed_on_the_terrain():
    start_geo = (46.06, 7.72, 150.0)
    mission = mission_of({"start_geo": start_geo, "goal": GOAL}, TERRAIN)
    assert mission.way == ((*place("start", *start_geo[:2], TERRAIN), 150.0), GOAL)


def test_circles_are_zones():
    assert zones_of({"nofly_circle": [(2000.0, 2000.0, 300.0)]}, TERRAIN) == (
        Circle(2000.0, 2000.0, 300.0),
    )


@pytest.mark.parametrize(("wind_m_s", "is_longest"), [(0.9, False), (1.0, True), (1.1, True)])
def test_a_flight_against_a_wind_as_fast_as_it_may_take_any_time(wind_m_s, is_longest):
    fox = load_aircraft("silver-fox")
    wind = (0.0, wind_m_s * fox.cruise_speed_m_s)
    options = options_for_flight(ZoneOptions(), TERRAIN, fox, None, wind)
    assert (options.longest_s == LONGEST_S) is is_longest


def test_choices_of_a_report_are_read_back():
    choices = {"forbid": "default,E", "qnh": 1000.0}
    assert zone_choices_of(Reading({"options": choices}, ())) == choices
    assert zone_choices_of(Reading()) == {}


@pytest.mark.parametrize("options", [{"qnh": "high"}, 3])
def test_refuses_a_report_with_other_choices(options):
    assert refusal(zone_choices_of, Reading({"options": options}, ())) == (
        "The options of read.zones in the summary must be a table of the options that zones are "
        "read with."
    )
