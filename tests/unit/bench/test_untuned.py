"""Generated problems, repeatable, and the default planner beside its rivals on them."""

import importlib.util

import numpy as np
import pytest

from bench import untuned
from bench.generated import CLAIMED, KINDS, TUNING, generated
from bench.untuned import Outcome, table
from pathgene.host.evaluation import Evaluator


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_gives_the_same_problem_again(kind):
    one, again, other = (generated(kind, seed) for seed in (3, 3, 4))
    assert np.array_equal(one.terrain.elevation, again.terrain.elevation)
    assert (one.start, one.goal, one.zones) == (again.start, again.goal, again.zones)
    assert (one.start, one.goal) != (other.start, other.goal)
    assert one.zones
    assert one.rules is None
    with_rules = generated(kind, 3, 30.0)
    assert with_rules.rules.clearance_m == 30.0


def test_claimed_seeds_are_not_used_for_tuning():
    assert len(CLAIMED) == len(TUNING) == 25
    assert not set(TUNING) & set(CLAIMED)
    assert len(KINDS) == 4


def outcome(astar, chip, peers, route="chip"):
    fitness = {"astar": astar, "ga-chip": chip, "peers": peers}
    return Outcome(fitness | dict.fromkeys(list(untuned.VARIANTS)[2:], chip), route, 2.0)


def test_a_table_counts_what_is_below():
    kinds = {
        "fractal": [outcome(1.5, 1.51, 1.52), outcome(1.5, 1.49995, 1.49, "astar")],
        "canyon": [outcome(1.5, 1.4, None), outcome(1.3, None, 1.2, None)],
    }
    report = table("paper mode", kinds, True)
    rows = [dict(zip(report.columns, row, strict=True)) for row in report.rows]
    assert [row["kind"] for row in rows] == ["fractal", "canyon", "all"]
    fractal, canyon, every = rows
    assert (fractal["problems"], fractal["astar"], fractal["peers"]) == (2, "1.5000", "1.5050")
    # A difference of 0.00005 is none.
    assert [row["below astar"] for row in rows] == [0, 2, 2]
    assert [row["below peers"] for row in rows] == [1, 1, 2]
    # -0.01 and -0.00005 over the better rival, and -0.1.
    assert (fractal["gain over the best"], canyon["gain over the best"]) == ("-0.0050", "-0.1000")
    assert [row["not feasible"] for row in rows] == [0, 1, 1]
    assert [row["route of astar"] for row in rows] == [1, 0, 1]
    # No problem of this kind is solved by all.
    assert canyon["astar"] == "-"
    assert every["CPU s"] == "2.00"
    alone = table("paper mode", kinds, False)
    assert "peers" not in alone.columns
    assert alone.rows[0][alone.columns.index("gain over astar")] == "+0.0050"


def test_plans_by_all_variants():
    found = untuned.plan(("islands", 3, None), False, generations=30)
    assert list(found.fitness) == list(untuned.VARIANTS)
    assert found.fitness["ga-chip"] >= found.fitness["astar"] > 1
    assert found.route_from in ("chip", "astar")
    assert found.seconds > 0


@pytest.mark.skipif(importlib.util.find_spec("ompl") is None, reason="ompl is of the extra 'peers'")
def test_a_peer_has_the_best_of_its_paths():
    evaluator = Evaluator(generated("islands", TUNING[1]), threads=1)
    assert untuned.peer(evaluator, "AORRTC", 0.05) > 1
    assert untuned.peer(evaluator, "AORRTC", 0.0) is None
