"""Runs read back from their summaries, and data files that a summary knows by their digests."""

import hashlib
import json
import os

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.rules import Rules
from pathgene.host.report.read import find_summary, read_run
from pathgene.host.report.run_files import digests, verify
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import write_report


PLACE = {"crs": "EPSG:32617", "origin": (500000.0, 4100000.0)}


def save(folder, run, source=None):
    """Write the files of ``run`` and return its summary's path."""
    evaluator, result = run
    terrain = evaluator.problem.terrain
    summary = summarise(
        evaluator, result, planner="ga-pc", board=None, seed=1, source=source or terrain.loading
    )
    folder.mkdir(exist_ok=True)
    write_report(folder, evaluator, result, summary, warn=pytest.fail, picture=False)
    return folder / "summary.json"


def altered(file, **changes):
    file.write_text(json.dumps(json.loads(file.read_text()) | changes))
    return file


def test_gives_back_the_problem_and_the_path(make_run, tmp_path):
    evaluator, result = made = make_run(**PLACE)
    run = read_run(save(tmp_path, made))
    problem = evaluator.problem

    assert np.array_equal(run.path, result.path)
    assert run.summary["seed"] == 1
    for name in ("start", "goal", "aircraft", "zones", "wind", "ds_m", "rules"):
        assert getattr(run.problem, name) == getattr(problem, name), name
    assert np.array_equal(run.problem.terrain.elevation, problem.terrain.elevation)
    assert (run.problem.terrain.crs, run.problem.terrain.origin) == tuple(PLACE.values())
    assert Evaluator(run.problem, threads=1).evaluate(run.path) == result.evaluation


def test_loads_the_source_where_there_is_no_grid(make_run, tmp_path):
    file = save(tmp_path / "a", make_run())
    grid = file.with_name("terrain.npz")
    source = grid.rename(tmp_path / "elsewhere.npz")
    terrain = json.loads(file.read_text())["terrain"] | {"source": str(source)}
    run = read_run(altered(file, terrain=terrain))
    assert run.problem.terrain.loading["source"] == str(source)
    assert run.problem.terrain.crs is None


@pytest.mark.parametrize("source", [3, 10**400, [], {}])
def test_a_source_that_is_no_name_is_refused(make_run, tmp_path, source):
    file = save(tmp_path, make_run())
    file.with_name("terrain.npz").unlink()
    terrain = json.loads(file.read_text())["terrain"] | {"source": source}
    with pytest.raises(InputError, match=r"terrain\.npz, the terrain of the run, is missing, and"):
        read_run(altered(file, terrain=terrain))


def test_takes_the_default_aircraft_where_none_is_stated(make_run, tmp_path):
    file = save(tmp_path, make_run())
    summary = json.loads(file.read_text())
    del summary["uav"]
    file.write_text(json.dumps(summary))
    assert read_run(file).problem.aircraft.name == "Silver Fox-like"


def test_an_old_summary_is_as_paper(make_run, tmp_path):
    file = save(tmp_path, make_run())
    assert not read_run(file).problem.as_paper
    summary = json.loads(file.read_text())
    for key in ("as_paper", "rules", "start_heading_deg", "goal_heading_deg"):
        del summary[key]
    file.write_text(json.dumps(summary))
    assert read_run(file).problem.as_paper


def test_gives_back_rules_and_headings(make_run, tmp_path):
    rules = {"clearance_m": 50.0, "ceiling_m": 2000.0}
    file = altered(save(tmp_path, make_run()), rules=rules, goal_heading_deg=-90)
    problem = read_run(file).problem
    assert problem.rules == Rules(**rules)
    assert (problem.start_heading_deg, problem.goal_heading_deg) == (None, 270)


