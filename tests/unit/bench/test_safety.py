"""Rows and tables of the safety benchmark, and runs that end early and continue."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.report import Options
from bench.safety import CLEARANCES, Row, _report, rows, run
from bench.scenarios import names
from pathgene.host.errors import InputError
from pathgene.host.planners import PLANNERS
from tests.support.host.processes import Started


ROOT = Path(__file__).resolve().parents[3]


def test_rows_are_all_maps_planners_and_rules():
    every = rows()
    assert len(every) == (len(names()) + 2) * len(PLANNERS) * len(CLEARANCES)
    assert len({row.name for row in every}) == len(every)
    assert [row.name for row in rows("canyon astar")] == [
        "canyon astar paper mode",
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
    assert report.columns == ("terrain", "planner", "paper mode", "clearance 30 m")
    assert report.rows == [
        ("canyon", "fpa", "1.5500", "1.4000 (1/2)"),
        ("river", "fpa", "1.2000", "none"),
        ("river", "astar", "", "1.3000"),
    ]
    (seconds,) = report.further
    assert seconds.columns[-1] == "clearance 30 m, relative to paper mode"
    assert seconds.rows == [
        ("fpa", "2.00 to 4.00", "3.00 to 8.00", "1.75"),
        ("astar", "", "5.00 to 5.00", ""),
    ]
    assert seconds.text() in report.text()


def test_refuses_an_unknown_row():
    with pytest.raises(InputError, match=r"^No row has 'mars' in its name; one is 'canyon astar "):
        run(Options(only="mars"))


# The benchmark of a few rows with one seed, with results and page in a separate folder.
SCRIPT = """
import sys
from pathlib import Path
from bench import pages, safety
from bench.report import Options
if __name__ == "__main__":
    safety.STORE = Path("safety.json")
    pages.FIGURES, pages.PAGES = Path("figures"), Path()
    print(safety.run(Options(seeds=1, only="river astar")).text())
"""


@pytest.fixture
def start(tmp_path):
    """Start the benchmark."""
    (tmp_path / "safety.md").write_text(
        "<!-- tables of BENCH=safety -->\n<!-- end of BENCH=safety -->\n"
    )

    with contextlib.ExitStack() as blocks:
        yield lambda: blocks.enter_context(
            Started(
                [sys.executable, "-c", SCRIPT],
                cwd=tmp_path,
                env={**os.environ, "PYTHONPATH": str(ROOT)},
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        )


@pytest.mark.long  # Starts processes that compile.
def test_goes_on_where_it_was_interrupted_and_measures_stale_results_again(start, tmp_path):
    file = tmp_path / "safety.json"
    first = start()
    while not file.exists():
        assert first.poll() is None, first.communicate()
        time.sleep(0.01)
    first.send_signal(signal.SIGINT)
    first.communicate()
    assert first.returncode != 0
    before = json.loads(file.read_text())["river astar"]

    output, errors = start().communicate()
    assert f"safety: {4 - len(before)} of 4 rows to measure\n" in errors
    everything = json.loads(file.read_text())["river astar"]
    assert len(everything) == 4
    assert before.items() <= everything.items()
    assert "| river   | astar   | 1." in output
    tables = output.partition("## ")[2].replace("\n## ", "\n### ").strip()
    assert f"### {tables}" in (tmp_path / "safety.md").read_text()

    stale = everything["clearance 0 m"]
    changed = {**everything, "clearance 0 m": {**stale, "sources": "others"}}
    file.write_text(json.dumps({"river astar": changed}))
    output_again, errors = start().communicate()
    assert "safety: 1 of 4 rows to measure\n" in errors
    again = json.loads(file.read_text())["river astar"]
    measured = again.pop("clearance 0 m")
    assert again.items() <= everything.items()
    assert measured["sources"] == stale["sources"]
    assert [run["fitness"] for run in measured["outcomes"]] == [
        run["fitness"] for run in stale["outcomes"]
    ]
    assert output_again.partition("CPU")[0] == output.partition("CPU")[0]
