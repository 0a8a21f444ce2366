"""The problem of a page, as values, a problem file and a link."""

import base64
import zlib
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.problem_file import read_problem, save_problem
from pathgene.host.options.table import NAMED
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.terrain import load
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.sheet import MOST_BYTES, Sheet
from pathgene.host.web.desk.terrains import Terrains


@pytest.fixture
def terrains(tmp_path):
    return Terrains(tmp_path / "terrains")


@pytest.fixture
def sheet(terrains):
    return Sheet(terrains)


def filled(sheet):
    """Give a value to everything that a user can set."""
    sheet.take_terrain("canyon")
    sheet.place("start", 301.26, 302.0)
    sheet.add_via(2500.0, 1000.0)
    sheet.add_via(3000.04, 3000.0)
    sheet.place("via", 3001.0, 3002.0, 1)
    sheet.zones.append({"circle": (1000.0, 3000.0, 200.0), "name": "a", "upper": 900.0})
    sheet.zones.append({"polygon": [[4000.0, 100.0], [4200.0, 100.0], [4100.0, 300.0]], "t0": 5.0})
    for name, value in {
        "return_to_start": True,
        "start_heading": 45.0,
        "wind": (3.0, -2.0),
        "ds": 12.0,
        "origin": (36.2, -84.4),
        "clearance": 40.0,
        "reserve": 20.0,
        "planner": "fpa-2opt",
        "two_opt_every": 10,
        "generations": 30,
        "time_limit": 9.5,
        "seed": 7,
        "uav": "j3cub",
    }.items():
        sheet.set(name, value)
    return sheet


def same(one, other):
    """Tell whether two sheets hold the same problem; tuples equal lists."""
    return one.text() == other.text() and one.values.keys() == other.values.keys()


def test_a_new_sheet_is_a_problem_that_plans(sheet):
    mission = sheet.mission()
    assert isinstance(mission, MissionProblem)
    assert mission.problem.terrain.name == "jacksboro"
    assert sheet.values["agl"] is True
    assert sheet.planner == "ga-chip"


def test_a_link_restores_everything(sheet, terrains):
    link = filled(sheet).link()
    assert all(character.isalnum() or character in "-_" for character in link)
    other = Sheet(terrains)
    other.open_link(link)
    assert same(sheet, other)
    assert other.values["via"] == [(2500.0, 1000.0, 100.0), (3001.0, 3002.0, 100.0)]
    assert other.values["start"] == (301.3, 302.0, 100.0)
    assert other.link() == link
    assert other.mission().way == sheet.mission().way


def test_the_problem_file_is_the_products_own(sheet, tmp_path):
    file = tmp_path / "problem.toml"
    file.write_text(filled(sheet).text())
    values = read_problem(file)
    assert values["planner"] == "fpa-2opt"
    assert values["two_opt_every"] == 10
    assert [zone.get("name") for zone in values["zones"]] == ["a", None]
    other = Sheet(Terrains(tmp_path))
    other.open_file(file)
    assert same(sheet, other)


def test_another_planner_and_as_paper_make_values_void_but_do_not_forget_them(sheet):
    filled(sheet)
    sheet.set("planner", "ga-pc")
    sheet.set("as_paper", True)
    text = sheet.text()
    assert "two_opt_every" not in text
    assert "clearance" not in text
    assert "start_heading" not in text
    assert "reserve" not in text
    sheet.set("planner", "fpa-2opt")
    sheet.set("as_paper", False)
    assert "two_opt_every = 10" in sheet.text()
    assert "clearance = 40.0" in sheet.text()


