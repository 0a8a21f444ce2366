"""``pathgene export``, ``pathgene plan --write`` and ``--origin``."""

import json

import pytest

from host.cli import main
from tests.cli.conftest import plan


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


def test_export_warns_of_a_path_that_is_not_feasible(flown, tmp_path, capsys):
    summary = json.loads((flown / "summary.json").read_text())
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(summary | {"feasible": False}))
    (tmp_path / "terrain.npz").write_bytes((flown / "terrain.npz").read_bytes())
    assert main(["export", str(file), "--write", "kml"]) == 0
    assert capsys.readouterr().err == (
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
        "pathgene: There is no file format 'gpx'; give some of plan, waypoints, kml, geojson "
        "(--write).\n"
    )


def test_plan_refuses_a_format_that_needs_a_place_before_it_searches(hills, tmp_path, capsys):
    assert plan(hills, tmp_path / "none", "--write", "plan") == 2
    assert "has no place on Earth" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
