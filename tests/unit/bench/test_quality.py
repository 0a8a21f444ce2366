"""The entrants of the quality benchmark, and its statistics."""

import math

import pytest

from bench.__main__ import main
from bench.quality import VARIANTS, _compile, _gains, _means, _plan, _row, run
from bench.report import Options
from pathgene.host.errors import InputError
from pathgene.host.planners import PLANNERS, make


def test_every_planner_takes_part_from_every_start():
    assert {variant.planner for variant in VARIANTS} == set(PLANNERS)
    assert len({variant.name for variant in VARIANTS}) == len(VARIANTS)
    for name, entry in PLANNERS.items():
        inits = {
            variant.options.get("init")
            for variant in VARIANTS
            if variant.planner == name and "initial_draws" not in variant.options
        }
        assert inits == ({"random", "astar"} if "init" in entry.options else {None})
    for variant in VARIANTS:
        assert callable(make(variant.planner, **variant.options).plan)


def test_gains_are_paired_by_seed():
    fitness, yardstick = [1.50, 1.53, 1.52], [1.49, 1.50, 1.50]
    outcomes = [
        {"fitness": value, "feasible": value > 1.51, "evaluations": 10, "cpu_seconds": 2.0}
        for value in fitness
    ]
    feasible, mean, deviation, best, gain, p_value, evaluations, seconds = _row(outcomes, yardstick)
    assert (feasible, mean, best, gain) == ("2/3", "1.5167", "1.5300", "+0.0200")
    assert deviation == pytest.approx(math.sqrt(7 / 3) / 100)
    # Gains of 0.01, 0.03 and 0.02: t = 2 sqrt(3), with 2 degrees of freedom.
    t = 2 * math.sqrt(3)
    assert p_value == pytest.approx(1 - t / math.sqrt(2 + t * t))
    assert (evaluations, seconds) == (10, 2.0)
    assert _row(outcomes, fitness)[5] == "-"


def test_tables_of_all_planners_have_means_and_gains():
    def outcomes(*fitness, seconds):
        return [
            {"fitness": value, "feasible": value > 1, "evaluations": 1, "cpu_seconds": seconds}
            for value in fitness
        ]

    runs = {
        "canyon": {
            "astar": outcomes(1.5, 1.5, 1.5, seconds=1),
            "fpa": outcomes(1.2, 1.3, 0.5, seconds=3),
            "fpa from astar": outcomes(1.6, 1.61, 1.62, seconds=2),
        },
        "river": {
            "astar": outcomes(1.4, 1.4, 1.4, seconds=0.5),
            "fpa": outcomes(1.2, 1.2, 1.2, seconds=2),
            "fpa from astar": outcomes(1.4, 1.4, 1.5, seconds=2),
        },
    }
    means = _means(runs)
    assert means.columns == ("planner", "canyon", "river", "CPU seconds")
    assert means.rows == [
        ("astar", "1.5000", "1.4000", "0.5 to 1.0"),
        ("fpa", "1.0000 (2/3)", "1.2000", "2.0 to 3.0"),
        ("fpa from astar", "1.6100", "1.4333", "2.0 to 2.0"),
    ]
    assert _gains(runs).rows == [("fpa from astar", "+0.1100", "+0.0333 (p=0.42)")]


@pytest.mark.ci  # Plans twice.
def test_a_run_of_a_variant():
    astar = next(variant for variant in VARIANTS if variant.planner == "astar")
    _compile([astar])
    outcome = _plan("river", astar, seed=3)
    assert outcome["seed"] == 3
    assert outcome["feasible"]
    assert outcome["fitness"] > 1.5
    assert outcome["evaluations"] > 4
    assert 0 < outcome["cpu_seconds"] < 60


def test_refuses_an_unknown_name():
    with pytest.raises(InputError, match=r"^No planner of the benchmark has 'anneal' in its"):
        run(Options(only="anneal"))


def test_refuses_no_seeds(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["bench", "quality", "--seeds", "0"])
    assert main() == 2
    assert capsys.readouterr().err == "bench: --seeds must be 1 or more, not 0\n"
