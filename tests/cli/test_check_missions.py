"""``pathgene check`` of missions of ground stations, and of our own files."""

import json

import pytest
from matplotlib.image import imread

from pathgene.host.cli import main
from tests.support.host.cases import case
from tests.support.host.foreign import write_planted


@pytest.fixture
def mission(tmp_path):
    """Write the terrain and the plan of a kind, and return the arguments of the check."""

    def write(kind, **options):
        plan, ground = write_planted(tmp_path, kind, **options)
        return "check", "--terrain", ground, "--path", plan

    return write


def run(capsys, *arguments):
    status = main(list(map(str, arguments)))
    out, said = capsys.readouterr()
    return status, out, said


def test_a_clean_mission_exits_0_and_says_what_was_read(mission, capsys):
    status, out, said = run(capsys, *mission("fence", faulty=False))
    assert status == 0
    assert out.startswith("feasible           yes\nfaults             0\n")
    assert (
        "Mission m.plan: a .plan of QGroundControl, 6 items, heights above mean sea level" in said
    )
    assert "fence" in said


def test_the_transects_of_a_survey_are_said(mission, capsys):
    status, _, said = run(capsys, *mission("survey", faulty=False))
    assert status == 0
    assert "Note: survey 2 is flown by its stored transects, items 2 to 9.\n" in said


def test_a_fault_is_one_line_and_exits_1(mission, capsys):
    status, out, said = run(capsys, *mission("ridge", faulty=True))
    assert status == 1
    (line,) = [line for line in out.splitlines() if line.startswith("1. item ")]
    assert ": clearance " in line
    assert "; raise item" in line
    assert said.endswith("The mission is not feasible: 1 fault.\n")


def test_the_faults_are_a_list_in_json(mission, capsys):
    status, out, _ = run(capsys, *mission("climb", faulty=True), "--json")
    report = json.loads(out)
    assert status == 1
    assert not report["feasible"]
    (fault,) = report["faults"]
    assert fault["limit"] == "climb"
    assert fault["value_m"] - fault["allowed_m"] == pytest.approx(fault["broken_by_m"])
    assert set(report["read"]) == {"terrain", "zones", "mission"}
    assert report["uav"]["name"] == "Silver Fox-like"


def test_items_that_are_ignored_and_assumptions_are_said(mission, tmp_path, capsys):
    arguments = mission("return", faulty=False)
    document = json.loads((tmp_path / "m.plan").read_text())
    camera = {"type": "SimpleItem", "command": 206, "frame": 2, "params": [25, 0, 1, 0, 0, 0, 0]}
    document["mission"]["items"].insert(2, camera)
    document["rallyPoints"]["points"] = [[46.0, 9.0, 50]]
    (tmp_path / "m.plan").write_text(json.dumps(document))
    status, _, said = run(capsys, *arguments)
    assert status == 0
    assert ", rally points: 1." in said
    assert "Ignored, as they do not move the aircraft: item 3 DO_SET_CAM_TRIGG_DIST (206)." in said
    assert (
        "Warning: the height of the return, 100 m above home, is the default of ArduPilot" in said
    )
    status, _, said = run(capsys, *arguments, "--return-height", "20")
    assert status == 1
    assert "the default" not in said


def test_a_mission_with_a_bad_item_exits_2_with_its_name(mission, tmp_path, capsys):
    arguments = mission("ridge", faulty=False)
    text = (tmp_path / "m.plan").read_text().replace('"command": 16', '"command": 82', 1)
    (tmp_path / "m.plan").write_text(text)
    status, _, said = run(capsys, *arguments)
    assert status == 2
    assert said.endswith(
        "m.plan: item 1 is NAV_SPLINE_WAYPOINT (82), which cannot be judged; leave it out or "
        "replace it by waypoints.\n"
    )


@pytest.mark.parametrize(
    ("option", "name"),
    [(("--start", "1,2,3"), "start"), (("--return",), "return"), (("--as-paper",), "as-paper")],
)
def test_options_of_paths_are_refused(option, name, mission, capsys):
    status, _, said = run(capsys, *mission("ridge", faulty=False), *option)
    assert status == 2
    assert said.endswith(f"m.plan is a mission, which is judged without --{name}.\n")


