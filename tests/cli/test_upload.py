"""``pathgene upload``, to MAVSDK's autopilot over UDP."""

import json
import os
import re
import signal
from functools import partial
from importlib import metadata

import pytest

from pathgene.host.cli import main
from pathgene.host.mission.autopilot import mavlink_link
from tests.cli.conftest import WALL, last_line, plan
from tests.support.host.earth import single
from tests.unit.mission.autopilot.mavsdk_autopilot import Autopilot, Proxy, free_port
from tests.unit.mission.autopilot.own_autopilot import OwnAutopilot


@pytest.fixture(scope="module")
def flown(hills, tmp_path_factory):
    """Return the folder of a plan with a fence."""
    out = tmp_path_factory.mktemp("flown")
    options = ("--planner", "astar", "--no-picture", "--origin", "46.1,7.6", "--write", "plan")
    assert plan(hills, out, *options, "--as-paper") == 0
    return out


@pytest.fixture(scope="module")
def autopilot():
    server = Autopilot()
    yield server
    server.close()


@pytest.mark.parametrize("name", ["summary.json", "path.plan"])
def test_uploads_a_plan_and_its_fence(flown, autopilot, capsys, name):
    autopilot.received.clear()
    assert main(["upload", str(flown / name), "--to", autopilot.address, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    items = json.loads((flown / "path.plan").read_text())["mission"]["items"]
    assert report["mission_items"] == len(items)
    assert (report["fence_items"], report["fences"], report["equal"]) == (1, 1, True)
    assert report["to"] == autopilot.address
    fence, mission = autopilot.received
    assert [item.command for item in fence] == [5004]
    for item, wanted in zip(mission, items, strict=True):
        lat, lon, alt = wanted["params"][4:]
        assert (item.x, item.y, item.z) == (round(lat * 1e7), round(lon * 1e7), single(alt))


def test_prints_what_the_autopilot_has(flown, autopilot, capsys):
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "autopilot  autopilot of kind 0, system 1"
    assert lines[1].endswith(" items, read back equal")
    assert lines[2] == "fence      1 circles and 0 polygons, read back equal"


def test_nobody_there_is_one_sentence(flown, capsys):
    to = f"udpout:127.0.0.1:{free_port()}"
    assert main(["upload", str(flown / "path.plan"), "--to", to, "--timeout", "0.2"]) == 1
    assert capsys.readouterr().err == (
        f"pathgene: No autopilot answers at {to} within 0.2 s; check the address, the link and "
        "the autopilot (--timeout).\n"
    )


def test_a_path_that_is_not_feasible_stays_here(flown, tmp_path, capsys):
    summary = json.loads((flown / "summary.json").read_text())
    file = tmp_path / "summary.json"
    file.write_text(json.dumps(summary | {"feasible": False}))
    (tmp_path / "terrain.npz").write_bytes((flown / "terrain.npz").read_bytes())
    arguments = ["upload", str(file), "--to", f"udpout:127.0.0.1:{free_port()}"]
    assert main(arguments) == 1
    assert last_line(capsys.readouterr().err) == (
        f"pathgene: {file}: the path is not feasible, so nothing is uploaded; plan again, or give "
        "--infeasible.\n"
    )
    assert main([*arguments, "--infeasible", "--timeout", "0.1"]) == 1
    assert "No autopilot answers" in capsys.readouterr().err


def test_a_plan_file_of_a_path_that_is_not_feasible_stays_here_too(
    flown, autopilot, tmp_path, capsys
):
    summary = json.loads((flown / "summary.json").read_text())
    (tmp_path / "summary.json").write_text(json.dumps(summary | {"feasible": False}))
    (tmp_path / "terrain.npz").write_bytes((flown / "terrain.npz").read_bytes())
    assert main(["export", str(tmp_path / "summary.json"), "--write", "plan"]) == 0
    capsys.readouterr()
    file = tmp_path / "path.plan"
    arguments = ["upload", str(file), "--to", autopilot.address]
    assert main(arguments) == 1
    assert last_line(capsys.readouterr().err) == (
        f"pathgene: {file}: the path is not feasible, so nothing is uploaded; plan again, or give "
        "--infeasible.\n"
    )
    assert main([*arguments, "--infeasible"]) == 0

    # A ground station only saves its own members.
    document = json.loads(file.read_text())
    del document["pathgene"]
    file.write_text(json.dumps(document))
    assert main(arguments) == 0


def test_plan_states_the_verdict_in_its_file(flown, hills, tmp_path):
    stated = json.loads((flown / "path.plan").read_text())["pathgene"]
    assert stated == {"version": metadata.version("pathgene"), "feasible": True}
    options = ("--planner", "ga-pc", "--generations", "1", "--no-picture", "--origin", "46.1,7.6")
    assert plan(hills, tmp_path, *options, *WALL, "--as-paper", "--write", "plan") == 1
    assert not json.loads((tmp_path / "path.plan").read_text())["pathgene"]["feasible"]


@pytest.mark.ci
def test_a_broken_connection_is_one_sentence_and_the_next_upload_succeeds(
    flown, autopilot, capsys, monkeypatch
):
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address]) == 0
    items = len(json.loads((flown / "path.plan").read_text())["mission"]["items"])
    # Heartbeat, both lists, the new fence and its verification; then the mission begins.
    proxy = Proxy(autopilot.port, 1 + 2 + 1 + items + 2 + 2 + items // 2)
    with monkeypatch.context() as patience:
        patience.setattr(mavlink_link, "open_link", partial(mavlink_link.open_link, answer_s=0.5))
        assert main(["upload", str(flown / "path.plan"), "--to", proxy.address]) == 1
    proxy.close()
    captured = capsys.readouterr()
    assert captured.out.count("read back equal") == 2  # Only the first upload.
    assert re.fullmatch(
        r"pathgene: The autopilot fell silent at item \d+ of \d+ of the mission; the autopilot now "
        r"holds an unknown mission, .*, and an unknown fence, .*; do not fly before an upload "
        r"succeeds\.\n",
        captured.err,
    )
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address]) == 0


