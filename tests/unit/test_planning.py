"""Planning and checking, as in the command line and the Python API."""

import json
import subprocess
import sys

import numpy as np
import pytest

from pathgene.host.checking import check
from pathgene.host.errors import InputError
from pathgene.host.mission.plan import plan
from pathgene.host.planners import PLANNERS
from pathgene.host.planning import Search
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


HILLS = Terrain(
    "hills",
    300 + 100 * np.sin(np.arange(31) / 5)[:, None] * np.cos(np.arange(41) / 7)[None, :],
    100.0,
    100.0,
)
FOX = aircraft.load("silver-fox")
PROBLEM = Problem(HILLS, (300, 300, 500), (3700, 2700, 500), FOX, as_paper=True)


def test_plans_without_output(capsys):
    seen = []
    done = plan(PROBLEM, "ga-pc", generations=5, seed=3, progress=lambda *at: seen.append(list(at)))
    assert capsys.readouterr() == ("", "")
    assert seen == done.history
    assert [generation for generation, _, _ in seen] == [0, 1, 2, 3, 4, 5]
    assert done.result.stopped_by == "generations"
    assert done.evaluation == check(PROBLEM, done.path).evaluation
    assert (done.planner, done.board, done.seed) == ("ga-pc", None, 3)
    assert done.summary["terrain"]["source"] == "hills"
    assert done.summary["waypoints"] == done.path.tolist()
    again = plan(PROBLEM, "ga-pc", generations=5, seed=3)
    assert np.array_equal(again.path, done.path)


def test_default_planner_names_its_board():
    done = plan(PROBLEM, generations=2)
    assert (done.planner, done.board) == ("ga-chip", "model:")
    assert done.summary["hardware"]["generations"] == 2


def test_none_is_the_default_of_an_option():
    assert Search("ga-fpga", board=None, link_mode=None).board == "model:"
    assert Search("ga-pc").board is None
    assert Search("ga-pc", max_waypoints=None)._planner.max_waypoints == 20


def test_numbers_of_numpy_plan_the_same():
    done = plan(PROBLEM, seed=np.int64(3), generations=np.int32(2), chip_ms=np.int64(1))
    again = plan(PROBLEM, seed=3, generations=2, chip_ms=1)
    assert np.array_equal(done.path, again.path)
    assert json.dumps(done.summary["history"]) == json.dumps(again.summary["history"])


def test_cancelled_plan_has_the_best_so_far():
    seen = []
    done = plan(
        PROBLEM,
        "ga-pc",
        progress=lambda *at: seen.append(at),
        cancel=lambda: len(seen) > 3,
    )
    assert (done.result.stopped_by, done.result.generations) == ("interrupt", 3)
    assert done.result.archive[0][0] == seen[-1][1]


def test_generations_default_to_the_planners():
    assert Search("ga-pc").options.generations == 300
    assert Search("fpa").options.generations == 500


def test_saves_all_files(tmp_path):
    done = plan(PROBLEM, "ga-pc", generations=2)
    folder = tmp_path / "made" / "out"
    written = done.save(folder)
    assert [path.name for path in written] == [
        "summary.json",
        "terrain.npz",
        "path.geojson",
        "path.png",
    ]
    assert sorted(folder.iterdir()) == sorted(written)
    summary = json.loads((folder / "summary.json").read_text())
    assert list(summary.pop("files")) == ["terrain.npz", "path.geojson"]
    assert summary == done.summary
    # A stale picture of the last run is removed.
    assert [path.name for path in done.save(folder, picture=False)] == [
        "summary.json",
        "terrain.npz",
        "path.geojson",
    ]
    assert not (folder / "path.png").exists()


def test_check_reports_plain_numbers():
    path = [(300, 300, 500), (2000, 2000, 600), (3700, 2700, 500)]
    checked = check(PROBLEM, path, source={"source": "hills.npy"})
    assert checked.report["waypoints"] == [list(map(float, point)) for point in path]
    assert checked.report["fitness"] == checked.evaluation.fitness
    assert checked.report["terrain"]["source"] == "hills.npy"
    assert json.loads(json.dumps(checked.report, allow_nan=False)) == checked.report


@pytest.mark.parametrize(
    ("planner", "options", "message"),
    [
        (
            "ga-dp",
            {"board": "sim:"},
            "The planner ga-dp has no option 'board', only reading, draws, added_points, init.",
        ),
        (
            "a-star",
            {},
            "There is no planner 'a-star' (did you mean astar?); the planners are "
            f"{', '.join(PLANNERS)}.",
        ),
        (7, {}, f"There is no planner 7; the planners are {', '.join(PLANNERS)}."),
        ("ga-pc", {"generations": 0}, "The number of generations must be 1 or more, not 0."),
        (
            "ga-pc",
            {"max_waypoints": 4.5},
            "The option max_waypoints must be an integer, not 4.5.",
        ),
        ("ga-pc", {"init": ["astar"]}, "The option init must be random or astar, not ['astar']."),
        ("ga-fpga", {"board": ""}, "The option board must be a URL, not ''."),
        ("ga-fpga", {"board": 3}, "The option board must be a URL, not 3."),
    ],
)
def test_refuses_bad_options(planner, options, message):
    with pytest.raises(InputError) as caught:
        plan(PROBLEM, planner, **options)
    assert str(caught.value) == message


def test_refuses_a_path_with_other_ends():
    with pytest.raises(InputError, match=r"^Path must start at \(300\.0, 300\.0, 500\.0\), not "):
        check(PROBLEM, [(0, 0, 500), (3700, 2700, 500)])


@pytest.mark.parametrize(
    "path",
    [
        [(300, 300, 500), (3700, 2700, 500 + 1j)],
        np.array([(300, 300, 500), (3700, 2700, 500)], dtype=complex),
        [("300", "300", "500"), ("3700", "2700", "500")],
        "path.geojson",
        [(0, 0, 0), (1, 1)],
        [(0, 0, 10**400), (1, 1, 1)],
    ],
)
def test_refuses_a_path_that_is_no_grid_of_real_numbers(path):
    with pytest.raises(InputError) as caught:
        check(PROBLEM, path)
    assert str(caught.value) == "The path must be rows of three real numbers: x, y and altitude."


def test_a_problem_imports_nothing_heavy(tmp_path):
    HILLS.save_npz(tmp_path / "hills.npz", np.zeros(HILLS.shape, dtype=bool))
    script = """
import sys
import pathgene.host.evaluation, pathgene.host.planners.base, pathgene.host.planning
import pathgene.host.formats.geojson, pathgene.host.report.summary, pathgene.host.formats.csv
import pathgene.host.report.write
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.zones import Circle
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.aircraft import load as aircraft
from pathgene.host.terrain import load
problem = Problem(load(sys.argv[1]), (300, 300, 500), (3700, 2700, 500), aircraft("heron"))
assert problem.limits
heavy = ("numba", "scipy", "matplotlib", "rasterio", "amaranth", "serial")
print([name for name in heavy if name in sys.modules])
"""
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "hills.npz")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "[]\n"


def test_finds_matplotlibs_sample_without_importing_it():
    script = """
import sys
from pathgene.host.terrain import load
print(load("jacksboro").shape, "matplotlib" in sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout == "(414, 391) False\n"