@pytest.mark.ci
def test_the_files_that_a_plan_writes_pass(tmp_path, capsys):
    terrain = case("19-check-own-mission-files/geo60.tif")
    ends = ("--agl", "--start-geo", "59.985,10.015,80", "--goal-geo", "60.015,10.095,80")
    formats = ("--write", "plan,waypoints,kml", "--out", tmp_path)
    plan = ("plan", "--terrain", terrain, *ends, "--planner", "astar", "--no-picture", *formats)
    assert run(capsys, *plan)[0] == 0
    for name in ("path.plan", "path.waypoints", "path.kml"):
        status, out, said = run(capsys, "check", "--terrain", terrain, "--path", tmp_path / name)
        assert (status, "faults             0" in out) == (0, True), said


def test_the_missions_of_the_case_hit_the_hill(capsys):
    terrain = case("19-check-own-mission-files/geo60.tif")
    for name, word in (("mission.waypoints", "item"), ("route.kml", "point")):
        file = case(f"19-check-own-mission-files/{name}")
        status, out, _ = run(capsys, "check", "--terrain", terrain, "--path", file)
        assert status == 1
        assert f"{word} 1 to 2: clearance 94.0 m too low (-64.0 m, required 30 m), at " in out


def test_the_faults_of_a_line_of_geojson_are_named_by_its_points(mission, tmp_path, capsys):
    *terrain, _ = mission("ridge", faulty=True)
    items = json.loads((tmp_path / "m.plan").read_text())["mission"]["items"]
    line = [(item["params"][5], item["params"][4], item["params"][6]) for item in items]
    file = tmp_path / "line.geojson"
    file.write_text(json.dumps({"type": "LineString", "coordinates": line}))
    by_plan = json.loads(run(capsys, *terrain, tmp_path / "m.plan", "--json")[1])["faults"]
    status, out, _ = run(capsys, *terrain, file)
    assert status == 1
    (text,) = [text for text in out.splitlines() if text.startswith("1. point ")]
    assert text == f"1. {by_plan[0]['sentence']}".replace("item", "point")
    (fault,) = json.loads(run(capsys, *terrain, file, "--json")[1])["faults"]
    assert fault["broken_by_m"] == pytest.approx(by_plan[0]["broken_by_m"], abs=0.02)


def test_out_writes_the_report_and_the_picture(mission, tmp_path, capsys):
    out = tmp_path / "out"
    status, said, _ = run(capsys, *mission("fence", faulty=True), "--out", out)
    assert status == 1
    assert f"written            {out / 'check.json'}\n" in said
    assert f"written            {out / 'check.png'}\n" in said
    assert imread(out / "check.png").std() > 0
    (fault,) = json.loads((out / "check.json").read_text())["faults"]
    assert fault["number"] == 1
    assert f"\n1. {fault['sentence']}\n" in said


def test_out_is_refused_for_a_path(tmp_path, capsys):
    (tmp_path / "path.csv").write_text("x,y,z\n0,0,100\n500,500,100\n")
    path = ("--terrain", "canyon", "--path", tmp_path / "path.csv")
    status, _, said = run(capsys, "check", *path, "--out", tmp_path / "out")
    assert status == 2
    assert "path.csv is a path, whose picture pathgene plan draws; leave out --out, or" in said
    assert not (tmp_path / "out").exists()


def test_write_html_adds_the_page(mission, tmp_path, capsys):
    arguments = mission("ridge", faulty=True)
    status, _, said = run(capsys, *arguments, "--write", "html")
    assert status == 2
    assert said.endswith("--write html needs the directory to write to; give --out.\n")
    out = tmp_path / "out"
    assert run(capsys, *arguments, "--write", "html", "--out", out)[0] == 1
    (fault,) = json.loads((out / "check.json").read_text())["faults"]
    assert fault["sentence"] in (out / "check.html").read_text()
    assert run(capsys, *arguments, "--out", out)[0] == 1
    assert not (out / "check.html").exists()
