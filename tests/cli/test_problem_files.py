"""Problem files and missions on the command line."""

import json
import re
import tomllib

import numpy as np
import pytest

from pathgene.host.cli import main

from .conftest import assert_check_agrees, summary_in


QUICK = ("--planner", "astar", "--no-picture")


@pytest.fixture
def file(hills, tmp_path):
    """A problem file over the hills, with a zone."""
    made = tmp_path / "problem.toml"
    made.write_text(f"""
[terrain]
source = "{hills}"

[mission]
start = [500, 500, 100]
goal = [5500, 3500, 100]
agl = true

[[zones]]
circle = [3000, 2000, 400]
name = "town"

[rules]
clearance = 20

[planner]
name = "ga-pc"
refits = 1
generations = 3
seed = 4

[output]
out = "out"
picture = false
""")
    return made


def refused(capsys, *arguments):
    assert main([str(argument) for argument in arguments]) == 2
    return capsys.readouterr().err.removeprefix("pathgene: ").rstrip("\n")


def test_plans_what_the_file_says(file, capsys):
    main(["plan", str(file)])
    out = file.with_name("out")
    summary = summary_in(out)
    assert not (out / "path.png").exists()
    assert (summary["planner"], summary["seed"], summary["generations"]) == ("ga-pc", 4, 3)
    assert summary["rules"]["clearance_m"] == 20
    assert summary["nofly"] == [{"x": 3000.0, "y": 2000.0, "radius_m": 400.0, "name": "town"}]
    assert "legs" not in summary


def test_options_override_the_file(file, tmp_path, capsys):
    out = tmp_path / "other"
    options = ["--planner", "astar", "--seed", "5", "--no-agl", "--start", "500,500,600"]
    options += ["--goal", "5500,3500,600", "--nofly-circle", "3000,2500,300", "--as-paper"]
    main(["plan", str(file), *options, "--out", str(out), "--picture"])
    # The refits in the file are for ga-pc and do not apply to astar.
    assert "refits" not in capsys.readouterr().err
    summary = summary_in(out)
    assert (summary["planner"], summary["seed"]) == ("astar", 5)
    assert summary["waypoints"][0] == [500, 500, 600]
    assert summary["nofly"] == [{"x": 3000.0, "y": 2500.0, "radius_m": 300.0}]
    assert (summary["as_paper"], summary["rules"]) == (True, None)
    assert (out / "path.png").exists()


def test_a_rule_overrides_as_paper(file, tmp_path):
    file.write_text(file.read_text().replace("clearance = 20", "as_paper = true"))
    main(["plan", str(file), *QUICK])
    assert summary_in(file.with_name("out"))["as_paper"]
    main(["plan", str(file), *QUICK, "--clearance", "40"])
    assert summary_in(file.with_name("out"))["rules"]["clearance_m"] == 40


def test_saves_the_options_as_a_problem_file(hills, tmp_path, capsys):
    saved, out = tmp_path / "saved.toml", tmp_path / "out"
    options = ["--terrain", hills, "--start", "500,500,100", "--goal", "5500,3500,100", "--agl"]
    options += ["--nofly-circle", "3000,2000,400", "--clearance", "25", "--wind=-3,2", *QUICK]
    main(["plan", *map(str, options), "--out", str(out), "--save-problem", str(saved)])
    first = summary_in(out)
    assert main(["problem", "check", str(saved)]) == 0
    document = tomllib.loads(saved.read_text())
    assert document["mission"]["wind"] == [-3.0, 2.0]
    assert document["planner"] == {"name": "astar", "seed": 0}
    assert document["output"] == {"out": "out", "picture": False}
    main(["plan", str(saved)])
    again = summary_in(out)
    for summary in (first, again):
        del summary["seconds"]
    assert again == first


def test_a_mission_with_a_return(file, tmp_path, capsys):
    out = tmp_path / "mission"
    options = ["--via", "1500,3000,150", "--via", "3500,3200,150", "--return", *QUICK]
    status = main(["plan", str(file), *options, "--out", str(out)])
    output = capsys.readouterr()
    summary = summary_in(out)
    assert status == (0 if summary["feasible"] else 1), output.err
    assert [leg["name"].partition(", ")[2] for leg in summary["legs"]] == [
        "from the start to via point 1",
        "from via point 1 to via point 2",
        "from via point 2 to the goal",
        "from the goal to the start",
    ]
    assert summary["waypoints"][0] == summary["waypoints"][-1]
    for point in summary["via"]:
        assert point in summary["waypoints"]
    assert output.out.count("leg ") == 4
    # The goal is a via point before a return.
    assert [visit["point"] for visit in summary["visits"][:2]] == summary["via"]
    assert [visit["missed"] for visit in summary["visits"]] == [False] * 3
    assert "via point 3 passed at " in " ".join(output.out.split())
    assert_check_agrees(out, summary, capsys)


