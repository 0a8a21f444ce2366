"""A limit of the aircraft needs only one class in one list."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from pathgene.host.diagnosis import diagnose
from pathgene.host.diagnosis.reason import broken_limit
from pathgene.host.evaluation import Evaluator, broken
from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.aircraft_limits import (
    AIRCRAFT_LIMITS,
    AircraftLimit,
    Worst,
    limit_named,
    unit_of,
)
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.report import profile
from pathgene.host.report.along import why
from pathgene.host.terrain import Terrain
from pathgene.host.web.scene import ceilings_scene, path_scene


LOWEST_M = 150.0


class MinimumAltitude(AircraftLimit):
    """An altitude below which the aircraft must not fly."""

    name, unit, is_minimum = "minimum-altitude", "m", True

    def altitude_m(self, problem):
        return LOWEST_M

    def worst(self, problem, track):
        ends = track.pieces[: track.rows, fields.Z].copy()
        ends[track.pieces[: track.rows, fields.LENGTH] <= 0] = math.inf
        row = int(np.argmin(ends))
        return Worst(float(ends[row]), LOWEST_M, track.flown_m(row, 0.0))

    def stretches(self, problem, track):
        above = [(0.0, 0.0), *sorted(broken.above(track, LOWEST_M)), (track.length_m,) * 2]
        for (_, start), (stop, _) in itertools.pairwise(above):
            if stop > start + 1e-6:
                yield start, stop


@pytest.fixture
def added():
    """The limit, which is in the list while the test runs."""
    limit = MinimumAltitude()
    AIRCRAFT_LIMITS.append(limit)
    yield limit
    AIRCRAFT_LIMITS.remove(limit)


def problem(start_m=200.0):
    terrain = Terrain("flat", np.zeros((60, 60)), 50.0, 50.0)
    return Problem(terrain, (500.0, 1500.0, start_m), (2500.0, 1500.0, 200.0))


def dip(lowest_m):
    return np.array([[500, 1500, 200], [1500, 1500, lowest_m], [2500, 1500, 200]], np.float64)


def test_a_limit_that_is_added_is_judged_explained_and_shown(added):
    evaluator = Evaluator(problem())
    kept, low = evaluator.evaluate(dip(160.0)), evaluator.evaluate(dip(100.0))
    # The verdict, and the search of one path among several.
    assert kept.feasible
    assert kept.penalty == 0
    assert not low.feasible
    share = (LOWEST_M - 100) / (200 - 100)
    assert low.distance_beyond_limits_m == pytest.approx(share * 2000, rel=0.05)
    paths, lengths = np.array([dip(100.0), dip(160.0)]), np.array([3, 3])
    penalty, _ = evaluator.penalty_cost(paths, lengths, fine=True)
    assert penalty.tolist() == [low.penalty, 0.0]
    assert evaluator.first_feasible(paths, lengths) == 1
    assert evaluator.first_feasible(paths[:1], lengths[:1]) is None
    # The summary's limits, its sentence and its unit.
    worst = low.limits[0]
    assert (worst["limit"], worst["allowed"]) == ("minimum-altitude", LOWEST_M)
    assert worst["worst"] == pytest.approx(100, abs=1)
    assert worst["at_m"] == pytest.approx(1000, abs=60)
    assert broken_limit(low.limits).startswith("breaks the limit minimum-altitude, 100 where 150 ")
    assert unit_of("minimum-altitude") == "m"
    # The picture and the page.
    (stretch,) = evaluator.broken(dip(100.0))
    assert stretch.limit == "minimum-altitude"
    ground = np.zeros(4)
    ((label, line),) = profile._ceilings(problem(), ground)
    assert label == "minimum altitude 150 m"
    assert line.tolist() == [LOWEST_M] * 4
    assert ceilings_scene(problem()) == [
        {"name": "minimum altitude", "altitude_m": LOWEST_M, "agl": False}
    ]
    scene = path_scene(evaluator, dip(100.0), "path")
    assert [each["limit"] for each in scene["track"]["broken"]] == ["minimum-altitude"]
    assert "minimum-altitude" in why({}, low.limits)


def test_a_limit_that_is_added_is_a_reason_at_an_end(added):
    reason = diagnose(problem(start_m=120.0))
    assert reason.proven
    assert reason.sentence == (
        "The start at 120.0 m is 30.0 m below the minimum altitude of Silver Fox-like, 150.0 m."
    )
    assert (reason.figure.limit, reason.figure.would_do) == ("minimum-altitude", 120.0)


def test_without_it_the_path_is_feasible():
    evaluator = Evaluator(problem())
    assert evaluator.evaluate(dip(100.0)).feasible
    assert evaluator.broken(dip(100.0)) == []


def test_a_limit_without_its_figure_is_not_listed():
    figures = ("engine_power_W", "fuel_weight_N", "lift_coefficient_max", "service_ceiling_m")
    bare = dataclasses.replace(load("silver-fox"), **dict.fromkeys(figures))
    full = dataclasses.replace(bare, **dict.fromkeys(figures, 10.0))
    names = []
    for aircraft in (bare, full):
        flown = dataclasses.replace(problem(), aircraft=aircraft, start_heading_deg=45.0)
        limits = Evaluator(flown).evaluate(dip(160.0)).limits
        names.append({limit["limit"] for limit in limits})
    assert names[1] - names[0] == {"power", "fuel", "stall", "service-ceiling"}


def test_every_limit_has_a_name_and_a_unit_of_its_own():
    names = [limit.name for limit in AIRCRAFT_LIMITS]
    assert len(set(names)) == len(names)
    for limit in AIRCRAFT_LIMITS:
        assert limit_named(limit.name) is limit
        assert unit_of(limit.name) == limit.unit
    assert limit_named("zone lake") is None
    assert unit_of("clearance") == "m"
