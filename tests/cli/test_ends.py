"""``--end`` and ``--land`` of ``plan``, ``export``, ``upload`` and problem files."""

import json

import numpy as np
import pytest

from pathgene.host.cli import main


COMMANDS = (*("--planner", "astar", "--no-picture"), "--origin", "46.1,7.6", "--void", "none")


@pytest.fixture(scope="module")
def valley(tmp_path_factory):
    """File of a valley of 300 m between walls of 1,500 m, which opens into a plain in the east."""
    heights = 1500.0 + 100.0 * np.random.default_rng(0).random((81, 161))
    heights[39:43, :80] = 0.0
    heights[:, 80:] = 0.0
    file = tmp_path_factory.mktemp("terrain") / "valley.npz"
    np.savez(file, elevation=heights, dx_m=100.0, dy_m=100.0)
    return str(file)


def plan(terrain, out, *options):
    ends = ("--start", "1000,4050,60", "--goal", "4000,4050,60")
    return main(["plan", "--terrain", terrain, *ends, *COMMANDS, *options, "--out", str(out)])


def commands_of(file):
    return [item["command"] for item in json.loads(file.read_text())["mission"]["items"]]


def test_plan_writes_all_but_the_flight_plans_without_room(valley, tmp_path, capsys):
    assert plan(valley, tmp_path, "--write", "plan,waypoints,kml") == 1
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        *("path.geojson", "path.kml", "summary.json", "terrain.npz")
    ]
    assert json.loads((tmp_path / "summary.json").read_text())["feasible"]
    said = capsys.readouterr().err.splitlines()[-1]
    assert "The mission cannot end with a circle of 150 m around the goal, which is over " in said
    assert said.endswith("path.plan and path.waypoints are not written, but all other files are.")


@pytest.fixture(scope="module")
def planned(valley, tmp_path_factory):
    out = tmp_path_factory.mktemp("planned")
    assert plan(valley, out) == 0
    return out / "summary.json"


def test_export_and_upload_refuse_a_circle_without_room(planned, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["export", str(planned), "--out", str(out), "--write", "plan,kml"]) == 1
    assert not out.exists()
    assert main(["upload", str(planned), "--to", "udpin:127.0.0.1:0"]) == 1
    first, second = (line for line in capsys.readouterr().err.splitlines() if "cannot end" in line)
    assert first == second
    assert first.endswith(
        "give a goal at x 8583 m, y 4161 m and an altitude of 60 m, where a circle has room, --end "
        "rtl, which has room, or a landing (--land)."
    )


def test_export_ends_with_a_return_instead(planned, tmp_path, capsys):
    assert main(["export", str(planned), "--end", "rtl", "--out", str(tmp_path)]) == 0
    assert commands_of(tmp_path / "path.plan")[-1] == 20
    assert "The mission ends with a straight return to home" in capsys.readouterr().err


@pytest.mark.ci
def test_export_and_upload_follow_the_plan(valley, tmp_path, capsys):
    problem = tmp_path / "problem.toml"
    ends = ("--start", "9000,2000,60", "--goal", "12000,2000,60")
    words = ["--terrain", valley, *ends, *COMMANDS, "--land", "12000,5500,350"]
    out, mission = tmp_path / "out", tmp_path / "mission"
    assert main(["plan", *words, "--save-problem", str(problem), "--out", str(out)]) == 0
    end = json.loads((out / "summary.json").read_text())["end"]
    assert end == {"kind": "land", "land": [12000.0, 5500.0, 350.0]}
    assert main(["export", str(out / "summary.json"), "--out", str(mission)]) == 0
    assert commands_of(mission / "path.plan")[-4:] == [189, 31, 16, 21]
    said = capsys.readouterr().err
    assert "After a missed approach, ArduPlane climbs straight ahead to " in said
    assert main(["plan", str(problem), "--write", "plan", "--out", str(out)]) == 0
    assert (out / "path.plan").read_bytes() == (mission / "path.plan").read_bytes()
    export = ["export", str(out / "summary.json"), "--end", "loiter", "--out", str(mission)]
    assert main(export) == 0
    assert commands_of(mission / "path.plan")[-1] == 17


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ("--end", "land"),
            "The end land needs the place and the heading of the landing; give --land.",
        ),
        (
            ("--end", "rtl", "--land", "1,2,3"),
            "A mission that lands does not end with rtl; leave out --end or --land.",
        ),
        (("--land", "1,2"), "Argument --land: must be finite numbers X,Y,HEADING, not '1,2'"),
        (
            ("--land-geo", "7.6,46.1,90"),
            "The landing at latitude 7.6 and longitude 46.1 is outside the map, but on it with the "
            "two swapped: latitude first?",
        ),
        (
            ("--land", "99000,0,90"),
            "The landing at (99000, 0) is outside the map, which reaches to ",
        ),
    ],
)
def test_refuses_bad_ends(planned, tmp_path, capsys, options, sentence):
    assert main(["export", str(planned), *options, "--out", str(tmp_path)]) in (1, 2)
    assert sentence in capsys.readouterr().err.splitlines()[-1]


def test_a_check_of_a_problem_states_the_end(valley, tmp_path, capsys):
    problem = tmp_path / "problem.toml"
    for keys, status, said in (
        ('end = "rtl"', 0, "rtl"),
        ("land = [12000.0, 5500.0, 350.0]", 0, "land"),
        ('end = "land"', 2, "The end land needs the place and the heading of the landing"),
    ):
        problem.write_text(
            f'[terrain]\nsource = "{valley}"\nvoid = "none"\n'
            f"[mission]\nstart = [9000, 2000, 60]\ngoal = [12000, 2000, 60]\n{keys}\n"
        )
        assert main(["problem", "check", str(problem)]) == status
        output = capsys.readouterr()
        assert said in (output.err if status else output.out)


def test_a_plan_file_has_its_own_end(planned, tmp_path, capsys):
    assert main(["export", str(planned), "--end", "rtl", "--out", str(tmp_path)]) == 0
    words = ["upload", str(tmp_path / "path.plan"), "--to", "udpin:127.0.0.1:0", "--end", "rtl"]
    assert main(words) == 2
    assert "A .plan file has its own end; leave --end and --land out." in capsys.readouterr().err


@pytest.mark.parametrize("stated", [{"kind": "land", "land": None}, {"kind": "fly"}, "rtl"])
def test_names_a_bad_end_of_a_summary(planned, tmp_path, capsys, stated):
    file = tmp_path / "summary.json"
    summary = json.loads(planned.read_text())
    file.write_text(json.dumps({**summary, "end": stated, "files": {}}))
    assert main(["export", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "end must be a table with the kind loiter, land or rtl" in capsys.readouterr().err


@pytest.mark.ci
def test_batch_writes_all_but_the_flight_plans_without_room(valley, tmp_path, capsys):
    problem, out = tmp_path / "valley.toml", tmp_path / "out"
    words = ["plan", "--terrain", valley, "--start", "1000,4050,60", "--goal", "4000,4050,60"]
    save = ["--save-problem", str(problem), "--write", "plan,kml", "--out", str(tmp_path / "one")]
    assert main([*words, *COMMANDS, *save]) == 1
    assert main(["batch", str(problem), "--out", str(out)]) == 0
    assert "path.plan is not written" in capsys.readouterr().err
    assert (out / "valley" / "path.kml").exists()
    assert not (out / "valley" / "path.plan").exists()
