"""Bad input: exit status 2 and one sentence with a remedy."""

import json
import socket

import numpy as np
import pytest

from pathgene.hdl.protocol.codec import VERSION
from pathgene.hdl.protocol.messages import info_values
from pathgene.host.cli import main
from pathgene.host.cli.output import LONGEST_LINE
from tests.support.bad_input.good_inputs import summary, write_base

from .conftest import ENDS


def refused(capsys, *arguments):
    """Return the sentence of a command that must fail with status 2."""
    assert main([str(argument) for argument in arguments]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    lines = output.err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("pathgene: ")
    return lines[0].removeprefix("pathgene: ")


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ["--start", "500,500,100"],
            "The goal is missing; give --goal or --goal-geo.",
        ),
        (
            ["--goal", "500,500,100"],
            "The start is missing; give --start or --start-geo.",
        ),
        (
            ["--start", "-500,500,900", "--goal", "5500,3500,900"],
            "The start at (-500, 500) is outside the map, which reaches from (0, 0) to "
            "(6000, 4000) m.",
        ),
        (
            ["--start", "500,500,900", "--goal", "5500,4000.1,900"],
            "The goal at (5500, 4000.1) is outside the map, which reaches from (0, 0) to "
            "(6000, 4000) "
            "m.",
        ),
        (
            ["--start", "500,500,1", "--goal", "5500,3500,900"],
            "The start at an altitude of 1 m is inside the ground, which is at ",
        ),
        (
            ["--start", "500,500,900", "--goal", "500,500,900"],
            "Start and goal are the same point; move one of them.",
        ),
        (
            ["--start", "500,500,900", "--goal", "5500,200,900"],
            "The goal at (5500, 200) is over a void of the terrain; move it, or fill the "
            "voids (--fill-voids).",
        ),
        (
            ["--start", "nan,500,900", "--goal", "5500,3500,900"],
            "Argument --start: must be finite numbers X,Y,Z, not 'nan,500,900'; ",
        ),
        (
            ["--start", "500,500,900", "--goal", "5500,3500,-inf"],
            "Argument --goal: must be finite numbers X,Y,Z, not '5500,3500,-inf'; ",
        ),
        (
            ["--start", "500,500,9000", "--goal", "5500,3500,9000"],
            "The start's altitude of 9000 m is above the ",
        ),
        (
            ["--start-geo", "46,8,900", "--goal", "5500,3500,900"],
            "The terrain 'hills' has no coordinate reference system, so latitude and "
            "longitude have no "
            "meaning on it; give local metres.",
        ),
        (
            [*ENDS, "--nofly-circle", "500,500,50"],
            "The start at (500, 500) is inside a no-fly zone; move it or the zone.",
        ),
        (
            [*ENDS, "--nofly-circle", "3000,2000,-400"],
            "No-fly circle: radius_m must not be negative, not -400.",
        ),
        (
            [*ENDS, "--nofly-circle", "3000,nan,400"],
            "Argument --nofly-circle: must be finite numbers X,Y,R, not '3000,nan,400'; ",
        ),
        ([*ENDS, "--uav", ""], "The name of a UAV file must end in .toml, unlike ''; shipped are "),
        (
            [*ENDS, "--ds", "0.002"],
            "A sampling step of 0.002 m makes more than 500,000 samples of the way from start to "
            "goal; increase it to 0.013 m.",
        ),
        ([*ENDS, "--max-cells", "100"], "{hills}: its 41 x 61 cells are more than 100; cut it, "),
        (
            [*ENDS, "--nofly-circle", "1e308,1e308,1e308"],
            "No-fly circle: no coordinate or radius may exceed 1e+09 m, unlike 1e+308; give ",
        ),
        ([*ENDS, "--seed", "9" * 5000], "Argument --seed: invalid int value: '" + "9" * 99 + "..."),
        ([*ENDS, "--nofly", "nowhere.geojson"], "Cannot read no-fly file 'nowhere.geojson': "),
        (
            [*ENDS, "--planner", "fpa", "--waypoints", "0"],
            "The number of waypoints must be from 1 to 100, not 0.",
        ),
        (
            [*ENDS, "--planner", "fpa-2opt", "--two-opt-every", "-1"],
            "The iterations between 2-opts must be 0 or more, not -1.",
        ),
        (
            [*ENDS, "--planner", "ga-pc", "--refits", "-1"],
            "The refits of a generation must be 0 or more, not -1.",
        ),
        (
            [*ENDS, "--planner", "ga-dp", "--reading", "both"],
            "Argument --reading: there is no choice 'both'; choose from ",
        ),
        (
            [*ENDS, "--planner", "ga-auv", "--draws", "far"],
            "Argument --draws: there is no choice 'far'; choose from ",
        ),
        (
            [*ENDS, "--planner", "fpa", "--init", "rrt"],
            "Argument --init: there is no choice 'rrt'; choose from ",
        ),
        (
            [*ENDS, "--planner", "fpa", "--engine", "tpu"],
            "Argument --engine: there is no choice 'tpu' (did you mean gpu?); choose from ",
        ),
        (
            [*ENDS, "--planner", "a-star"],
            "There is no planner 'a-star' (did you mean astar?); the planners are ga-chip, ",
        ),
        (
            [*ENDS, "--link-mode", "recipe"],
            "The default planner, ga-chip, has no option link_mode (--link-mode); name a planner ",
        ),
        ([*ENDS, "--uav", "kite"], "There is no UAV 'kite'; give one of "),
        ([*ENDS, "--wind", "-30,0"], "A wind of 30 m/s is not below the airspeed of "),
        ([*ENDS, "--ds=--"], "Argument --ds: must have a value, not '--'; see pathgene --help."),
        ([*ENDS, "--ds", "-1"], "The sampling step must be a positive number of metres, not -1."),
        ([*ENDS, "--ds", "nan"], "The sampling step must be a positive number of metres, not nan."),
        (
            [*ENDS, "--ds", "1e9"],
            "The sampling step of 1e+09 m is longer than the way from start to goal, ",
        ),
        (
            [*ENDS, "--cell", "30"],
            "{hills}: the file states the size of its cells; leave it out (--cell).",
        ),
        ([*ENDS, "--seed", "-1"], "The seed must be from 0 to 2**64 - 1, not -1."),
        ([*ENDS, "--generations", "0"], "The number of generations must be 1 or more, not 0."),
        (
            [*ENDS, "--time-limit", "nan"],
            "The time limit must be a positive number of seconds, not nan.",
        ),
        (
            [*ENDS, "--target-fitness", "inf"],
            "The target fitness must be a finite number, not inf.",
        ),
        ([*ENDS, "--population", "40"], "The population of this board is 32, not 40; "),
        (
            [*ENDS, "--population", "4", "--planner", "ga-pc"],
            "The population of ga-pc must be from 8 to 100000, not 4.",
        ),
        (
            [*ENDS, "--population", "1000000000", "--planner", "ga-pc"],
            "The population of ga-pc must be from 8 to 100000, not 1000000000.",
        ),
        (
            [*ENDS, "--planner", "ga-fpga", "--initial-draws", "1000000000"],
            "The initial draws must be from 1 to 1000, not 1000000000.",
        ),
        ([*ENDS, "--uav", __file__], "The name of a UAV file must end in .toml, unlike "),
        ([*ENDS, "--board", "/dev/nowhere"], "No board can be opened at '/dev/nowhere' ("),
        ([*ENDS, "--board", "model:?population=33"], "Config.population must be a power of two "),
        ([*ENDS, "--board", "model:?core=none"], "This board has no genetic core, "),
        (
            [*ENDS, "--board", "model:?core=paper", "--planner", "ga-chip"],
            "This board has no planner core, so it does not plan by itself; ",
        ),
        (
            [*ENDS, "--board", "model:?core=planner", "--planner", "ga-fpga"],
            "This board has the planner core, which breeds without the host; ",
        ),
        (
            [*ENDS, "--board", "model:?speed=9"],
            "The model takes only port and fields of the configuration, ",
        ),
    ],
)
def test_plan_refuses_bad_options(hills, tmp_path, capsys, options, sentence):
    out = tmp_path / "out"
    said = refused(capsys, "plan", "--terrain", hills, *options, "--out", out)
    assert said.startswith(sentence.replace("{hills}", str(hills)))
    assert not out.exists() or not list(out.iterdir())


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("missing.tif", None),
        ("text.tif", b"no raster"),
        ("text.npz", b"no archive"),
        ("empty.hgt", b""),
    ],
)
def test_plan_refuses_an_unreadable_terrain(tmp_path, capsys, name, content):
    file = tmp_path / name
    if content is not None:
        file.write_bytes(content)
    assert name in refused(capsys, "plan", "--terrain", file, *ENDS, "--out", tmp_path / "out")