def test_check_takes_a_problem_file(file, tmp_path, capsys):
    path = tmp_path / "path.csv"
    main(["plan", str(file), "--via", "3000,3200,150", *QUICK, "--json"])
    summary = json.loads(capsys.readouterr().out)
    rows = [",".join(map(repr, point)) for point in summary["waypoints"]]
    path.write_text("\n".join(["x,y,z", *rows]) + "\n")
    main(["check", str(file), "--via", "3000,3200,150", "--path", str(path), "--json"])
    report = json.loads(capsys.readouterr().out)
    assert report["fitness"] == summary["fitness"]
    assert report["nofly"] == summary["nofly"]
    assert report["rules"] == summary["rules"]
    assert report["visits"] == summary["visits"]


def test_check_says_which_via_points_a_path_misses(file, tmp_path, capsys):
    options = ["--via", "3000,3200,150", "--out", str(tmp_path)]
    assert main(["plan", str(file), *options, *QUICK]) == 0
    saved = ["check", "--path", str(tmp_path / "summary.json"), "--agl"]
    capsys.readouterr()
    assert main(saved) == 0
    assert "via point 1 passed at " in " ".join(capsys.readouterr().out.split())
    given = ["--via", "3000,3200,150", "--via", "3500,2000,150"]
    assert main([*saved, *given]) == 1
    output = capsys.readouterr()
    assert "via point 2 missed at " in " ".join(output.out.split())
    assert output.err.startswith("pathgene: The path misses via point 2 at (3500, 2000, ")
    assert len(output.err.splitlines()) == 1


