"""``pathgene fly --popup`` and ``--scenario``."""

import json
import re

import numpy as np
import pytest

from pathgene.host.cli import main


CALM = ("--planner", "astar", "--planner-seconds", "0.1", "--json")
# A circle of 300 m across the way, by classes that forbid on demand alone, and one far away.
OPENAIR = """AC E
AN OPEN
AL GND
AH 9000ft MSL
V X=47:01:37 N 008:02:22 E
DC 0.16
AC R
AN FAR
AL GND
AH 9000ft MSL
V X=48:01:37 N 008:02:22 E
DC 0.16
"""


@pytest.fixture(scope="module")
def placed_flight(tmp_path_factory):
    """The summary of a straight plan over level ground that has a place on Earth."""
    folder = tmp_path_factory.mktemp("placed")
    land = folder / "land.npz"
    np.savez(land, elevation=np.full((101, 101), 100.0), dx_m=60.0, dy_m=60.0)
    ends = "--start 800,3000,250 --goal 5200,3000,250 --origin 47,8 --forbid default,E"
    arguments = f"plan --terrain {land} {ends} --planner astar --no-picture --out {folder}"
    assert main(arguments.split()) == 0
    return folder / "summary.json"


@pytest.mark.parametrize("options", [(), ("--forbid", "E")], ids=["of the plan", "of the flight"])
def test_a_file_of_zones_is_read_with_the_options(placed_flight, tmp_path, capsys, options):
    zones = tmp_path / "zones.txt"
    zones.write_text(OPENAIR)
    command = ["fly", placed_flight, "--popup", f"{zones}@30", *options, *CALM, "--out", tmp_path]
    main(list(map(str, command)))
    printed, said = capsys.readouterr()
    flight = json.loads(printed)
    assert re.search(r"30\.0 s: (zone OPEN appears|zones OPEN and FAR appear)\.", said)
    assert flight["changes"][0]["needed"]
    assert "pathgene: Note: zones.txt: 2 zones read as OpenAir; 1 touches the map" in said
    (read,) = flight["read"]["zones"]
    assert read["files"][0]["file"] == str(zones)
    assert all(each["text"] in said for each in read["remarks"])
    assert flight["read"] == json.loads((tmp_path / "flight.json").read_text())["read"]


def test_a_file_of_zones_is_refused_without_the_options(placed_flight, tmp_path, capsys):
    zones = tmp_path / "zones.txt"
    zones.write_text(OPENAIR)
    command = ["fly", placed_flight, "--popup", f"{zones}@30", "--forbid", "R", *CALM]
    assert main(list(map(str, command))) == 2
    assert "is on the map and forbids flight" in capsys.readouterr().err
    zones.write_text(OPENAIR.replace("DC 0.16", "DC none", 1))
    command = ["fly", placed_flight, "--popup", f"{zones}@30", *CALM]
    assert main(list(map(str, command))) == 2
    assert "--skip-bad-zones reads the" in capsys.readouterr().err


def test_a_popup_is_flown_around(straight_flight, tmp_path, capsys):
    arguments = ["fly", straight_flight, "--popup", "ahead:1500,250@30", "--planner", "ga-chip"]
    board = ("--board", "model:", "--planner-seconds", "0.007")
    assert main([*arguments, *board, "--out", str(tmp_path)]) == 0
    out, said = capsys.readouterr()
    assert re.search(r"^at 30 s +a zone appears: new path after 1\d\.\d ms, 0\.\d\d m", out, re.M)
    assert out.startswith("kept ")
    assert "30.0 s: a zone appears." in said
    assert {file.name for file in tmp_path.iterdir()} == {
        "flight.json",
        "flight.png",
        "flight.gif",
    }


@pytest.mark.ci
def test_a_flight_is_repeated_with_the_measured_share_of_the_host(straight_flight, tmp_path, capfd):
    arguments = ["fly", straight_flight, "--popup", "ahead:1500,250@30", "--planner", "ga-chip"]
    arguments += ["--board", "model:", "--json", "--out", str(tmp_path)]
    assert main(arguments) == 0
    out, said = capfd.readouterr()
    measured = json.loads(out)
    (share,) = re.findall(r"on this machine; --planner-seconds (\S+) repeats", said)
    assert measured["processor_ms"] == 1000 * float(share)
    (attempt,) = measured["changes"][0]["attempts"]
    assert attempt["host_ms"] == measured["processor_ms"]
    assert main([*arguments, "--planner-seconds", share]) == 0
    again, said = capfd.readouterr()
    assert json.loads(again) == measured
    assert "on this machine" not in said


@pytest.mark.ci
def test_a_scenario_and_json_alone(straight_flight, tmp_path, capfd):
    file = tmp_path / "storm.toml"
    file.write_text('[[event]]\nat_s = 40\nappear = [{on = "goal", radius_m = 200}]\n')
    arguments = ["fly", straight_flight, "--scenario", str(file), "--planner", "astar", "--json"]
    assert main([*arguments, "--planner-seconds", "0.2", "--out", str(tmp_path / "o")]) == 1
    table = json.loads(capfd.readouterr().out)
    assert (table["ended"], table["alive"], table["processor_ms"]) == ("holding", True, 200)
    assert table["scenario"] == str(file)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--popup", "here@4"], "The zone of --popup must be"),
        (["--scenario", "none.toml"], "Cannot read the scenario"),
        (["--popup", "goal:9@4", "--aircraft", "c172p"], "leave --aircraft out"),
        (["--popup", "goal:9@4", "--wind", "1,2"], "give another in a scenario"),
        (["--popup", "goal:9@4", "--planner-seconds", "-1"], "must be 0 or more"),
        (["--popup", "goal:9@4", "--planner", "none"], "planner"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(straight_flight, capsys, options, sentence):
    assert main(["fly", straight_flight, *options]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
