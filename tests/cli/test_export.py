"""``pathgene export``, ``pathgene plan --write`` and ``--origin``."""

import json
import re
import shutil

import pytest

from pathgene.host.cli import main
from tests.cli.conftest import ENDS, last_line, plan, run_here


@pytest.fixture(scope="module")
def flown(hills, tmp_path_factory):
    """Return the folder of a plan on a terrain placed by ``--origin``."""
    out = tmp_path_factory.mktemp("flown")
    options = ("--planner", "astar", "--no-picture", "--origin", "-33.5,151.25")
    assert plan(hills, out, *options, "--as-paper", "--write", "kml,plan") == 0
    return out


def test_plan_writes_what_is_asked(flown, hills, capsys):
    names = ["path.geojson", "path.kml", "path.plan", "summary.json", "terrain.npz"]
    assert sorted(file.name for file in flown.iterdir()) == names
    home = json.loads((flown / "path.plan").read_text())["mission"]["plannedHomePosition"]
    # 500 m east and north of the origin.
    assert home[:2] == [
        pytest.approx(-33.5 + 500 / 110_917, abs=1e-6),
        pytest.approx(151.2554, abs=1e-4),
    ]
    assert main(["check", "--path", str(flown / "summary.json")]) == 0


def test_plan_removes_the_files_of_an_earlier_run(hills, tmp_path):
    for name in ("path.plan", "path.kml", "path.waypoints"):
        (tmp_path / name).write_text("earlier")
    options = ("--planner", "astar", "--no-picture", "--as-paper")
    assert plan(hills, tmp_path, *options, "--write", "geojson") == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "path.geojson",
        "summary.json",
        "terrain.npz",
    ]


