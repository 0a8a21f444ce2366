"""``pathgene upload``, to MAVSDK's autopilot over UDP."""

import json
import math
import os
import re
import signal
import socket
import threading
from functools import partial
from importlib import metadata

import pytest
from pymavlink.dialects.v20 import common as mavlink

from pathgene.host.cli import main
from pathgene.host.mission.autopilot import mavlink_link
from pathgene.sim.autopilot.autopilot import Autopilot as SimulatedAutopilot
from pathgene.sim.autopilot.autopilot import Start
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot.served import Served
from tests.cli.conftest import WALL, last_line, plan
from tests.support.host.earth import single
from tests.unit.mission.autopilot.mavsdk_autopilot import Autopilot, Proxy, free_port
from tests.unit.mission.autopilot.own_autopilot import OwnAutopilot


# The system of MAVSDK's autopilot; without it, the command waits for more heartbeats.
ONE = ("--system", "1")


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
    assert main(["upload", str(flown / name), "--to", autopilot.address, *ONE, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    items = json.loads((flown / "path.plan").read_text())["mission"]["items"]
    assert report["mission_items"] == len(items)
    assert (report["fence_items"], report["fences"], report["equal"]) == (1, 1, True)
    assert report["to"] == autopilot.address
    fence, rally, mission = autopilot.received
    points = json.loads((flown / "path.plan").read_text())["rallyPoints"]["points"]
    assert [item.z for item in rally] == [height for _, _, height in points]
    assert report["rally_points"] == len(points)
    assert [item.command for item in fence] == [5004]
    for item, wanted in zip(mission, items, strict=True):
        lat, lon, alt = wanted["params"][4:]
        assert (item.x, item.y, item.z) == (round(lat * 1e7), round(lon * 1e7), single(alt))


def test_prints_what_the_autopilot_has(flown, autopilot, capsys):
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address, *ONE]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "autopilot     autopilot of kind 0, system 1"
    assert lines[1].endswith(" items, read back equal")
    assert lines[2] == "fence         1 circles and 0 polygons, read back equal"
    assert lines[3] == "rally points  4, read back equal"


def test_nobody_there_is_one_sentence(flown, capsys):
    to = f"udpout:127.0.0.1:{free_port()}"
    assert main(["upload", str(flown / "path.plan"), "--to", to, "--timeout", "0.2"]) == 1
    assert capsys.readouterr().err == (
        f"pathgene: No autopilot answers at {to} within 0.2 s; check the address, the link and "
        "the autopilot (--timeout).\n"
    )


@pytest.fixture
def crowd():
    """Yield a port to which the autopilots of systems 3 and 8 send their heartbeats."""
    port, closed = free_port(), threading.Event()

    def beat():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while not closed.wait(0.05):
                for system in (8, 3):
                    message = mavlink.MAVLink_heartbeat_message(1, 3, 0, 0, 3, 3)
                    packed = message.pack(mavlink.MAVLink(None, system, 1))
                    sender.sendto(packed, ("127.0.0.1", port))

    thread = threading.Thread(target=beat)
    thread.start()
    yield port
    closed.set()
    thread.join()


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        ((), "Autopilots of systems 3 and 8 answer; choose one with --system."),
        (
            ("--system", "5"),
            "System 5 does not answer at {} within 0.3 s, but 3, 8 does; choose another one with "
            "--system, or check the link.",
        ),
        (("--system", "256"), "--system must be from 1 to 255, not 256."),
    ],
)
def test_two_systems_are_named(flown, crowd, capsys, chosen, sentence):
    to = f"udpin:127.0.0.1:{crowd}"
    arguments = ["upload", str(flown / "path.plan"), "--to", to, "--timeout", "0.3", *chosen]
    assert main(arguments) == 1 + ("256" in chosen)
    assert last_line(capsys.readouterr().err) == f"pathgene: {sentence.format(to)}\n"


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
    arguments = ["upload", str(file), "--to", autopilot.address, *ONE]
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
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address, *ONE]) == 0
    # The fence is uploaded and verified before.
    proxy = Proxy(
        autopilot.port,
        lambda message: (
            message.get_type() in {"MISSION_REQUEST", "MISSION_REQUEST_INT"}
            and (message.mission_type, message.seq) == (mavlink.MAV_MISSION_TYPE_MISSION, 3)
        ),
    )
    with monkeypatch.context() as patience:
        patience.setattr(mavlink_link, "open_link", partial(mavlink_link.open_link, answer_s=0.5))
        assert main(["upload", str(flown / "path.plan"), "--to", proxy.address, *ONE]) == 1
    proxy.close()
    captured = capsys.readouterr()
    assert captured.out.count("read back equal") == 3  # Only the first upload.
    assert re.fullmatch(
        r"pathgene: The autopilot fell silent at item \d+ of \d+ of the mission; the autopilot "
        r"held, when it last answered, an unknown mission, .*, the new fence .*; do not fly before "
        r"an upload succeeds\.\n",
        captured.err,
    )
    assert main(["upload", str(flown / "path.plan"), "--to", autopilot.address, *ONE]) == 0


@pytest.fixture
def plane():
    """Yield ArduPlane on UDP, on the ground at the start of the mission."""
    served = Served(SimulatedAutopilot(Kind.ARDUPLANE, Start((46.1, 7.6, 500.0), armed=False)))
    served.start()
    yield served
    served.close()


