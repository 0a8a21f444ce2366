"""Tables of the planner core, from a few short runs."""

import dataclasses

import pytest

from bench import campaign, chip, chip_ablation, chip_cycles, chip_replans, chip_runs
from bench.chip_runs import Outcome, share, through_terrains
from bench.report import Options
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.errors import InputError
from tests.support.host.pool import Pool


@pytest.fixture
def canyon_alone(monkeypatch):
    """Benchmarks of one map, with their runs in this process."""
    for module in (chip, chip_ablation, chip_cycles):
        monkeypatch.setattr(module, "terrains", lambda: ["canyon"])
        monkeypatch.setattr(
            module, "run_all", lambda tasks, _=None: [chip_runs._run(task) for task in tasks]
        )


def outcome(fitness, feasible=True):
    return Outcome(fitness, feasible, 10, 1000, 0.5)


def test_means_leave_out_what_is_not_feasible():
    by_terrain = [
        [outcome(1.5), outcome(1.4)],
        [outcome(0.1, False), outcome(0.2, False)],
        [outcome(1.3), outcome(0.9, False)],
    ]
    assert through_terrains(by_terrain) == (["1.4500", "none", "1.3000"], "1.3750")
    assert through_terrains([[outcome(0.1, False)]]) == (["none"], "none")
    assert share(by_terrain[0] + by_terrain[2]) == "3 of 4"


@pytest.mark.usefixtures("canyon_alone")
def test_a_row_of_the_ablation_is_a_run_of_each_clearance(monkeypatch):
    usual = RunOptions(cycles=1_000_000)
    short = {
        "none": usual,
        "no memo": dataclasses.replace(usual, memo=0),
        "one lane": chip_runs.CHIP.replace(lanes=1),
    }
    monkeypatch.setattr(chip_ablation, "CHANGES", short)
    monkeypatch.setattr(chip_ablation, "_USUAL", usual)
    report = chip_ablation.run(Options(seeds=1))
    usual, without, slow = report.rows
    assert [row[0] for row in report.rows] == ["none", "no memo", "one lane"]
    assert all(cell.endswith(" of 1") for cell in usual[2:7:2])
    # A generation takes longer, so that fewer end in time.
    for row in (without, slow):
        assert row[-1] > usual[-1]
        assert row[-2] < usual[-2]


@pytest.mark.usefixtures("canyon_alone")
def test_the_chip_is_beside_the_other_planners(monkeypatch):
    monkeypatch.setattr(chip, "TIMES_MS", (1, 2))
    monkeypatch.setattr(chip, "OTHERS", {"astar": chip.Other("astar", seeds=1)})
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", Pool)
    report = chip.run(Options(seeds=2, only="paper mode"))
    assert [row[0] for row in report.rows] == ["chip, 1 ms", "chip, 2 ms", "astar"]
    assert [row[3] for row in report.rows[:2]] == ["2 of 2", "2 of 2"]
    assert [float(row[4]) for row in report.rows[:2]] == pytest.approx([1, 2], abs=0.1)
    assert report.rows[2][3:5] == ("1 of 1", "-")
    assert [row[-1] for row in report.rows] == ["-", "-", "100 %"]
    cycles, race, shares = report.further
    [row] = cycles.rows
    assert row[0] == "canyon"
    _, breed, score, walk, _, wavefront, wait = row[2:9]
    assert 100 < breed < row[2]
    assert score > 0
    # Each number is rounded.
    assert walk + wavefront + wait == pytest.approx(row[2], abs=2)
    assert row[-1] > 1000
    assert [row[0] for row in race.rows] == ["canyon", "mean"]
    assert race.rows[0][1:] == race.rows[1][1:]
    assert shares.rows == [("19 of 20", "19 of 20 (95.0 %)")]


@pytest.mark.usefixtures("canyon_alone")
def test_a_point_every_cycle_makes_generations_shorter(monkeypatch):
    """The generations themselves are the same."""
    monkeypatch.setattr(chip_cycles, "_COUNTED_MS", 4)
    monkeypatch.setattr(chip_cycles, "_GENERATIONS", 50)
    report = chip_cycles.run(Options(seeds=1))
    assert [row[:2] for row in report.rows] == [(24, 2), (24, 1), (18, 2), (18, 1)]
    for two, one in (report.rows[:2], report.rows[2:]):
        assert one[2] < 0.8 * two[2]
        score = report.columns.index("score")
        assert one[score] < one[2]
        assert one[8] == two[8]


@pytest.mark.usefixtures("canyon_alone")
def test_untuned_ground_has_few_other_planners(monkeypatch):
    monkeypatch.setattr(chip, "TIMES_MS", (1,))
    monkeypatch.setattr(chip, "UNTUNED", ("river-102",))
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(chip, "_compile", lambda: None)
    report = chip.run(Options(seeds=1, only="untuned"))
    assert report.columns[1] == "river-102"
    assert [row[0] for row in report.rows] == ["chip, 1 ms", chip._POLISHED, "astar"]
    assert report.further == []


@pytest.mark.parametrize("bench", [chip, chip_ablation, chip_replans])
def test_unknown_rows_are_named(bench):
    with pytest.raises(InputError, match=r"^No (row|table) has '%' in its name; there are "):
        bench.run(dataclasses.replace(Options(), only="%"))
