"""Problem files: every key, in and out, the template, and the page that documents them."""

import argparse
import re
import tomllib
from pathlib import Path

import pytest

from pathgene.host.cli.parser import build_parser
from pathgene.host.errors import InputError
from pathgene.host.mission.build import mission_of, search_of
from pathgene.host.mission.problem_file import (
    markdown,
    problem_text,
    read_problem,
    save_problem,
    template,
)
from pathgene.host.options.table import NAMED, OPTIONS, TABLES, keys_of
from pathgene.host.problem.zones import Circle, Polygon


ROOT = Path(__file__).resolve().parents[3]
KEYS = [option for option in OPTIONS if option.table]
GLIDER = re.findall(
    r"```toml\n(.*?)```", (ROOT / "docs" / "rules.md").read_text(), flags=re.DOTALL
)[0]


@pytest.fixture
def written(tmp_path):
    """Function that writes a problem file and reads it."""

    def write(text, name="problem.toml"):
        file = tmp_path / name
        file.write_text(text)
        return read_problem(file)

    return write


def refusal(written, text):
    with pytest.raises(InputError) as error:
        written(text)
    return re.sub(r"^\S*/problem\.toml: ", "", str(error.value))


def plan_actions():
    """Return the options of ``pathgene plan`` by destination."""
    commands = next(
        action
        for action in build_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    return {
        action.dest: action.option_strings
        for action in commands.choices["plan"]._actions
        # A limit is set by the user, not by a problem file, which may come from anybody.
        if action.dest
        not in ("help", "json", "debug", "problem", "beside", "save_problem", "max_cells")
    }


def test_every_option_of_plan_has_a_key():
    actions = plan_actions()
    keys = {name: option for name, option in NAMED.items() if option.table}
    assert set(actions) == set(keys)
    for name, option in keys.items():
        assert option.shown_flag in actions[name], name


@pytest.mark.parametrize("option", KEYS, ids=lambda option: f"{option.table}.{option.key}")
def test_every_example_is_a_value_and_is_written_back(option, tmp_path):
    (value,) = tomllib.loads(f"{option.key} = {option.example}").values()
    read = option.kind.read(value, tmp_path)
    assert option.kind.read(option.kind.write(read, tmp_path), tmp_path) == read
    with pytest.raises(ValueError):
        option.kind.read({"no": "value"}, tmp_path)


def test_the_template_plans_as_it_is(written):
    values = written(template())
    mission = mission_of(values)
    assert mission.problem.terrain.name == "canyon"
    assert mission.legs == 1
    assert search_of(values).planner == "ga-chip"


def test_the_template_states_one_default_of_a_key():
    text = template().replace("\n# ", " ")
    assert "a URL of pyserial (model:)." in text
    assert "default" not in text.partition("[planner]")[2]
    for option in KEYS:
        if option.default_text:
            stated = re.escape(f"({option.default_text}).")
            assert re.search(rf"{stated}\s+{option.key} = {re.escape(option.example)}", text)


def test_the_template_has_every_key_once():
    """Each key appears with its example, live or commented out."""
    table, found = None, []
    for line in template().splitlines():
        if header := re.fullmatch(r"(?:# )?\[+(\w+)\]+", line):
            table = header[1]
        elif item := re.fullmatch(r"(?:# )?(\w+) = (.*)", line):
            found.append((table, item[1], item[2]))
    assert found == [(option.table, option.key, option.example) for option in KEYS]
    assert max(map(len, template().splitlines())) <= 100


ALL = """
[terrain]
source = "tile.npy"
fill_voids = true
cell = [30, 20]

[mission]
start_geo = [36.3, -84.3, 100]
goal = [4700, 4600, 60]
via = [[2500, 1000, 80], [3000, 3000, 80]]
return = true
agl = true
start_heading = 90
goal_heading = -10.5
wind = [3, -2]
ds = 20

[[zones]]
file = "zones.geojson"

[[zones]]
circle = [2500, 2500, 300]
name = "town"
lower = 200
upper = 900
t0 = 60
t1 = 300

[[zones]]
polygon = [[2000, 2000], [2600, 2000], [2300, 2500]]
holes = [[[2200, 2100], [2400, 2100], [2300, 2300]]]

[aircraft]
file = "mine.toml"

[rules]
clearance = 50
ceiling_agl = 400

[planner]
name = "ga-pc"
generations = 12
seed = 7
refits = 3
init = "astar"

[output]
out = "results"
picture = false
"""


def test_reads_values_and_paths_beside_the_file(written, tmp_path):
    values = written(ALL)
    assert values["terrain"] == str(tmp_path / "tile.npy")
    assert (values["fill_voids"], values["cell"]) == (True, (30.0, 20.0))
    assert values["start_geo"] == (36.3, -84.3, 100.0)
    assert values["via"] == [(2500.0, 1000.0, 80.0), (3000.0, 3000.0, 80.0)]
    assert (values["return_to_start"], values["agl"]) == (True, True)
    assert (values["start_heading"], values["goal_heading"]) == (90.0, -10.5)
    assert values["uav"] == str(tmp_path / "mine.toml")
    assert values["zones"][0] == {"file": str(tmp_path / "zones.geojson")}
    assert values["zones"][1]["circle"] == (2500.0, 2500.0, 300.0)
    assert (values["planner"], values["generations"], values["refits"]) == ("ga-pc", 12, 3)
    assert (values["out"], values["picture"]) == (str(tmp_path / "results"), False)


def test_writes_what_it_reads(written, tmp_path):
    values = written(ALL)
    other = tmp_path / "elsewhere"
    other.mkdir()
    save_problem(other / "copy.toml", values)
    text = (other / "copy.toml").read_text()
    assert 'source = "../tile.npy"' in text
    again = read_problem(other / "copy.toml")
    for name in ("terrain", "uav", "out"):
        again[name], values[name] = Path(again[name]).resolve(), Path(values[name]).resolve()
    for part in (again, values):
        part["zones"][0] = {"file": Path(part["zones"][0]["file"]).resolve()}
    assert again == values


def test_zones_and_aircraft_in_the_file(written):
    text = (
        template()
        + """
[[zones]]
circle = [2500, 2500, 100]
name = "town"
upper = 900

[[zones]]
polygon = [[2000, 2000], [2100, 2000], [2100, 2100]]
"""
    )
    glider = GLIDER.replace("[sources]", "[aircraft.sources]")
    inline = text.replace("[aircraft]", f"[aircraft]\n{glider}")
    problem = mission_of(written(inline)).problem
    assert problem.zones == (
        Circle(2500, 2500, 100, name="town", upper_m=900),
        Polygon(((2000, 2000), (2100, 2000), (2100, 2100))),
    )
    assert problem.aircraft.name == "My glider"
    shipped = text.replace("[aircraft]", '[aircraft]\nname = "heron"')
    assert mission_of(written(shipped)).problem.aircraft.name == "Heron"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[terrian]", "there is no table [terrian] (did you mean terrain?)."),
        ("[weather]", f"there is no table [weather]; known are {', '.join(TABLES)}."),
        ("terrain = 3", "terrain must be a table, [terrain]."),
        ("[mission]\nsart = 3", "there is no key 'sart' in [mission] (did you mean start?)."),
        ("[rules]\nclearence = 3", "there is no key 'clearence' in [rules] "
         "(did you mean clearance?)."),
        ("[planner]\nmax-waypoints = 3",
         "there is no key 'max-waypoints' in [planner] (did you mean max_waypoints?)."),
        ("[aircraft]\nweight = 3", "there is no key 'weight' in [aircraft] "
         "(did you mean weight_N?)."),
        ("[[zones]]\nradius = 3", "there is no key 'radius' in [zones]; known are "
         f"{', '.join(keys_of('zones'))}."),
        ("[mission]\nstart = [1, 2]",
         "start in [mission] must be a list of three numbers, not [1, 2]."),
        ("[mission]\nstart = [1, 2, true]",
         "start in [mission] must be a list of three numbers, not [1, 2, True]."),
        ("[mission]\nagl = 1", "agl in [mission] must be true or false, not 1."),
        ("[mission]\nvia = [1, 2, 3]", "via in [mission] must be a list of points, each a list of "
         "three numbers, not [1, 2, 3]."),
        ("[rules]\nclearance = nan", "clearance in [rules] must be a number, not nan."),
        ("[planner]\nseed = 1.5", "seed in [planner] must be a whole number, not 1.5."),
        ("[planner]\nname = 'best'", "name in [planner] must be one of ga-chip, ga-fpga, "),
        ("[mission]\nstart = [1, 2, 3]\nstart_geo = [1, 2, 3]",
         "[mission] has both start and start_geo; leave one out."),
        ("[zones]\ncircle = [1, 2, 3]", "zones must be tables, [[zones]] once for each."),
        ("[[zones]]\nname = 'x'",
         "[[zones]] number 1 must have one of file, circle, polygon, not none."),
        ("[[zones]]\nfile = 'x'\ncircle = [1, 2, 3]",
         "[[zones]] number 1 must have one of file, circle, polygon, not file and circle."),
        ("[[zones]]\nfile = 'x'\nname = 'y'", "[[zones]] number 1: a file states names and limits "
         "itself; leave name out."),
        ("[[zones]]\ncircle = [1, 2, 3]\nholes = []",
         "[[zones]] number 1: a circle has no holes."),
        ("[aircraft]\nfile = 'x.toml'\nname = 'y'",
         "[aircraft] with a file must have no other key."),
        ("[terrain", "not valid TOML: "),
        ("a = " + "[" * 3000 + "]" * 3000,
         "not valid TOML: tables or arrays are nested too deeply."),
        ("a" + ".a" * 100_000 + " = 1", "not valid TOML: a key has 20 parts or more."),
        ("'a b'" + ". \"c d\"" * 19 + " = 1", "not valid TOML: a key has 20 parts or more."),
        ("[x]\ny = {z = 1, b" + ". b" * 19 + "= 1}", "not valid TOML: a key has 20 parts or more."),
        (
            "\n".join(f"k{n}" + ".a" * 149 + " = 1" for n in range(3000)),
            "not valid TOML: a key has 20 parts or more.",
        ),
        (
            "# " + "x" * 16_000_000,
            "not valid TOML: it has more than 16 MB; put zones into a file of their own.",
        ),
        ("a" + ".a" * 18 + " = 1", "there is no table [a]; "),
        ("a = 0x" + "f" * 5000, "not valid TOML: an integer has more than 64 bits."),
    ],
)  # fmt: skip
def test_refuses_bad_files(written, text, sentence):
    assert refusal(written, text).startswith(sentence)