def test_compare_takes_the_problem_and_refuses_missions(file, tmp_path, capsys):
    options = ["--planners", "astar", "--runs", "1", "--jobs", "1", "--out", str(tmp_path / "c")]
    assert main(["compare", str(file), *options, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["nofly"][0]["name"] == "town"
    assert report["seeds"] == [0, 0]
    assert refused(capsys, "compare", file, *options, "--return") == (
        "Only single legs can be compared; leave via points and return out."
    )


def test_names_the_leg_without_a_path(file, tmp_path, capsys):
    wall = [part for y in range(0, 4001, 400) for part in ("--nofly-circle", f"4300,{y},300")]
    options = ["--via", "3000,3300,200", "--planner", "ga-pc", "--generations", "2", *wall]
    assert main(["plan", str(file), *options, "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.splitlines()[-1] == (
        "pathgene: Leg 2, from via point 1 to the goal: No way leads from the start to the goal at "
        "any altitude: the edge of the map, zone 1, zone 2, zone 3 and 8 more enclose the goal, "
        "and must open near (4300, 3404) m; the best path is written."
    )
    assert [leg["planned"] for leg in summary_in(tmp_path / "out")["legs"]] == [True, True]


def test_via_points_in_degrees_and_metres(file, capsys):
    said = refused(capsys, "plan", file, "--via", "1,2,3", "--via-geo", "36,-84,100")
    assert said == "Give all via points by --via, or all by --via-geo."
    said = refused(capsys, "plan", file, "--via-geo", "36,-84,100")
    assert said.startswith("The terrain 'hills' has no coordinate reference system, ")


def test_a_bad_file_is_one_sentence(file, capsys):
    file.write_text(file.read_text().replace("clearance", "clearence"))
    assert refused(capsys, "plan", file) == (
        f"{file}: there is no key 'clearence' in [rules] (did you mean clearance?)."
    )
    assert refused(capsys, "problem", "check", file).startswith(f"{file}: there is no key")


def test_problem_check_reports_what_the_file_describes(file, capsys):
    text = file.read_text().replace("agl = true", "agl = true\nvia = [[3000, 3300, 150]]")
    file.write_text(text)
    assert main(["problem", "check", str(file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["legs"], report["zones"], report["planner"]) == (2, 1, "ga-pc")
    assert report["straight_m"] == pytest.approx(
        sum(np.linalg.norm(np.diff(np.array(report["points"]), axis=0), axis=1))
    )
    assert main(["problem", "check", str(file)]) == 0
    assert "via point 1" in capsys.readouterr().out


def test_problem_check_needs_no_board(file, capsys):
    text = re.sub(r"\[planner\].*?(?=\n\[|\Z)", "", file.read_text(), flags=re.DOTALL)
    file.write_text(f'{text}\n[planner]\nboard = "/dev/nowhere"\n')
    assert main(["problem", "check", str(file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["planner"], report["generations"]) == (None, None)
    assert main(["problem", "check", str(file)]) == 0
    assert "the board's" in capsys.readouterr().out


def test_problem_new_replaces_no_file(file, tmp_path, capsys):
    assert refused(capsys, "problem", "new", file) == (
        f"{str(file)!r} exists; give the name of a new file."
    )
    assert main(["problem", "new", str(tmp_path / "new.toml")]) == 0
    assert main(["problem", "check", str(tmp_path / "new.toml")]) == 0


def test_a_check_says_what_was_read_of_the_zones(file, capsys):
    ring = [[2000, 3000], [2400, 3000], [2400, 3400], [2000, 3000]]
    features = [
        {"type": "Feature", "properties": {"name": "R-7", "upper": 900},
         "geometry": {"type": "Polygon", "coordinates": [ring]}},
        {"type": "Feature", "properties": {"name": "line"},
         "geometry": {"type": "LineString", "coordinates": ring[:2]}},
    ]  # fmt: skip
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    file.with_name("more.geojson").write_text(json.dumps(document))
    file.write_text(file.read_text() + '[[zones]]\nfile = "more.geojson"\n')
    assert main(["problem", "check", str(file)]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert 'zone feature 1, "R-7", ground to 900 m AMSL' in lines
    assert 'note more.geojson: feature 2, "line" left out: a LineString is not an area.' in lines
    assert main(["problem", "check", str(file), "--json"]) == 0
    (read,) = json.loads(capsys.readouterr().out)["read"]["zones"]["files"]
    assert (read["read"], read["on_map"], read["can_forbid"]) == (1, 1, 1)


@pytest.mark.parametrize(
    ("place", "facts"),
    [
        ("", "hills"),
        ("origin = [47, 8]\n", r"\S+hills.npz: 41 x 61 nodes, cells of 100 x 100 m, .+ of 150"),
    ],
)
def test_a_check_says_what_was_read_of_the_terrain(file, capsys, place, facts):
    file.write_text(file.read_text().replace("[terrain]\n", f"[terrain]\n{place}"))
    assert main(["problem", "check", str(file)]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert re.match(rf"terrain +{facts}", first)
    assert bool(place) == ("(unit assumed, datum assumed)" in first)


def test_a_refused_check_says_first_what_was_read(file, capsys):
    point = {"type": "Point", "coordinates": [2000, 3000]}
    features = [{"type": "Feature", "properties": {"name": "mast"}, "geometry": point}]
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    file.with_name("more.geojson").write_text(json.dumps(document))
    text = re.sub(r"goal = \[[^]]*\]", "goal = [90000, 0, 100]", file.read_text())
    file.write_text(text + '[[zones]]\nfile = "more.geojson"\n')
    assert main(["problem", "check", str(file)]) == 2
    out, said = capsys.readouterr()
    *report, refusal = said.splitlines()
    assert out == ""
    assert any('feature 1, "mast" left out' in line for line in report)
    assert "goal" in refusal
    # A bad file of zones does not hide the report on the terrain.
    file.with_name("more.geojson").write_text("neither")
    file.write_text(file.read_text().replace("[terrain]", "[terrain]\norigin = [47, 8]"))
    assert main(["problem", "check", str(file)]) == 2
    report, refusal = capsys.readouterr().err.splitlines()
    assert report.startswith("pathgene: Terrain ")
    assert "more.geojson" in refusal
    # Nor does it hide the report on the files of zones before it.
    document["features"] = [features[0] | {"properties": {"name": "mast", "radius_m": 50}}]
    file.with_name("good.geojson").write_text(json.dumps(document))
    text = file.read_text().replace('file = "more.geojson"', 'file = "good.geojson"')
    file.write_text(text + '[[zones]]\nfile = "more.geojson"\n')
    assert main(["problem", "check", str(file)]) == 2
    *report, refusal = capsys.readouterr().err.splitlines()
    assert any("good.geojson: 1 zone read as GeoJSON" in line for line in report)
    assert "more.geojson" in refusal
