"""``pathgene diagnose``: exit status, sentence and JSON."""

import json

import pytest

from host.cli import main

from .conftest import ENDS, WALL


@pytest.fixture
def diagnosed(hills, capsys):
    """Function that runs the command; returns the status, standard output and the last sentence."""

    def run(*options):
        status = main(["diagnose", "--terrain", str(hills), *ENDS, *options])
        said = capsys.readouterr()
        return status, said.out, said.err.splitlines()[-1:]

    return run


def test_connected(diagnosed):
    status, out, said = diagnosed()
    assert (status, said) == (0, [])
    assert out.split() == ["connected", "yes,", "astar", "finds", "a", "feasible", "path"]
    status, out, _ = diagnosed("--json")
    report = json.loads(out)
    assert (status, report["connected"], report["reason"]) == (0, True, None)


def test_closed(diagnosed):
    sentence = (
        "No way leads from the start to the goal at any altitude: the edge of the map, zone 1, "
        "zone 2, zone 3 and 8 more enclose the goal, and must open near (3000, 2000) m."
    )
    status, out, said = diagnosed(*WALL)
    assert (status, said) == (1, [f"pathgene: {sentence}"])
    assert out.splitlines()[:2] == ["connected  no", "reason     closed"]
    status, out, _ = diagnosed(*WALL, "--json")
    report = json.loads(out)
    assert (status, report["connected"], report["leg"]) == (1, False, None)
    reason = report["reason"]
    assert (reason["code"], reason["sentence"]) == ("closed", sentence)
    assert reason["ring"]


def test_leg_without_a_way(diagnosed):
    status, _, said = diagnosed(*WALL, "--via", "1500,2500,100")
    assert status == 1
    assert said[0].startswith(
        "pathgene: Leg 2, from via point 1 to the goal: No way leads from the start to the goal"
    )


def test_bad_input(diagnosed):
    status, out, said = diagnosed("--ceiling", "nan")
    assert (status, out) == (2, "")
    assert said == ["pathgene: The ceiling must be a finite number, not nan."]
