"""Verdicts on invented flights."""

import dataclasses
import math
import re

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.flight.flight import Flown, limits_of
from pathgene.host.flight.ground import demanded_m, known_surface_m
from pathgene.host.flight.judge import entered, judge
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.surface import Demand
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain, surface
from tests.support.host.flight_oracle import known_surface


FOX = aircraft.load("silver-fox")
HILL = np.zeros((41, 101))
HILL[:, 50] = 100.0
TERRAIN = Terrain("ridge", HILL, 100, 100)
ENDS = (1000.0, 2000.0, 200.0), (9000.0, 2000.0, 200.0)


def problem(zones=(), **options):
    return Problem(TERRAIN, *ENDS, FOX, zones, **options)


def flight(z=200.0, y=2000.0, **values):
    """Level flight from west to east."""
    x = np.arange(1000.0, 9000.0, 0.77)
    k = len(x)
    table = {field.name: np.zeros(k) for field in dataclasses.fields(Flown)}
    table |= {
        "t_s": np.arange(k) / 30, "x": x, "y": np.full(k, y), "z": np.full(k, z),
        "along_m": x - 1000, "airspeed_m_s": np.full(k, 23.0), "arrived": True,
        "interrupted": False,
    }  # fmt: skip
    return Flown(**(table | values))


def verdict(flown, zones=(), **options):
    task = problem(zones, **options)
    track = Evaluator(task).track(np.array(ENDS))
    return judge(task, track, flown, FOX)


def test_flight_with_its_clearance_is_kept():
    report = verdict(flight(140.0))
    assert report.kept
    assert report.clearance_asked_m == 30
    assert report.clearance_planned_m == pytest.approx(100, abs=0.01)
    assert report.clearance_flown_m == pytest.approx(40, abs=0.01)
    assert report.clearance_share == pytest.approx(4 / 3, abs=0.01)
    assert report.lowest_at_m[0] == pytest.approx(5000, abs=60)


@pytest.mark.parametrize(
    ("z", "sentence"),
    [
        (114.0, r"^The flight keeps 14\.0 m of a clearance of 30\.0 m at \(49\d\d, 2000\)\.$"),
        (99.0, r"^The flight is 1\.0 m under the ground at \(49\d\d, 2000\)\.$"),
    ],
)
def test_flight_too_low_is_not(z, sentence):
    report = verdict(flight(z))
    assert not report.kept
    assert len(report.breaks) == 1
    assert re.match(sentence, report.breaks[0])


def test_as_paper_asks_for_the_ground_alone():
    assert verdict(flight(101.0), as_paper=True).kept
    assert not verdict(flight(99.0), as_paper=True).kept


def test_less_is_demanded_near_the_ends():
    low = Problem(TERRAIN, (1000, 2000, 2), (9000, 2000, 200), FOX, rules=Rules(clearance_m=50))
    x = np.array([1000.0, 1100.0, 2000.0, 5000.0])
    rise = 0.5 * math.tan(math.radians(10))
    assert demanded_m(low, x, np.full(4, 2000.0)) == pytest.approx([2, 2 + 100 * rise, 50, 50])


def test_the_ground_is_that_of_the_definition():
    rng = np.random.default_rng(5)
    heights = rng.uniform(0, 500, (9, 12))
    heights[4, 5] = heights[0, 11] = np.nan
    terrain = Terrain("rough", heights, 30.0, 40.0)
    # Nodes, middles between nodes, edges, and places beyond them.
    x, y = (each.ravel() for each in np.meshgrid(np.arange(-30, 375, 7.5), np.arange(-40, 370, 5)))
    x, y = np.append(x, rng.uniform(-50, 400, 900)), np.append(y, rng.uniform(-50, 400, 900))
    expected = known_surface(terrain, x, y)
    found = known_surface_m(terrain, x, y)
    assert np.array_equal(np.isnan(found), np.isinf(expected))
    assert np.isnan(found).sum() > 1000
    known = ~np.isnan(found)
    assert found[known] == pytest.approx(expected[known], abs=1e-9)


def test_a_flight_off_the_map_is_over_unknown_ground():
    """The height of the edge does not excuse it."""
    report = verdict(flight(140.0, y=4000.5))
    assert report.breaks == [
        "The flight leaves the map at (1000, 4000), where the ground is unknown."
    ]
    assert math.isnan(report.clearance_flown_m)
    assert verdict(flight(140.0, y=4000.0)).kept


def test_a_fault_of_the_rules_does_not_excuse_a_flight(monkeypatch):
    monkeypatch.setattr(
        surface, "surface_below", lambda terrain, x, *_, **__: np.full(x.shape, -99.0)
    )
    monkeypatch.setattr(Demand, "required_m", lambda self, x, *_, **__: np.zeros_like(x))
    assert re.match(r"^The flight keeps 14\.0 m of a clearance", verdict(flight(114.0)).breaks[0])


ZONE = {"lower_m": 150.0, "upper_m": 250.0}


@pytest.mark.parametrize(
    ("zone", "inside"),
    [
        (Circle(5000, 2050, 60), True),
        (Circle(5000, 2050, 49), False),
        (Circle(5000, 2000, 500, **ZONE), True),
        (Circle(5000, 2000, 500, lower_m=201), False),
        (Circle(5000, 2000, 500, upper_m=199), False),
        (Circle(5000, 2000, 500, t0_s=100, t1_s=200), True),
        (Circle(5000, 2000, 500, t1_s=100), False),
        (Polygon(((4000, 1900), (6000, 1900), (5000, 2100))), True),
        (
            Polygon(
                ((0, 1900), (9900, 1900), (9900, 2100), (0, 2100)),
                (((500, 1950), (9500, 1950), (9500, 2050), (500, 2050)),),
            ),
            False,
        ),
    ],
)
def test_zones_as_flown(zone, inside):
    assert entered(zone, flight()).any() == inside


def test_entered_zones_are_named():
    zones = [Circle(3000, 3000, 50), Circle(5000, 2050, 60, name="school")]
    report = verdict(flight(), zones)
    assert report.breaks == ["The flight enters the no-fly zone 'school'."]
    assert report.zones_entered == ["school"]


def test_lost_flights_and_voids_break():
    holed = HILL.copy()
    holed[20, 30] = np.nan
    task = Problem(Terrain("holed", holed, 100, 100), *ENDS, FOX)
    report = judge(task, Evaluator(task).track(np.array(ENDS)), flight(arrived=False), FOX)
    assert report.breaks == [
        "The aircraft did not reach the goal.",
        "The flight crosses a void of the terrain.",
    ]


def test_interrupted_flights_are_not_kept():
    report = verdict(flight(arrived=False, interrupted=True))
    assert (report.interrupted, report.kept) == (True, False)
    assert report.breaks == ["The flight was interrupted before it reached the goal."]


def test_limits_are_means_of_five_seconds():
    most = limits_of(FOX).bank_rad / 1.05
    banks = np.zeros(len(flight().x))
    banks[1000:1075] = 2 * most  # 2.5 s.
    report = verdict(flight(bank_command_rad=banks))
    worst = report.limits[0]
    assert (worst["limit"], worst["excess"]) == ("bank", pytest.approx(0, abs=1e-9))
    banks[1000:1150] = 1.1 * most
    assert verdict(flight(bank_command_rad=banks)).excess == pytest.approx(0.1)
    assert {row["limit"] for row in report.limits} == {"bank", "climb", "descent", "power"}
