"""``pathgene mend``: exit statuses, files, and the list of changes."""

import json

import pytest

from pathgene.host.cli import main
from tests.support.host.foreign import write_planted


@pytest.fixture
def mission(tmp_path):
    """Write the terrain and the plan of a kind, and return the arguments that mend it."""

    def write(kind, **options):
        plan, ground = write_planted(tmp_path, kind, **options)
        return "mend", plan, "--terrain", ground

    return write


def run(capsys, *arguments):
    status = main(list(map(str, arguments)))
    out, said = capsys.readouterr()
    return status, out, said


def test_a_mended_file_passes_the_check(mission, tmp_path, capsys):
    status, out, _ = run(capsys, *mission("fence", faulty=True), "--out", tmp_path / "n.plan")
    assert status == 0
    assert "\nInserted 1 waypoint after item " in out
    again = "check", "--terrain", tmp_path / "land.npz", "--path", tmp_path / "n.plan"
    assert run(capsys, *again)[0] == 0


def test_a_dry_run_writes_nothing(mission, tmp_path, capsys):
    command = mission("survey", faulty=True)
    before = sorted(tmp_path.iterdir())
    status, out, said = run(capsys, *command, "--dry-run", "--json")
    assert status == 0
    report = json.loads(out)
    assert report["mended"]
    assert report["written"] is None
    assert {change["kind"] for change in report["changes"]} == {"raise"}
    assert report["after"]["feasible"]
    assert "Note: The definition of survey 2 keeps its old height: " in said
    assert sorted(tmp_path.iterdir()) == before


def test_a_mission_without_a_fault_says_so(mission, capsys):
    status, out, _ = run(capsys, *mission("ridge", faulty=False), "--dry-run")
    assert status == 0
    assert "nothing to mend" in out


def test_a_mission_that_cannot_be_mended_is_not_written(mission, tmp_path, capsys):
    # No way leads over the survey's summit below the ceiling, and its lines stay in place.
    command = *mission("survey", faulty=True), "--ceiling", 425, "--out", tmp_path / "n.plan"
    status, out, said = run(capsys, *command)
    assert status == 1
    assert "clearance" in out
    assert said.endswith("no detour removes it. Nothing is written.\n")
    assert not (tmp_path / "n.plan").exists()


def test_a_line_becomes_a_plan_with_a_note(mission, tmp_path, capsys):
    ground = mission("ridge", faulty=False)[2:]
    line = tmp_path / "m.csv"
    line.write_text("lat,lon,alt\n46.97,9.02,320\n46.97,9.06,320\n")
    status, _, said = run(capsys, "mend", line, *ground, "--out", tmp_path / "n.plan")
    assert status == 0
    assert (
        "Note: n.plan is a new .plan with the points of m.csv as waypoints, and home on the ground "
        "below the first.\n" in said
    )
    assert json.loads((tmp_path / "n.plan").read_text())["mission"]["plannedHomePosition"][2] > 290


def test_bad_input_is_one_sentence(mission, tmp_path, capsys):
    command = mission("ridge", faulty=True)
    status, _, said = run(capsys, *command)
    assert status == 2
    assert "--out --dry-run" in said
    status, _, said = run(capsys, *command, "--out", tmp_path / "n.kml")
    assert status == 2
    assert said.endswith("n.kml: a mended mission of m.plan is written as a .plan; give n.plan.\n")
    path = tmp_path / "path.geojson"
    path.write_text("{}")
    status, _, said = run(capsys, "mend", path, *command[2:], "--dry-run")
    assert status == 2
    assert "there is no mission in it; give " in said