def test_plan_refuses_a_void_terrain(tmp_path, capsys):
    file = tmp_path / "void.npz"
    np.savez(file, elevation=np.full((9, 9), np.nan), dx_m=9.0, dy_m=9.0)
    assert "every node is void" in refused(capsys, "plan", "--terrain", file, *ENDS)


def test_plan_refuses_an_array_without_cell_sides(tmp_path, capsys):
    file = tmp_path / "hills.npy"
    np.save(file, np.zeros((9, 9)))
    assert "--cell" in refused(capsys, "plan", "--terrain", file, *ENDS)


def test_plan_refuses_an_unwritable_folder(hills, tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    sentence = refused(capsys, "plan", "--terrain", hills, *ENDS, "--out", blocked / "out")
    assert sentence == (
        f"Cannot write to the directory {str(blocked / 'out')!r} (Not a "
        "directory); give another (--out)."
    )


def test_refuses_a_silent_board(hills, capsys, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"socket://127.0.0.1:{server.getsockname()[1]}?patience=2"
        assert refused(capsys, "board", "info", "--board", url).startswith("Nothing answers at")
        sentence = refused(
            capsys, "plan", "--terrain", hills, *ENDS, "--board", url, "--out", tmp_path / "out"
        )
        assert sentence.startswith("Nothing answers at")


def test_refuses_a_board_of_another_protocol(hills, capsys, tmp_path, monkeypatch):
    """The board's version is checked before any other request."""
    monkeypatch.setitem(info_values.__globals__, "VERSION", VERSION + 1)
    sentence = refused(
        capsys, "plan", "--terrain", hills, *ENDS, "--board", "model:", "--out", tmp_path / "out"
    )
    assert sentence == (
        f"The board speaks protocol version {VERSION + 1}, this host version {VERSION}: "
        "load a bitstream of this release, or use the release the board was built with."
    )


def test_serve_refuses_a_busy_address(capsys):
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        assert refused(capsys, "board", "serve", "--listen", address) == (
            f"Nothing can listen at {address!r} (Address already in use); give another --listen."
        )


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("missing.csv", None, "Cannot read the path "),
        ("path.csv", "a,b,c\n1,2,3\n", "{}: the first line must be the header x,y,z."),
        ("path.csv", "lat,lon,alt\n1,2,3\n", "{}: a line needs two rows or more."),
        (
            "path.csv",
            "x,y,z\n500,500,900\n5500,north,900\n",
            "{}, line 3: must be three finite numbers x,y,z, not '5500,north,900'.",
        ),
        ("path.csv", "x,y,z\n500,500,900\n9500,3500,900\n", "The goal at (9500, 3500) is outside "),
        ("path.geojson", "{", "{}: not JSON; give GeoJSON, a CSV or a summary."),
        (
            "path.json",
            '{"waypoints": [[1, 2], [3, 4]]}',
            "{}: the summary does not say how its path was evaluated; give --terrain and the other "
            "options.",
        ),
    ],
)
def test_check_refuses_bad_paths(hills, tmp_path, capsys, name, content, sentence):
    file = tmp_path / name
    if content is not None:
        file.write_text(content)
    said = refused(capsys, "check", "--terrain", hills, "--path", file)
    assert said.startswith(sentence.replace("{}", str(file)))


