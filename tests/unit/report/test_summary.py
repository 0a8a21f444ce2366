"""The summary of a run."""

import json
import math

import pytest

from pathgene.host.report.summary import finite, summarise


# Scripts rely on these keys.
KEYS = {
    "pathgene",
    "planner",
    "board",
    "seed",
    "feasible",
    "feasible_at_ds",
    "fitness",
    "penalty",
    "cost",
    "length_m",
    "mean_altitude_m",
    "fuel_N",
    "distance_under_terrain_m",
    "distance_in_nofly_m",
    "distance_too_steep_m",
    "impossible_arcs",
    "minimum_clearance_m",
    "waypoints",
    "terrain",
    "uav",
    "nofly",
    "ds_m",
    "generations",
    "evaluations",
    "seconds",
    "hardware",
    "history",
    "history_evaluations",
}


def summary_of(make_run, **options):
    evaluator, result = make_run(**options)
    return (
        evaluator,
        result,
        summarise(
            evaluator,
            result,
            planner="ga-pc",
            board=None,
            seed=3,
            source={"source": "waves.npz", "fill_voids": False},
        ),
    )


def test_has_every_key(make_run):
    evaluator, result, summary = summary_of(make_run)
    assert set(summary) >= KEYS
    assert {"name", "shape", "dx_m", "dy_m", "crs", "origin"} <= set(summary["terrain"])
    assert {"total", "evaluation", "sort", "link", "board"} <= set(summary["seconds"])
    assert summary["waypoints"] == result.path.tolist()
    assert summary["fitness"] == evaluator.evaluate(result.path).fitness
    assert summary["nofly"][0] == {"x": 3000.0, "y": 2080.0, "radius_m": 280.0}
    assert list(summary["nofly"][1]) == ["polygon"]
    assert (summary["interrupted"], summary["stopped_by"]) == (False, "generations")
    assert len(summary["history_evaluations"]) == len(summary["history"])


def test_is_json_of_finite_numbers(make_run):
    *_, summary = summary_of(make_run, void=True)
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_reports_a_failure(make_run):
    *_, summary = summary_of(make_run, failure="The board is lost.")
    assert (summary["stopped_by"], summary["failure"]) == ("failure", "The board is lost.")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_values_unknown_to_json_become_null(value):
    assert finite({"a": [1.5, (value, 2)], "b": value, "c": "text"}) == {
        "a": [1.5, [None, 2]],
        "b": None,
        "c": "text",
    }
