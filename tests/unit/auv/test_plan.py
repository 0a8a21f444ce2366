"""Runs of both planners: the delta that a search reports is correct."""

import itertools

import pytest

from pathgene.host.auv.field import AuvField
from pathgene.host.auv.plan import REPORT_SAMPLES, describe, evolve, terms


def best(landscape, planner, seed, generations):
    field = AuvField(landscape)
    routes = [
        generation.best
        for generation in itertools.islice(evolve(field, planner, seed=seed), generations)
    ]
    return field, routes


def assert_true(landscape, planner, seed, generations):
    field, routes = best(landscape, planner, seed, generations)
    searched = terms(field, routes[-1])["delta"]
    paper = AuvField(landscape, samples=21)  # 1001 samples even in the parameter.
    for finer in (
        terms(field, routes[-1], REPORT_SAMPLES),
        terms(field, routes[-1], 20_001),
        terms(paper, routes[-1], REPORT_SAMPLES),
    ):
        assert finer["delta"] == pytest.approx(searched, rel=0.05)


@pytest.mark.parametrize("landscape", [1, 2])
@pytest.mark.parametrize("planner", ["ga-dp", "ga-auv"])
def test_delta_is_true_after_some_generations(landscape, planner):
    for seed in range(3):
        assert_true(landscape, planner, seed, 15)


@pytest.mark.long
@pytest.mark.parametrize("landscape", [1, 2])
@pytest.mark.parametrize("planner", ["ga-dp", "ga-auv"])
def test_delta_is_true_for_twenty_seeds(landscape, planner):
    for seed in range(20):
        assert_true(landscape, planner, seed, 100)


def test_summary_says_what_the_search_has_read():
    field, routes = best(2, "ga-dp", 1, 2)
    summary = describe(field, routes)
    segments = routes[-1].segments
    points, points_of, _ = field.points(segments.control, segments.counts)
    assert (summary["as_paper"], summary["samples"]) == (False, None)
    assert summary["segment_samples"] == points_of.tolist()
    assert sum(summary["segment_samples"]) == len(points) >= summary["path_length"] / 0.005
    paper = describe(AuvField(2, samples=21), routes)
    assert (paper["as_paper"], paper["samples"]) == (True, 21)
    assert paper["segment_samples"] == [21] * len(segments)