def test_check_misses_the_path_before_the_terrain(tmp_path, capsys):
    file = tmp_path / "missing.json"
    assert refused(capsys, "check", "--path", file) == (
        f"Cannot read the path '{file}' (No such file or directory)."
    )


def test_check_refuses_a_path_without_terrain(tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,900\n5500,3500,900\n")
    assert (
        refused(capsys, "check", "--path", file)
        == "The terrain is missing; give --terrain (jacksboro, canyon, river, large-canyon "
        "or a file)."
    )


def test_check_refuses_another_start(hills, tmp_path, capsys):
    file = tmp_path / "path.csv"
    file.write_text("x,y,z\n500,500,900\n5500,3500,900\n")
    said = refused(capsys, "check", "--terrain", hills, "--path", file, "--start", "500,600,900")
    assert said == (
        "The start of the path is (500.0, 500.0, 900.0), not (500.0, 600.0, 900.0); "
        "leave --start out."
    )


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ["board", "serve", "--board", "/dev/ttyUSB7"],
            "Only a simulated board can be served, sim: or model: with its options, not "
            "'/dev/ttyUSB7'.",
        ),
        (
            ["board", "serve", "--listen", "5000"],
            "The address to listen at must be HOST:PORT, not '5000'.",
        ),
        (
            ["board", "serve", "--listen", "localhost:70000"],
            "The address to listen at must be HOST:PORT, not 'localhost:70000'.",
        ),
        (
            # As bytes that are not UTF-8 arrive.
            ["board", "serve", "--listen", "\udcff\udcfe:1"],
            "The address to listen at must be HOST:PORT, not '\\udcff\\udcfe:1'.",
        ),
        (
            ["board", "serve", "--listen", "no.such.host.invalid:0"],
            "Nothing can listen at 'no.such.host.invalid:0' (",
        ),
        (
            ["board", "info", "--board", "/dev/nowhere"],
            "No board can be opened at '/dev/nowhere' (",
        ),
        (["verilog", "--top", "engine", "--out", "x.v"], "There is no top 'engine'; the tops are "),
        (
            ["verilog", "--top", "chip", "--out", "x.v", "--set", "wings=2"],
            "The configuration has no field 'wings'; the fields are population, ",
        ),
        (
            ["verilog", "--top", "chip", "--out", "x.v", "--set", "population=33"],
            "A --set is wrong: Config.population must be ",
        ),
        (
            ["terrain", "synth", "canyon", "--out", "canyon.tif"],
            "The file of a terrain must end in .npz, unlike 'canyon.tif'.",
        ),
        (
            ["terrain", "synth", "canyon", "--seed", "-3", "--out", "canyon.npz"],
            "The seed must be 0 or more, not -3.",
        ),
    ],
)
def test_other_commands_refuse_bad_options(capsys, arguments, sentence):
    assert refused(capsys, *arguments).startswith(sentence)


def test_a_terrain_is_not_written_to_a_folder(capsys, tmp_path):
    folder = tmp_path / "canyon.npz"
    folder.mkdir()
    said = refused(capsys, "terrain", "synth", "canyon", "--out", folder)
    assert said == f"{str(folder)!r} is a directory; give the name of a file."
    assert not list(folder.iterdir())


@pytest.mark.parametrize("key", ["rules", "nofly", "as_paper"])
def test_a_long_list_is_not_repeated(tmp_path, monkeypatch, capsys, key):
    (tmp_path / "base").mkdir()
    (tmp_path / "out").mkdir()
    write_base(tmp_path / "base")
    monkeypatch.chdir(tmp_path / "out")
    wrong = {"x": [1] * 5000} if key == "nofly" else [1] * 5000
    (tmp_path / "out" / "summary.json").write_text(json.dumps({**summary(), key: wrong}))
    sentence = refused(capsys, "check", "--path", "summary.json")
    assert sentence.startswith(f"summary.json: {key} must be ")
    assert len(sentence) <= LONGEST_LINE
