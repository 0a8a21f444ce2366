"""Rows and tables of the benchmark of safety, and runs that end early and go on."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.report import Options
from bench.safety import BEGIN, CLEARANCES, END, PAGE, Row, _report, paste, rows, run
from bench.scenarios import names
from host.errors import InputError
from host.planners import PLANNERS


ROOT = Path(__file__).resolve().parents[3]


def test_rows_are_all_maps_planners_and_rules():
    every = rows()
    assert len(every) == (len(names()) + 2) * len(PLANNERS) * len(CLEARANCES)
    assert len({row.name for row in every}) == len({row.file for row in every}) == len(every)
    assert [row.name for row in rows("canyon astar")] == [
        "canyon astar as paper",
        "canyon astar clearance 0 m",
        "canyon astar clearance 30 m",
        "canyon astar clearance 100 m",
    ]


def test_problems_differ_in_their_rules_alone():
    paper, without, _, wide = (row.problem() for row in rows("river astar"))
    assert paper.as_paper
    assert [without.rules.clearance_m, wide.rules.clearance_m] == [0, 100]
    assert without.rules.corridor_m == wide.rules.corridor_m == 25
    assert paper.zones == wide.zones
    assert (paper.start, paper.goal, paper.ds_m) == (wide.start, wide.goal, wide.ds_m)


def outcomes(*fitness, seconds):
    """Return outcomes of the seeds; paths with F below 1 are not feasible."""
    return [
        {"fitness": value, "feasible": value > 1, "cpu_seconds": passed}
        for value, passed in zip(fitness, seconds, strict=True)
    ]


def test_tables_have_means_of_feasible_paths_and_ratios_of_seconds():
    report = _report(
        {
            Row("canyon", "fpa", None): outcomes(1.5, 1.6, seconds=(1, 3)),
            Row("canyon", "fpa", 30.0): outcomes(1.4, 0.2, seconds=(3, 3)),
            Row("river", "fpa", None): outcomes(1.2, 1.2, seconds=(4, 4)),
            Row("river", "fpa", 30.0): outcomes(0.3, 0.1, seconds=(8, 8)),
            Row("river", "astar", 30.0): outcomes(1.3, 1.3, seconds=(5, 5)),
        }
    )
    assert report.columns == ("terrain", "planner", "as paper", "clearance 30 m")
    assert report.rows == [
        ("canyon", "fpa", "1.5500", "1.4000 (1/2)"),
        ("river", "fpa", "1.2000", "none"),
        ("river", "astar", "", "1.3000"),
    ]
    (seconds,) = report.further
    assert seconds.columns[-1] == "clearance 30 m, times as paper"
    assert seconds.rows == [
        ("fpa", "2.00 to 4.00", "3.00 to 8.00", "1.75"),
        ("astar", "", "5.00 to 5.00", ""),
    ]
    assert seconds.text() in report.text()


def test_tables_are_pasted_between_their_lines(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"# Title\n\n{BEGIN}\n\nold\n\n{END}\n\nLimits\n")
    for tables in ("| a |", "| b |"):
        paste(page, tables)
        assert page.read_text() == f"# Title\n\n{BEGIN}\n\n{tables}\n\n{END}\n\nLimits\n"
    page.write_text(f"{END}\n{BEGIN}\n")
    with pytest.raises(InputError, match=r"^page.md has no place for the tables: the lines <!-- "):
        paste(page, "| a |")
    assert page.read_text() == f"{END}\n{BEGIN}\n"


def test_the_page_has_a_place_for_the_tables(tmp_path):
    copy = tmp_path / "safety.md"
    copy.write_text(PAGE.read_text("utf-8"))
    paste(copy, "| a |")
    assert f"{BEGIN}\n\n| a |\n\n{END}\n" in copy.read_text("utf-8")


def test_refuses_an_unknown_row():
    with pytest.raises(InputError, match=r"^No row has 'mars' in its name; one is 'canyon astar "):
        run(Options(only="mars"))


@pytest.fixture
def bench(tmp_path):
    """Start the benchmark on few rows of one seed, in a folder of its own."""
    command = [sys.executable, "-m", "bench", "safety", "--seeds", "1", "--only"]

    def start(only):
        return subprocess.Popen(
            [*command, only],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return start


def kept(folder):
    """Return the files of measured rows with the times at which they were written."""
    return {file: file.stat().st_mtime_ns for file in folder.glob("build/bench/safety-runs/*.json")}


@pytest.mark.ci  # Starts processes that compile.
def test_goes_on_where_it_was_interrupted_and_discards_stale_results(bench, tmp_path):
    first = bench("river astar")
    while not kept(tmp_path):
        assert first.poll() is None, first.communicate()
        time.sleep(0.01)
    first.send_signal(signal.SIGINT)
    first.communicate()
    assert first.returncode != 0
    before = kept(tmp_path)

    output, errors = bench("river astar").communicate()
    assert f"safety: {4 - len(before)} of 4 rows to measure\n" in errors
    assert before.items() <= kept(tmp_path).items()
    assert "| river   | astar   | 1." in output

    stale, *others = kept(tmp_path).items()
    content = json.loads(stale[0].read_text())
    stale[0].write_text(json.dumps(content | {"sources": "others", "outcomes": []}))
    output_again, errors = bench("river astar").communicate()
    assert "safety: 1 of 4 rows to measure\n" in errors
    assert dict(others).items() < kept(tmp_path).items()
    measured = json.loads(stale[0].read_text())
    assert measured["sources"] == content["sources"]
    assert [run["fitness"] for run in measured["outcomes"]] == [
        run["fitness"] for run in content["outcomes"]
    ]
    assert output_again.partition("CPU")[0] == output.partition("CPU")[0]
