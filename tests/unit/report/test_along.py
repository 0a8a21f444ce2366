"""Facts along a track near the edge of the map."""

import math

import numpy as np
import pytest

from pathgene.host.diagnosis.reason import broken_limit
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.report.along import surface_and_demand, why
from pathgene.host.report.summary import terms
from pathgene.host.terrain import Terrain


def flown(away_m, **rules):
    """Return evaluator and path of a level flight along the south edge of flat land."""
    flat = Terrain("flat", np.full((34, 34), 10.0), 30.0, 30.0)
    ends = (45.0, away_m, 90.0), (945.0, away_m, 90.0)
    return Evaluator(Problem(flat, *ends, rules=Rules(**rules)), threads=1), np.array(ends)


@pytest.mark.parametrize(
    ("away_m", "corridor_m", "is_known"), [(25, 25, True), (20, 25, False), (0, 0, True)]
)
def test_the_ground_beside_a_track_is_unknown_beyond_the_edge(away_m, corridor_m, is_known):
    evaluator, path = flown(away_m, corridor_m=corridor_m)
    below, highest, required = surface_and_demand(
        evaluator.problem, evaluator.track(path).sample(10.0)
    )
    assert (below == 10).all()
    assert np.isfinite(highest).all() == np.isfinite(required).all() == is_known
    assert np.isnan(highest).all() == np.isnan(required).all() == (not is_known)


def test_the_reason_names_the_corridor():
    evaluator, path = flown(20)
    limits = terms(evaluator.evaluate(path))["limits"]
    assert why({}, limits) == ("Not feasible: the corridor leaves the map by 5.0 m, after 0.01 km")
    assert math.isclose(limits[0]["worst"], -5, abs_tol=1e-5)


def test_a_clearance_over_a_void_is_named_in_evaluation_and_summary():
    heights = np.full((34, 34), 10.0)
    heights[:, 16] = np.nan
    ends = (45.0, 500.0, 90.0), (945.0, 500.0, 90.0)
    problem = Problem(Terrain("void", heights, 30.0, 30.0), *ends)
    evaluation = Evaluator(problem, threads=1).evaluate(np.array(ends))
    sentence = why({}, evaluation.limits)
    assert sentence.startswith("Not feasible: clearance is unknown over a void, after 0.4")
    assert why({}, terms(evaluation)["limits"]) == sentence
    broken = broken_limit(evaluation.limits)
    assert broken.startswith("breaks the limit clearance over a void, 4")
    assert broken_limit(terms(evaluation)["limits"]) == broken
