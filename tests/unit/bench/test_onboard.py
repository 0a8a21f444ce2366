"""The benchmark of collisions counted on the board, at a small size."""

import pytest

from bench import onboard
from bench.report import Options
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.allaire.counting import CAUSES


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


def test_judges_every_path_counted_feasible(monkeypatch):
    monkeypatch.setattr(onboard, "names", lambda: ["canyon"])
    monkeypatch.setattr(onboard, "_SIMULATED", 0)
    monkeypatch.setattr(onboard, "_GENERATIONS", 15)
    report = onboard.run(Options(seeds=2))
    ((title, _, host_f, _, board_f, claimed, *refuted, reported, saved, cells),) = report.rows
    assert title == "canyon, on model:"
    assert 0 < host_f < 2
    assert 0 < board_f < 2
    assert claimed >= sum(refuted)
    assert claimed > 10
    assert len(refuted) == len(CAUSES)
    assert 0 <= reported <= 2
    assert saved > 1000
    assert cells > 1000
    runs = report.data["runs"]["canyon model:"]
    assert [run["seed"] for run in runs["board"]] == [0, 1]
    assert sum(run["claimed"] for run in runs["board"]) == claimed


def test_records_the_paths_counted_feasible(monkeypatch):
    """The record matches a plan whose candidates the test evaluates itself."""
    monkeypatch.setattr(onboard, "_GENERATIONS", 5)
    counted = {}
    fitness_counted = Evaluator.fitness_counted

    def spy(self, paths, lengths, counted_m):
        fitness = fitness_counted(self, paths, lengths, counted_m)
        counted.update(
            {
                path[:length].tobytes(): worth
                for path, length, worth in zip(paths, lengths, fitness, strict=True)
            }
        )
        return fitness

    monkeypatch.setattr(Evaluator, "fitness_counted", spy)
    (outcome,) = onboard._plans("canyon", "model:", "board", [3])
    assert outcome["claimed"] == sum(worth > 1 for worth in counted.values())
    assert outcome["hardware"]["feasibility"]["counted_on_board"] >= len(counted)
