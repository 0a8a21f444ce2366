"""The known name that a wrong name probably stands for."""

import pytest

from pathgene.host.cli import main
from pathgene.host.suggestion import did_you_mean


def test_names_the_nearest():
    assert did_you_mean("astarr", ["ga-pc", "astar"]) == " (did you mean astar?)"
    assert did_you_mean("JACKSBORO", ["canyon", "Jacksboro"]) == " (did you mean Jacksboro?)"
    assert did_you_mean("--gen", ["--end", "--generations"]) == " (did you mean --generations?)"
    assert did_you_mean(5, ["ga-pc", "astar"]) == ""
    assert did_you_mean("nothing", ["ga-pc", "astar"]) == ""


@pytest.mark.parametrize(
    ("arguments", "question"),
    [
        ("plann", "(did you mean plan?)"),
        ("plan --terain jacksboro", "unrecognized argument --terain (did you mean --terrain?)"),
        ("plan --terain=jacksboro", "(did you mean --terrain?)"),
        ("plan --terrain jackboro --start 1,1,1 --goal 2,2,2", "(did you mean jacksboro?)"),
        ("plan --terrain canyon --planner astarr", "(did you mean astar?)"),
        ("plan --terrain canyon --write plann", "(did you mean plan?)"),
        ("plan --uav silverfox --start 1,1,1 --goal 2,2,2", "(did you mean silver-fox?)"),
        ("fly summary.json --aircraft c17p", "(did you mean c172p?)"),
        ("compare --planners ga-pcs --terrain canyon", "(did you mean ga-pc?)"),
        ("verilog --top chipp --out chip.v", "(did you mean chip?)"),
        ("board info --board sim:?cores=planner", "(did you mean core?)"),
    ],
)
def test_commands_ask(arguments, question, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments.split()) == 2
    told = capsys.readouterr().err.lower()
    assert question in told


def test_a_missing_terrain_is_named_with_its_choices(capsys):
    assert main(["plan"]) == 2
    assert "give --terrain (jacksboro, canyon," in capsys.readouterr().err