def test_refuses_what_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"^Cannot read the problem '.*' \(No such file"):
        read_problem(tmp_path / "no.toml")
    (tmp_path / "latin.toml").write_bytes("# é".encode("latin-1"))
    with pytest.raises(InputError, match=r"not a problem file, it is not UTF-8 text\.$"):
        read_problem(tmp_path / "latin.toml")


def test_strings_survive(tmp_path):
    name = 'a "b" \\ é \x7f \t 飛'
    save_problem(tmp_path / "p.toml", {"zones": [{"circle": (1.0, 2.0, 3.5), "name": name}]})
    assert read_problem(tmp_path / "p.toml")["zones"][0]["name"] == name


def test_the_table_of_an_aircraft_survives(written, tmp_path):
    values = written(f"[aircraft]\n{GLIDER.replace('[sources]', '[aircraft.sources]')}")
    save_problem(tmp_path / "copy.toml", values)
    assert read_problem(tmp_path / "copy.toml") == values
    assert values["uav"]["name"] == "My glider"


def test_refuses_a_name_that_no_file_can_hold(tmp_path):
    with pytest.raises(InputError, match=r"^A problem file cannot hold .*udcff.*; rename the fil"):
        problem_text({"terrain": str(tmp_path / "\udcff.npy")}, tmp_path)


def test_the_page_is_the_table():
    """After a change of the options, run ``python -m tools.option_tables``."""
    page = (ROOT / "docs" / "reference.md").read_text()
    (shown,) = re.findall(r"<!-- keys -->\n\n(.*?)\n<!-- end of keys -->", page, flags=re.DOTALL)
    assert shown == markdown()
