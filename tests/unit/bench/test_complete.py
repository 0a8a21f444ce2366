"""Planted problems: safe by construction, repeatable, and counted."""

import numpy as np
import pytest

from bench.complete import row, run
from bench.planted import CLAIMED, FAMILIES, TUNING, planted
from bench.report import Options
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator


@pytest.mark.parametrize("family", FAMILIES)
def test_the_strict_rule_accepts_each_planted_path(family):
    one, again, other = planted(family, 3), planted(family, 3), planted(family, 4)
    assert Evaluator(one.problem, threads=1).evaluate(one.path).feasible
    assert np.array_equal(one.path, again.path)
    assert not np.array_equal(one.path, other.path)


def test_claimed_seeds_are_not_used_for_tuning():
    assert not set(TUNING) & set(CLAIMED)
    assert len(FAMILIES) == 10


def test_counts_fallbacks_apart():
    def outcome(by_astar, by_chip, fallback, seconds, *, alone=False, guided=False):
        return {
            "astar": {"feasible": by_astar, "cpu_seconds": seconds},
            "ga-chip": {"feasible": by_chip, "fallback": fallback, "cpu_seconds": 2 * seconds}
            | {"alone": alone, "guided": guided},
        }

    outcomes = [
        outcome(True, True, None, 0.5, alone=True),
        outcome(True, True, None, 1.5, alone=True, guided=True),
        outcome(True, True, None, 1.0, guided=True),
        outcome(True, True, "astar", 2.0),
        outcome(False, True, "fpa-2opt", 3.0),
        outcome(False, False, None, 6.0),
    ]
    assert row(outcomes) == (4, 2, 1, 5, 2, 1, 14 / 6, 6.0, 28 / 6)


def test_refuses_an_unknown_family():
    with pytest.raises(InputError, match=r"^No family has 'moat' in its name; there are maze, gap"):
        run(Options(only="moat"))