def test_export_writes_the_same_files(flown, tmp_path, capsys):
    assert main(["export", str(flown / "summary.json"), "--out", str(tmp_path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report == {
        "files": {name: str(tmp_path / f"path.{name}") for name in ("plan", "waypoints", "kml")},
        "notes": report["notes"],
    }
    for name in ("path.plan", "path.kml"):
        assert (tmp_path / name).read_bytes() == (flown / name).read_bytes()


def test_export_prints_the_files(flown, tmp_path, capsys):
    arguments = ["export", str(flown / "summary.json"), "--write", "kml", "--out", str(tmp_path)]
    assert main(arguments) == 0
    assert capsys.readouterr().out == f"written  {tmp_path / 'path.kml'}\n"


def test_export_into_the_folder_of_the_run_keeps_it_whole(flown, tmp_path, capsys):
    out = tmp_path / "run"
    shutil.copytree(flown, out)
    file = out / "summary.json"
    before = json.loads(file.read_text())
    assert main(["export", str(file), "--write", "waypoints,kml"]) == 0
    after = json.loads(file.read_text())
    assert set(after["files"]) - set(before["files"]) == {"path.waypoints"}
    assert {**after, "files": None} == {**before, "files": None}
    assert main(["check", "--path", str(file)]) == 0


@pytest.mark.parametrize("command", ["check --path", "export", "fly", "upload --to udpin::0"])
def test_a_mixture_of_two_runs_is_named(flown, tmp_path, capsys, command):
    out = tmp_path / "run"
    shutil.copytree(flown, out)
    kml = out / "path.kml"
    kml.write_text(kml.read_text().replace("Start", "start"))
    file = out / "summary.json"
    assert main([*command.split(" "), str(file)]) == 2
    assert capsys.readouterr().err == (
        f"pathgene: {kml} is not the file that the run of {file} wrote, but altered or of another "
        "run; remove it, or plan again.\n"
    )


def test_a_missing_terrain_is_named_only_if_it_is_needed(flown, tmp_path, capsys):
    out = tmp_path / "run"
    shutil.copytree(flown, out)
    (out / "terrain.npz").unlink()
    file = out / "summary.json"
    assert main(["check", "--path", str(file)]) == 0
    summary = json.loads(file.read_text())
    summary["terrain"]["source"] = str(tmp_path / "gone.npz")
    file.write_text(json.dumps(summary))
    assert main(["check", "--path", str(file)]) == 2
    assert capsys.readouterr().err.startswith(
        f"pathgene: {out / 'terrain.npz'}, the terrain of the run, is missing, and the file that "
        "it was made from cannot be read; put terrain.npz back, or plan again. "
    )


def test_export_warns_of_a_path_that_is_not_feasible(flown, tmp_path, capsys):
    summary = json.loads((flown / "summary.json").read_text())
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(summary | {"feasible": False}))
    (tmp_path / "terrain.npz").write_bytes((flown / "terrain.npz").read_bytes())
    assert main(["export", str(file), "--write", "kml"]) == 0
    assert last_line(capsys.readouterr().err) == (
        "pathgene: The path is not feasible; look at the files, but do not fly them.\n"
    )
    assert (tmp_path / "path.kml").exists()


def test_export_takes_an_origin(hills, tmp_path, capsys):
    assert plan(hills, tmp_path, "--planner", "astar", "--no-picture", "--as-paper") == 0
    capsys.readouterr()
    summary = str(tmp_path / "summary.json")
    assert main(["export", summary, "--write", "plan"]) == 2
    name = json.loads((tmp_path / "summary.json").read_text())["terrain"]["name"]
    assert capsys.readouterr().err == (
        f"pathgene: The terrain {name!r} has no place on Earth, which this file needs; give the "
        "latitude and longitude of its south-west node (--origin LAT,LON, or origin under "
        "[terrain] in a problem file).\n"
    )
    assert main(["export", summary, "--write", "plan", "--origin", "-33.5,151.25"]) == 0
    assert (tmp_path / "path.plan").exists()


@pytest.mark.parametrize("command", ["plan", "export"])
def test_an_unknown_format_is_one_sentence(flown, hills, tmp_path, capsys, command):
    if command == "plan":
        assert plan(hills, tmp_path, "--write", "plan,gpx") == 2
    else:
        assert main(["export", str(flown / "summary.json"), "--write", "plan,gpx"]) == 2
    assert capsys.readouterr().err == (
        "pathgene: There is no file format 'gpx'; give some of plan, waypoints, kml, geojson, html "
        "(--write).\n"
    )


def test_plan_refuses_a_format_that_needs_a_place_before_it_searches(hills, tmp_path, capsys):
    assert plan(hills, tmp_path / "none", "--write", "plan") == 2
    assert "has no place on Earth" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()


def edited(flown, out, move_to_m):
    """Copy a run and lower a waypoint in its summary, which still calls the path feasible."""
    shutil.copytree(flown, out)
    file = out / "summary.json"
    summary = json.loads(file.read_text())
    assert summary["feasible"] is True
    summary["waypoints"][1][2] = move_to_m
    file.write_text(json.dumps(summary))
    return file


@pytest.fixture(scope="module")
def safe(hills, tmp_path_factory):
    """Return the folder of a plan with the rules of safe flight, including its terrain."""
    out = tmp_path_factory.mktemp("safe") / "run"
    options = ("--planner", "astar", "--no-picture", "--origin", "-33.5,151.25")
    assert plan(hills, out, *options, "--write", "plan") == 0
    return out


UPLOAD = "upload --to udpout:127.0.0.1:9 --timeout 0.1"


@pytest.mark.parametrize(
    ("command", "consequence"),
    [
        ("export", "nothing is written, plan again"),
        (UPLOAD, "nothing is uploaded, plan again, or give --infeasible"),
    ],
)
def test_an_edited_path_is_judged_again(safe, tmp_path, capsys, command, consequence):
    file = edited(safe, tmp_path / "run", 120.0)
    before = {path: path.read_bytes() for path in file.parent.iterdir()}
    assert main([*command.split(), str(file)]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(
        rf"pathgene: {re.escape(str(file))}: the path breaks the limit clearance, \S+ where \S+ "
        r"is allowed, \d+ m from the start, although the summary calls it feasible; "
        rf"{consequence}\.\n",
        last_line(captured.err),
    )
    assert {path: path.read_bytes() for path in file.parent.iterdir()} == before
    out = tmp_path / "out"
    if command == "export":
        assert main(["export", str(file), "--out", str(out)]) == 1
        assert not out.exists()


def test_an_edited_path_as_paper_is_judged_by_the_paper(flown, tmp_path, capsys):
    file = edited(flown, tmp_path / "run", -400.0)
    assert main(["export", str(file)]) == 1
    assert re.fullmatch(
        rf"pathgene: {re.escape(str(file))}: the path is not feasible: \d+\.\d m under the "
        r"terrain.*, although the summary calls it feasible; nothing is written, plan again\.\n",
        last_line(capsys.readouterr().err),
    )


def test_a_turn_that_nobody_can_fly_is_named(safe, tmp_path, capsys):
    file = edited(safe, tmp_path / "run", 900.0)
    summary = json.loads(file.read_text())
    x, y, z = summary["waypoints"][0]
    summary["waypoints"][1:-1] = [[x + 400, y + 10, z], [x, y + 20, z], [x + 400, y + 30, z]]
    summary |= {"nofly": [], "feasible": None}
    file.write_text(json.dumps(summary))
    assert main(["export", str(file)]) == 1
    assert re.search(r": the path breaks the limit \S+.*; nothing is wr", capsys.readouterr().err)


def test_a_path_that_misses_a_via_point_is_not_written(hills, tmp_path, capsys):
    out = tmp_path / "run"
    options = ("--planner", "astar", "--no-picture", "--via", "3000,3500,100")
    assert plan(hills, out, *options) == 0
    file = out / "summary.json"
    summary = json.loads(file.read_text())
    assert main(["export", str(file), "--write", "geojson"]) == 0
    summary["legs"][1]["from"][0] -= 300.0
    file.write_text(json.dumps(summary))
    capsys.readouterr()
    assert main(["export", str(file), "--write", "geojson"]) == 1
    assert re.search(
        r"json: the path misses via point 1 at .*; it must have a waypoint there, which a turn may "
        r"round, although the summary calls it feasible; nothing is written, plan again\.\n",
        capsys.readouterr().err,
    )


def test_upload_takes_an_edited_path_only_on_demand(safe, tmp_path, capsys):
    file = edited(safe, tmp_path / "run", 120.0)
    assert main([*UPLOAD.split(), str(file), "--infeasible"]) == 1
    assert "No autopilot answers" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["export", UPLOAD])
def test_a_path_whose_terrain_is_gone_is_not_believed(safe, tmp_path, capsys, command):
    file = edited(safe, tmp_path / "run", 900.0)
    summary = json.loads(file.read_text())
    gone = str(tmp_path / "gone.npz")
    summary["terrain"]["source"] = gone
    del summary["files"]
    file.write_text(json.dumps(summary))
    (file.parent / "terrain.npz").unlink()
    assert main([*command.split(), str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(
        f"pathgene: {file}: the terrain of the run cannot be read; put it back at {gone}, or plan "
        "again. "
    )
    assert error.count("\n") == 1


@pytest.mark.parametrize("heights", ["sea-level", "ellipsoidal"])
def test_a_plan_above_the_ellipsoid_says_so(hills, tmp_path, heights):
    given = ("--terrain", hills, *ENDS, "--origin", "47,8", "--heights", heights)
    own = ("--planner", "astar", "--no-picture", "--write", "plan", "--out", tmp_path)
    assert run_here("plan", *given, *own).returncode == 0
    stated = json.loads((tmp_path / "path.plan").read_text())["pathgene"]
    datum = None if heights == "sea-level" else "above the ellipsoid WGS84, not AMSL"
    assert stated.get("heights") == datum