def test_parameters_are_explained_and_set_if_the_user_wants_it(flown, plane, capsys):
    parameters = plane.autopilot.parameters
    arguments = ["upload", "--to", f"udpout:127.0.0.1:{plane.port}", *ONE, "--json"]
    assert main([*arguments, str(flown / "summary.json")]) == 0
    captured = capsys.readouterr()
    report = json.loads(captured.out)["parameters"]
    assert (report["read"]["FENCE_ENABLE"], report["set"]) == (0, False)
    assert report["advised"]["FENCE_ENABLE"] == 1
    assert (
        "pathgene: FENCE_ENABLE is 0, so the fences do nothing; 1 enables them.\n" in captured.err
    )
    assert "or upload again with --set-parameters.\n" in captured.err
    assert parameters["FENCE_ENABLE"] == 0
    assert main([*arguments, str(flown / "summary.json"), "--set-parameters"]) == 0
    captured = capsys.readouterr()
    report = json.loads(captured.out)["parameters"]
    assert report["set"]
    assert {name: parameters[name] for name in report["advised"]} == report["advised"]
    assert ", read back equal.\n" in captured.err
    assert main([*arguments, str(flown / "path.plan")]) == 0
    assert "A .plan file has no terrain, so the return height" in capsys.readouterr().err


def test_a_mission_that_will_not_start_is_said_so(flown, capsys):
    served = Served(SimulatedAutopilot(Kind.PX4, Start((46.1, 7.6, 500.0), armed=False)))
    served.start()
    to = f"udpout:127.0.0.1:{served.port}"
    try:
        assert main(["upload", str(flown / "path.plan"), "--to", to, *ONE, "--json"]) == 1
    finally:
        served.close()
    captured = capsys.readouterr()
    reason = "Mission rejected: Landing waypoint/pattern required."
    assert json.loads(captured.out)["will_start"] is False
    assert json.loads(captured.out)["texts"] == [reason]
    read = json.loads(captured.out)["parameters"]["read"]
    assert read.keys() == {
        *("GF_ACTION", "RTL_RETURN_ALT", "NAV_FW_ALT_RAD", "FW_T_ALT_TC", "FW_T_CLMB_R_SP")
    }
    assert f'pathgene: The autopilot says "{reason}".\n' in captured.err
    assert captured.err.splitlines()[-1] == (
        f'pathgene: The autopilot holds the mission, but will not start it ("{reason[:-1]}"); end '
        "it with a landing (--land), or set MIS_TKO_LAND_REQ to 0 there."
    )


def test_an_interrupted_upload_leaves_the_earlier_mission(flown, capsys):
    own = OwnAutopilot()
    own.kind = 3
    arguments = ["upload", str(flown / "path.plan"), "--to", own.address, "--system", "7"]
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
    assert last_line(capsys.readouterr().err) == (
        "pathgene: The upload is interrupted; the autopilot now holds its earlier mission "
        f"({len(before[0])} items), its earlier fence (1 items), and its earlier rally list "
        f"({len(before[2])} items); upload again.\n"
    )
    assert [item.x for item in own.lists[0]] == [item.x for item in before[0]]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--to", "logs.tlog"], "There is no autopilot at 'logs.tlog': give udpout:HOST:PORT"),
        (["--to", "udpout:127.0.0.1:1", "--timeout", "nan"], "--timeout must be a positive number"),
        (["--to", "udpout:127.0.0.1:1", "--origin", "1,2"], "A .plan file has its place on Earth;"),
        (["--to", "udpout:127.0.0.1:1", "--simplify", "5"], "A .plan file has its own waypoints;"),
        ([], "The following arguments are required: --to; see pathgene upload --help."),
    ],
)
def test_bad_input_is_one_sentence(flown, capsys, options, sentence):
    assert main(["upload", str(flown / "path.plan"), *options]) == 2
    assert capsys.readouterr().err.startswith(f"pathgene: {sentence}")


def test_the_fences_have_the_room_of_the_autopilot_or_of_the_option(hills, tmp_path, capsys):
    """A zone of 300 corners is simplified for the kind that answers."""
    turns = [2 * math.pi * n / 300 for n in range(300)]
    corners = [[3000 + 700 * math.cos(t), 900 + 700 * math.sin(t)] for t in turns]
    zone = {"type": "Polygon", "crs_local": True, "coordinates": [[*corners, corners[0]]]}
    (tmp_path / "zone.geojson").write_text(json.dumps(zone))
    options = ("--nofly", tmp_path / "zone.geojson", "--planner", "astar", "--no-picture")
    options += ("--origin", "46.1,7.6", "--write", "plan", "--fence-corners", 50)
    assert plan(hills, tmp_path, *options) == 0
    assert "The fences have 49 corners" in capsys.readouterr().err
    (fence,) = json.loads((tmp_path / "path.plan").read_text())["geoFence"]["polygons"]
    assert len(fence["polygon"]) == 49
    for kind, options, count in ((3, (), 81), (12, (), 63), (3, ("--fence-corners", "30"), 29)):
        own = OwnAutopilot()
        own.kind = kind
        try:
            assert (
                main(["upload", str(tmp_path / "summary.json"), "--to", own.address, *options]) == 0
            )
        finally:
            own.close()
        assert len(own.lists[1]) == count + 1  # And a circle.
        assert f"The fences have {count} corners instead of 300" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["plan", "export", "upload"])
def test_bad_corners_of_fences_are_one_sentence(hills, flown, command, capsys):
    files = {
        "plan": ["--terrain", str(hills), "--start", "1,1,900", "--goal", "2,2,900"],
        "export": [str(flown / "summary.json")],
        "upload": [str(flown / "summary.json"), "--to", "udpout:127.0.0.1:9"],
    }
    assert main([command, *files[command], "--fence-corners", "2"]) == 2
    assert "The corners of fences must be 3 to 65,535, not 2 (--fence-corners)." in (
        capsys.readouterr().err
    )