def test_a_problem_of_this_machine_brings_its_files(terrains, tmp_path):
    """Degrees become metres, and files of zones and aircraft become their contents."""
    land = load("jacksboro")
    land.save_npz((tmp_path / "land.npz").open("wb"), np.zeros(land.shape, dtype=bool))
    (tmp_path / "zones.geojson").write_text(
        '{"type": "FeatureCollection", "crs_local": true, "features": [{"type": "Feature", '
        '"properties": {"radius_m": 500, "name": "lake"}, '
        '"geometry": {"type": "Point", "coordinates": [9000, 9000]}}]}'
    )
    table = load_aircraft("heron").to_dict() | {"name": "mine"}
    (tmp_path / "mine.toml").write_text(
        "\n".join(f"{key} = {value!r}".replace("'", '"') for key, value in table.items())
    )
    file = tmp_path / "mission.toml"
    save_problem(
        file,
        {
            "terrain": str(tmp_path / "land.npz"),
            "start_geo": (36.30, -84.40, 900.0),
            "goal_geo": (36.42, -84.20, 900.0),
            "via_geo": [(36.40, -84.30, 950.0)],
            "nofly": [str(tmp_path / "zones.geojson")],
            "uav": str(tmp_path / "mine.toml"),
            "out": "elsewhere",
        },
    )
    sheet = Sheet(terrains)
    sheet.open_file(file)
    values = sheet.values
    assert values["terrain"] == "land.npz"
    assert values["zones"] == [{"circle": [9000.0, 9000.0, 500.0], "name": "lake"}]
    assert values["uav"] == table
    assert "out" not in values
    latitude, longitude = land.to_geographic([values["via"][0][0]], [values["via"][0][1]])
    assert (latitude[0], longitude[0]) == pytest.approx((36.40, -84.30), abs=1e-6)
    assert sheet.mission().problem.aircraft.name == "mine"
    # A link does not name a file, and works only on this desk, and has no report.
    ((name, _),) = sheet.values.pop("zones_read")
    assert name == "zones.geojson"
    other = Sheet(terrains)
    other.open_link(sheet.link())
    assert same(sheet, other)
    with pytest.raises(InputError, match=r"^The terrain 'land.npz' is not on this desk; open "):
        Sheet(Terrains(tmp_path / "none")).open_link(sheet.link())


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[[zones]]\nfile = '/etc/passwd'", "The problem names a file of zones, '/etc/passwd'; "),
        ("[aircraft]\nfile = 'x.toml'", "The problem names a file of an aircraft, 'x.toml'; "),
        ("[terrain]\nsource = '/etc/passwd'", "The terrain 'passwd' is not on this desk; "),
        ("[mission]\nvai = 3", "there is no key 'vai' in [mission] (did you mean via?)."),
        ("[mission", "not valid TOML: "),
        ("[[zones]]\npolygon = [[0, 0], [1, 1]]", "No-fly polygon: a ring must have "),
    ],
)
def test_what_is_wrong_changes_nothing(sheet, text, sentence):
    before = filled(sheet).text()
    with pytest.raises(InputError) as caught:
        sheet.open_text(text)
    assert str(caught.value).startswith(sentence)
    assert sheet.text() == before


@pytest.mark.parametrize("fragment", ["", "%%", "abc", "eJwz", "ä"])
def test_a_damaged_link_is_one_sentence(sheet, fragment):
    with pytest.raises(InputError) as caught:
        sheet.open_link(fragment)
    assert str(caught.value) == "The link holds no whole problem; copy all of it."


def test_a_link_that_would_unpack_to_gigabytes_is_refused(sheet):
    packed = zlib.compress(b"#" * (MOST_BYTES + 1), 9)
    assert len(packed) < 2000
    with pytest.raises(InputError):
        sheet.open_link(base64.urlsafe_b64encode(packed).decode())


def test_the_task_of_a_planner_names_the_file(terrains, tmp_path):
    heights = np.zeros((20, 30))
    np.save(tmp_path / "flat.npy", heights)
    name = terrains.add_content("flat.npy", (tmp_path / "flat.npy").read_bytes(), {"cell": (9, 9)})
    sheet = Sheet(terrains)
    sheet.set("cell", (9.0, 9.0))
    sheet.take_terrain(name)
    task = sheet.task()
    assert Path(task["terrain"]).is_file()
    assert sheet.terrain().width_m == 29 * 9
    assert f'source = "{name}"' in sheet.text()
    named = {*NAMED, "zones"}
    assert set(task) - {"max_cells", "self_contained"} <= named


def test_tabs_share_no_zone(tmp_path):
    (tmp_path / "problem.toml").write_text("[[zones]]\ncircle = [9000, 9000, 500]\n")
    desk = Desk(tmp_path / "out", problem=tmp_path / "problem.toml")
    try:
        one, other = desk.sheet(), desk.sheet()
        one.zones[0]["name"] = "mine"
        assert "name" not in other.zones[0]
    finally:
        desk.close()


def test_others_plan_on_simulated_boards_alone(tmp_path):
    """They cannot use even the board of the problem file that the desk was started with."""
    ends = "start = [3000, 3000, 100]\ngoal = [20000, 20000, 100]\nagl = true\n"
    text = f"[mission]\n{ends}[planner]\nboard = '/dev/ttyUSB0'\n"
    (tmp_path / "problem.toml").write_text(text)
    desk = Desk(tmp_path / "out", local=False, problem=tmp_path / "problem.toml")
    try:
        sheet = desk.sheet()
        with pytest.raises(InputError, match=r"^Only simulated boards \(model:, sim:\) plan on a "):
            desk.plan(sheet)
        assert desk.jobs.active == []
    finally:
        desk.close()
