"""A comparison in this process: its runs, files, report and progress."""

import functools
import io
import json

import pytest

from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.compare.report import document, write_report
from pathgene.host.compare.runs import Outcome, Task, execute, run_in_processes
from pathgene.host.compare.session import RunProgress, complete, kept
from pathgene.host.compare.store import RunStore
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, Entry, make


class Unlucky:
    """A registered planner that is ga-pc but fails with some seeds."""

    def plan(self, evaluator, options, progress=None, stop=None):
        if options.seed == 1:
            raise JobError("The board is lost.")
        if options.seed == 2:
            raise InputError("This planner cannot do that; take another.")
        if options.seed == 3:
            raise ZeroDivisionError("by zero")
        return make("ga-pc").plan(evaluator, options, progress, stop)


@pytest.fixture
def unlucky(monkeypatch):
    monkeypatch.setitem(
        PLANNERS,
        "unlucky",
        Entry(description="", paper="", generations=4, options=(), constructor=Unlucky),
    )
    return parse_entrants("ga-pc:generations=4,unlucky", {}, {})


def run(problem, entrants, seeds, directory):
    """Complete a comparison; return its fields and the tasks that ran."""
    done = []

    def recorded(tasks):
        done.extend((task.entrant.label, task.seed) for task in tasks)
        return run_in_processes(problem, tasks, 1)

    with RunStore(directory, "p") as store:
        fields = kept(store, entrants, seeds)
        complete(fields, seeds, store, recorded, io.StringIO())
    return fields, done


def test_runs_are_those_of_plan(problem, entrants, tmp_path):
    fields, done = run(problem, entrants, range(5, 7), tmp_path)
    # Planners alternate, so that they have run the same seeds at any time.
    assert done == [(entrant.label, seed) for seed in (5, 6) for entrant in entrants]
    for part in fields:
        assert sorted(part.records) == [5, 6]
        planner, options = part.entrant.make(), part.entrant.options
        result = planner.plan(Evaluator(problem), type(options)(generations=15, seed=6))
        assert part.records[6]["waypoints"] == result.path.tolist()
        assert part.records[6]["history"] == result.history
        assert part.records[6]["history_evaluations"] == result.history_evaluations


def test_runs_only_missing_runs(problem, entrants, tmp_path):
    _, done = run(problem, entrants[1:], range(2), tmp_path)
    assert len(done) == 2
    first, done = run(problem, entrants, range(1, 3), tmp_path)
    labels = [entrant.label for entrant in entrants]
    assert done == [(labels[0], 1), (labels[0], 2), (labels[1], 2)]
    again, done = run(problem, entrants, range(1, 3), tmp_path)
    assert done == []
    assert [part.records for part in again] == [part.records for part in first]


def test_a_failed_run_loses_no_other(problem, unlucky, tmp_path):
    fields, _ = run(problem, unlucky, range(5), tmp_path)
    good, bad = fields
    assert sorted(good.records) == list(range(5))
    assert sorted(bad.records) == [0, 4]
    failures = {
        seed: (outcome.failure, outcome.bad_input) for seed, outcome in bad.failures.items()
    }
    assert failures == {
        1: ("The board is lost.", False),
        2: ("This planner cannot do that; take another.", True),
        3: ("Internal error, ZeroDivisionError: by zero; please report it.", False),
    }
    # A failed run is tried again.
    _, done = run(problem, unlucky, range(5), tmp_path)
    assert done == [("unlucky", 1), ("unlucky", 2), ("unlucky", 3)]


def test_warms_up_before_the_first_run_of_a_planner(problem, monkeypatch):
    told = []

    class Told:
        def plan(self, evaluator, options, progress=None, stop=None):
            told.append((options.seed, options.generations, options.population))
            return make("ga-pc").plan(evaluator, options, progress, stop)

    monkeypatch.setitem(
        PLANNERS,
        "told",
        Entry(description="", paper="", generations=4, options=(), constructor=Told),
    )
    (entrant,) = parse_entrants("told:population=20", {}, {})
    outcomes = list(run_in_processes(problem, [Task(entrant, seed) for seed in (7, 8)], 1))
    assert told == [(7, 1, 20), (7, 4, 20), (8, 4, 20)]
    assert [outcome.record["generations"] for outcome in outcomes] == [4, 4]


def test_a_run_fails_under_another_version(problem, entrants):
    outcome = execute(Evaluator(problem, threads=1), Task(entrants[1], 0, pathgene="0.0.1"))
    assert outcome.record is None
    assert outcome.failure.endswith(" and 0.0.1.")


def test_report_is_complete_and_finite(problem, unlucky, tmp_path):
    fields, _ = run(problem, unlucky, range(4), tmp_path)
    report = document(problem, {"source": "hills"}, fields, range(4))
    assert json.loads(json.dumps(report, allow_nan=False)) == report
    assert report["terrain"]["name"] == "hills"
    assert (report["seeds"], report["paired"]) == ([0, 3], False)
    good, bad = report["planners"]
    assert [each["seed"] for each in good["runs"]] == [0, 1, 2, 3]
    assert bad["statistics"]["runs"] == 1
    assert bad["failures"][0] == {"seed": 1, "failure": "The board is lost."}
    assert good["options"]["generations"] == 4
    (pair,) = report["pairs"]
    assert pair["planners"] == ["ga-pc:generations=4", "unlucky"]
    assert pair["welch"] == {"statistic": None, "p": None, "note": "fewer than two runs"}


def test_writes_all_files(problem, entrants, tmp_path):
    fields, _ = run(problem, entrants, range(2), tmp_path)
    report = document(problem, {}, fields, range(2))
    written = write_report(tmp_path, report, warn=pytest.fail)
    assert [file.name for file in written] == ["compare.json", "compare.png"]
    assert json.loads(written[0].read_text()) == report


def test_a_failed_picture_loses_no_numbers(tmp_path):
    (tmp_path / "compare.png").write_text("of an earlier comparison")
    said = []
    written = write_report(tmp_path, {"planners": []}, warn=said.append)
    assert [file.name for file in written] == ["compare.json"]
    assert said[0].startswith("There is no picture this time, drawing it failed: ")
    assert not (tmp_path / "compare.png").exists()


def test_progress_has_runs_and_remaining_time(entrants):
    now = iter([0.0, 0.0, 10.0, 10.0, 20.0, 20.0, 80.0, 80.0])
    stream = io.StringIO()
    progress = RunProgress(stream, 9, 5, functools.partial(next, now))
    progress.begin()
    progress.update(Outcome(Task(entrants[0], 0), record={"fitness": 1.25}))
    progress.update(Outcome(Task(entrants[0], 1), failure="The board is lost."))
    progress.update(Outcome(Task(entrants[1], 0), record={"fitness": 1.2}))
    progress.close()
    assert stream.getvalue().splitlines() == [
        "run 5/9",
        "run 6/9  best 1.2500 by ga-fpga  0:00:30 left",
        "run 7/9  best 1.2500 by ga-fpga  1 failed  0:00:20 left",
        "run 8/9  best 1.2500 by ga-fpga  1 failed  0:00:27 left",
    ]


def test_a_terminal_has_one_time_left(entrants, monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True)
    progress = RunProgress(stream, 9, 5)
    progress.begin()
    progress.update(Outcome(Task(entrants[0], 0), record={"fitness": 1.25}))
    progress.close()
    assert {line.count(" left") for line in stream.getvalue().split("\r")} == {0, 1}
