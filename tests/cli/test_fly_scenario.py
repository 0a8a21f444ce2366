"""``pathgene fly --popup`` and ``--scenario``."""

import json
import re

import pytest

from pathgene.host.cli import main


def test_a_popup_is_flown_around(straight_flight, tmp_path, capsys):
    arguments = ["fly", straight_flight, "--popup", "ahead:1500,250@30", "--planner", "ga-chip"]
    assert main([*arguments, "--board", "model:", "--out", str(tmp_path)]) == 0
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
