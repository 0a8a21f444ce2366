"""The benchmark of the evaluation: a problem of 40 km, and the tables of the rules."""

import math

import pytest

from bench import evaluation
from bench.evaluation import ENTRANTS, Timed, _ratios, clearance_table, long_problem, strict_table
from bench.quality import VARIANTS
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon


def mean_of(values):
    return sum(values) / len(values)


def test_the_long_problem_is_40_km_with_20_zones_apart():
    task = long_problem()
    assert math.dist(task.start[:2], task.goal[:2]) == pytest.approx(40e3, rel=0.01)
    assert task.rules == Rules()
    assert [type(zone) for zone in task.zones] == [Circle, Polygon] * 10
    middles = [
        (zone.x_m, zone.y_m)
        if isinstance(zone, Circle)
        else tuple(map(mean_of, zip(*zone.ring, strict=True)))
        for zone in task.zones
    ]
    radius_m = task.zones[0].radius_m
    assert min(math.dist(a, b) for a in middles for b in middles if a != b) > 2 * radius_m


def test_entrants_plan_from_both_starts():
    assert [variant.name for variant in ENTRANTS] == [
        "ga-fpga",
        "ga-pc",
        "ga-pc from astar",
        "astar",
        "fpa-2opt",
    ]


def test_cells_have_medians_of_ratios():
    pairs = [
        (Timed(1.0, 100), Timed(1.2, 100)),
        (Timed(2.0, 100), Timed(1.0, 150)),
        (Timed(1.0, 100), Timed(9.0, 160)),
    ]
    assert _ratios(pairs) == "1.20 (1.50)"
    assert _ratios(pairs[:1]) == "1.20"


@pytest.fixture
def astar_alone(monkeypatch):
    """Time one quick planner on one small map."""
    monkeypatch.setattr(evaluation, "ENTRANTS", [v for v in VARIANTS if v.name == "astar"])
    monkeypatch.setattr(evaluation, "_MAPS", ("river",))


@pytest.mark.ci  # Plans, and loads compiled kernels.
def test_tables_of_one_planner(astar_alone):
    (row,) = strict_table(repeats=3).rows
    planner, points, km, strict_ms, all_ms = row
    assert planner == "astar"
    assert points > 2
    assert 40 < km < 50
    assert 0 < strict_ms < all_ms

    report = clearance_table(rounds=1)
    (row,) = report.rows
    (pair,) = report.data["runs"]["astar"]["river"]
    cell = _ratios([pair])
    assert row == ("astar", cell, cell, f"{pair[1].seconds:.2f} to {pair[1].seconds:.2f}")
    assert report.columns[1:3] == ("river", "all maps")
