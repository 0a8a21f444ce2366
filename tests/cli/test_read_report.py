"""The report on zones that were read, at every command that reads them."""

import json

import pytest

from pathgene.host.cli import main
from tests.cli.conftest import ENDS, run_here


LOW = 'Warning: zones.geojson: feature 2, "low" forbids nothing: its upper limit is under the'
WIRE = 'Note: zones.geojson: feature 3, "wire" left out: a LineString is not an area.'
CIRCLE = "Warning: Zone 3 forbids nothing: it lies off the map."


@pytest.fixture(scope="module")
def planned(hills, tmp_path_factory):
    """A folder with a file of zones and with a plan past them, and the plan's notes."""
    folder = tmp_path_factory.mktemp("read")
    ring = [[600, 2600], [1200, 2600], [1200, 3200], [600, 2600]]
    shapes = {
        "R-7": ({"type": "Polygon", "coordinates": [ring]}, {"upper": "120 m AGL"}),
        "low": ({"type": "Polygon", "coordinates": [ring]}, {"upper": 20}),
        "wire": ({"type": "LineString", "coordinates": ring[:2]}, {}),
    }
    features = [
        {"type": "Feature", "properties": {"name": name, **own}, "geometry": shape}
        for name, (shape, own) in shapes.items()
    ]
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    (folder / "zones.geojson").write_text(json.dumps(document))
    own = ("--planner", "astar", "--no-picture", "--origin", "47,8", "--out", folder)
    done = run_here("plan", *problem(hills, folder), *own)
    assert done.returncode == 0
    return folder, said(done)


def problem(hills, folder):
    ends = ENDS[: ENDS.index("--nofly-circle")]
    circle = ("--nofly-circle", "90000,0,50")
    return ("--terrain", hills, *ends, "--nofly", folder / "zones.geojson", *circle)


def said(done):
    """Return the notes and warnings about zones."""
    lines = [line.removeprefix("pathgene: ") for line in done.stderr.splitlines()]
    return [line for line in lines if line.startswith(("Note: zones", "Warning: "))]


def remarks(read):
    """Return the remarks of a stored report as they are printed."""
    return [f"{each['grade'].capitalize()}: {each['text']}" for each in read["remarks"]]


def test_a_plan_says_and_keeps_it(planned):
    folder, notes = planned
    assert [sum(line.startswith(text) for line in notes) for text in (LOW, WIRE, CIRCLE)] == [1] * 3
    read = json.loads((folder / "summary.json").read_text())["read"]["zones"]
    assert remarks(read) == notes


@pytest.mark.parametrize(
    "command",
    [
        ("check", "--path", "summary.json"),
        ("export", "summary.json", "--write", "kml", "--out", "exported"),
        ("diagnose",),
        ("compare", "--planners", "astar", "--runs", 1, "--jobs", 1, "--out", "compared"),
        ("check", "--path", "path.geojson"),
    ],
    ids=lambda command: f"{command[0]}-{command[-1]}",
)
def test_other_commands_say_the_same(planned, hills, command):
    folder, notes = planned
    name, *options = command
    files = ("summary.json", "path.geojson", "compared", "exported")
    words = [folder / each if each in files else each for each in options]
    is_of_problem = "summary.json" not in command
    given = problem(hills, folder) if is_of_problem else ()
    if "path.geojson" in command:
        given = ("--terrain", hills, "--origin", "47,8", *given[given.index("--nofly") :])
    done = run_here(name, *given, *words)
    assert done.returncode == 0
    assert said(done) == notes


def test_reports_of_diagnoses_and_comparisons_have_it(planned, hills):
    folder, notes = planned
    for command in (("diagnose",), ("compare", "--planners", "astar", "--runs", 1, "--jobs", 1)):
        out = ("--out", folder / command[0])
        done = run_here(*command, *problem(hills, folder), *out, "--json")
        read = json.loads(done.stdout)["read"]["zones"]
        assert [
            f"{each['grade'].capitalize()}: {each['text']}" for each in read["remarks"]
        ] == notes


@pytest.mark.parametrize("command", ["plan", "compare", "diagnose"])
def test_a_refusal_comes_after_the_report(planned, hills, command):
    folder, notes = planned
    given = list(problem(hills, folder))
    given[given.index("--start") + 1] = "1000,2700,60"
    if command == "compare":
        given += ["--planners", "astar", "--runs", 1]
    done = run_here(command, *given, "--origin", "47,8", "--out", folder / "refused")
    assert done.returncode == 2
    *read, last = done.stderr.splitlines()
    assert said(done) == notes
    assert read
    assert "is inside the no-fly zone R-7" in last


def test_a_refused_check_says_the_report_first(planned, hills):
    folder, notes = planned
    path = folder / "into.csv"
    path.write_text("x,y,z\n500,500,300\n90000,2700,300\n")
    given = ("--terrain", hills, "--origin", "47,8", "--nofly", folder / "zones.geojson")
    done = run_here("check", *given, "--nofly-circle", "90000,0,50", "--path", path)
    assert done.returncode == 2
    assert said(done) == notes
    assert "The start at an altitude of 300 m is inside the ground" in done.stderr.splitlines()[-1]


def test_a_refused_check_says_first_what_was_read(planned, hills, tmp_path, capsys):
    folder, _ = planned
    bad = tmp_path / "bad.geojson"
    bad.write_text("neither")
    given = ("--path", folder / "path.geojson", "--terrain", hills, "--origin", "47,8")
    assert main(["check", *map(str, given), "--nofly", str(bad)]) == 2
    report, refusal = capsys.readouterr().err.splitlines()
    assert report.startswith("pathgene: Terrain ")
    assert "bad.geojson" in refusal


def test_a_check_names_files_without_a_zone_on_the_map(planned, tmp_path, capsys):
    wire = {"type": "LineString", "coordinates": [[0, 0], [9, 9]]}
    (tmp_path / "wires.geojson").write_text(json.dumps(wire | {"crs_local": True}))
    given = "--path", planned[0] / "summary.json", "--nofly", tmp_path / "wires.geojson"
    assert main(["check", *map(str, given)]) == 0
    report = capsys.readouterr().err
    assert "wires.geojson: feature 1 left out: a LineString is not an area." in report
    # The zones of the plan hold.
    assert WIRE in report