def test_a_path_is_no_summary(make_run, tmp_path):
    file = save(tmp_path, make_run())
    assert find_summary(file)["planner"] == "ga-pc"
    assert find_summary(file.with_name("path.geojson")) is None
    assert find_summary(tmp_path / "none.json") is None


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"waypoints": [[1, 2, 3]]},
            "waypoints must be two or more lists of three numbers.",
        ),
        (
            {"waypoints": [[1, 2, 3], [4, 5, 10**400]]},
            "waypoints must be two or more lists of three numbers.",
        ),
        (
            {"ds_m": 10**400},
            "the summary does not say how its path was evaluated; give --terrain and the other "
            "options.",
        ),
        ({"nofly": 3}, "nofly must be a list of zones, not 3."),
        ({"as_paper": 1}, "as_paper must be true or false, not 1."),
        (
            {"rules": {"height": 3}},
            "rules must be a table of the rules of safe flight, not {'height': 3}.",
        ),
        ({"uav": 3}, "uav must be a table of the aircraft's values."),
        ({"uav": None}, "uav must be a table of the aircraft's values."),
        (
            {"wind": []},
            "the summary does not say how its path was evaluated; give --terrain and the other "
            "options.",
        ),
        (
            {"wind": None},
            "the summary does not say how its path was evaluated; give --terrain and the other "
            "options.",
        ),
        (
            {"terrain": {}},
            "the summary does not say how its path was evaluated; give --terrain and the other "
            "options.",
        ),
        (
            {"terrain": {"cell_m": None, "crs": 3, "origin": [1, 2]}},
            "crs must be the name of a reference system and origin two numbers, not 3 and [1, 2].",
        ),
        (
            {"terrain": {"cell_m": None, "crs": "EPSG:32617", "origin": [1]}},
            "crs must be the name of a reference system and origin two numbers, not 'EPSG:32617' "
            "and [1].",
        ),
    ],
)
def test_refuses_a_bad_summary(make_run, tmp_path, changes, sentence):
    file = altered(save(tmp_path, make_run()), **changes)
    with pytest.raises(InputError) as refusal:
        read_run(file)
    assert str(refusal.value) == f"{file}: {sentence}"


def test_refuses_a_file_that_is_none(tmp_path):
    file = tmp_path / "path.csv"
    with pytest.raises(InputError) as refusal:
        read_run(file)
    assert str(refusal.value) == (
        f"Cannot read the summary {str(file)!r} (No such file or directory)."
    )
    file.write_text("x,y,z\n")
    with pytest.raises(InputError) as refusal:
        read_run(file)
    assert str(refusal.value) == (
        f"{file}: not a summary of a plan; give the summary.json that pathgene plan wrote."
    )


@pytest.fixture
def run(tmp_path):
    """Summary of a run with a grid and a path, and the function that writes a file next to it."""

    def write(name, content):
        (tmp_path / name).write_bytes(content)

    contents = {"terrain.npz": b"grid", "path.geojson": b"path"}
    for name, content in contents.items():
        write(name, content)
    return tmp_path / "summary.json", {"files": digests(contents)}, write


def test_digests_are_those_of_sha256():
    assert digests({"a": b"content"}) == {"a": hashlib.sha256(b"content").hexdigest()}


def test_accepts_what_belongs_to_the_run(run):
    file, summary, write = run
    verify(file, summary)
    write("path.png", b"pictures are drawn later")
    write("flight.json", b"of another command")
    file.with_name("path.geojson").unlink()  # Deleted on purpose.
    verify(file, summary)


@pytest.mark.parametrize("name", ["path.geojson", "terrain.npz", "path.plan", "path.kml"])
def test_names_a_file_that_is_altered_or_of_another_run(run, name):
    file, summary, write = run
    write(name, b"other")
    with pytest.raises(InputError) as caught:
        verify(file, summary)
    assert str(caught.value) == (
        f"{file.with_name(name)} is not the file that the run of {file} wrote, but altered or of "
        "another run; remove it, or plan again."
    )
    file.with_name(name).unlink()
    verify(file, summary)


def test_names_the_hidden_copy_of_a_missing_file(run):
    """A replacement that failed could not rename it back."""
    file, summary, write = run
    file.with_name("path.geojson").rename(file.with_name(".path.geojson.0123abcd"))
    with pytest.raises(InputError) as caught:
        verify(file, summary)
    assert str(caught.value) == (
        f"{file.with_name('path.geojson')} is missing, because a later run could not be written; "
        "it is kept as '.path.geojson.0123abcd': rename that to 'path.geojson', or plan again."
    )
    write(".path.geojson.0123abcd", b"of another run")
    verify(file, summary)


def test_a_summary_of_an_earlier_version_says_nothing(run):
    file, _, write = run
    write("path.kml", b"of another run")
    verify(file, {})


def test_what_is_no_regular_file_is_not_read(run):
    file, summary, _ = run
    os.mkfifo(file.with_name("path.kml"))
    file.with_name("path.plan").mkdir()
    verify(file, summary)


@pytest.mark.parametrize("files", [[], "a", {"a": 1}, {"../a": "0"}, {"/etc/passwd": "0"}])
def test_refuses_bad_tables(run, files):
    file, _, _ = run
    with pytest.raises(InputError) as caught:
        verify(file, {"files": files})
    assert str(caught.value) == (
        f"{file}: files must be a table of the SHA-256 of each file by its name."
    )