def test_an_interrupted_upload_leaves_the_earlier_mission(flown, capsys):
    own = OwnAutopilot()
    own.kind = 3
    arguments = ["upload", str(flown / "path.plan"), "--to", own.address]
    try:
        assert main(arguments) == 0
        before = {kind: list(items) for kind, items in own.lists.items()}
        capsys.readouterr()

        def interrupt(message):
            if message.get_type() == "MISSION_ITEM_INT" and message.seq == 5:
                own.breaks = lambda _message: None
                os.kill(os.getpid(), signal.SIGTERM)

        own.breaks = interrupt
        assert main(arguments) == 128 + signal.SIGTERM
    finally:
        own.close()
    items = len(before[0])
    assert capsys.readouterr().err == (
        "pathgene: The upload is interrupted; the autopilot now holds its earlier mission "
        f"({items} items), and its earlier fence (1 items); upload again.\n"
    )
    assert [item.x for item in own.lists[0]] == [item.x for item in before[0]]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--to", "logs.tlog"], "There is no autopilot at 'logs.tlog': give udpout:HOST:PORT"),
        (["--to", "udpout:127.0.0.1:1", "--timeout", "nan"], "--timeout must be a positive number"),
        (["--to", "udpout:127.0.0.1:1", "--origin", "1,2"], "A .plan file has its place on Earth;"),
        ([], "The following arguments are required: --to; see pathgene upload --help."),
    ],
)
def test_bad_input_is_one_sentence(flown, capsys, options, sentence):
    assert main(["upload", str(flown / "path.plan"), *options]) == 2
    assert capsys.readouterr().err.startswith(f"pathgene: {sentence}")
