"""Signals to a flight or a served board: the flown part is written, no process is left."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from pathgene.host.cli import main
from pathgene.host.files.output import json_bytes
from pathgene.host.flight.flight import PERIOD_S, Flight
from pathgene.host.replanning.planner import InFlightPlanner
from tests.support.gateware.chips import SMALL
from tools.chips import board_url

from .conftest import ROOT, is_gone, started, wait_for


WRITTEN = "pathgene: Interrupted; the flight until then is written."
WHOLE = "pathgene: Interrupted; the flight is written, but not all of its pictures."
BREAK = "The flight was interrupted before it reached the goal."
POPUP = ("--popup", "ahead:1500,250@20", "--planner", "astar", "--planner-seconds", "0.2")
NUMBERS = [
    signal.SIGTERM,
    pytest.param(signal.SIGINT, marks=pytest.mark.ci),
    pytest.param(signal.SIGHUP, marks=pytest.mark.ci),
    pytest.param(signal.SIGQUIT, marks=pytest.mark.ci),
]
#: Steps before a flight reaches the start of its path, and well after it.
BEGUN, UNDERWAY = 600, 3000
#: ``pathgene`` with a flight that prints "flying" after some time, and is slow afterwards.
SLOWLY = f"""
import sys, time
from pathgene.host.cli import main
from pathgene.host.files.output import json_bytes
from pathgene.host.flight.flight import Flight
steps, step = 0, Flight.step
def slow(flight):
    global steps
    steps += 1
    if steps >= {UNDERWAY}:
        time.sleep(0.01)
    if steps == {UNDERWAY}:
        print("flying", file=sys.stderr, flush=True)
    return step(flight)
Flight.step = slow
sys.exit(main())
"""


@pytest.fixture
def out(tmp_path):
    """A folder with the pictures of an earlier flight."""
    for name in ("flight.json", "flight.png", "flight.gif"):
        (tmp_path / name).write_bytes(b"of an earlier flight")
    return tmp_path


@pytest.fixture
def at_step(monkeypatch):
    """Function that sends a signal to this process at a step of the flight."""

    def send(at, number=signal.SIGTERM):
        step, steps = Flight.step, iter(range(1, 10**9))

        def signalled(flight):
            if next(steps) == at:
                os.kill(os.getpid(), number)
            return step(flight)

        monkeypatch.setattr(Flight, "step", signalled)

    return send


def assert_interrupted(out, table):
    """Assert that the file of a flight says so, and that it is the only file."""
    assert [file.name for file in out.iterdir()] == ["flight.json"]
    content = json.loads((out / "flight.json").read_text())
    track = content.pop("track")
    assert content == {key: value for key, value in table.items() if key != "files"}
    assert (table["interrupted"], table["kept"], table["breaks"]) == (True, False, [BREAK])
    assert table["files"] == [str(out / "flight.json")]
    flown_s = table["flight_time_s"]
    assert 0 < flown_s < 180
    assert len(track["x"]) == len(track["t_s"]) == pytest.approx(flown_s, abs=1.1)


@pytest.mark.parametrize(
    "options", [(), pytest.param(POPUP, marks=pytest.mark.ci)], ids=["simple", "popup"]
)
@pytest.mark.parametrize("number", NUMBERS)
def test_a_flight_is_written_after_a_signal(straight_flight, out, number, options):
    command = ["fly", straight_flight, *options, "--out", out, "--json"]
    with started(*command, program=("-c", SLOWLY), start_new_session=True) as process:
        wait_for(process, "flying")
        os.killpg(process.pid, number)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 128 + number, error
    assert error.splitlines()[-2:] == [f"pathgene: {BREAK}", WRITTEN]
    assert_interrupted(out, json.loads(output))
    assert is_gone(process.pid)


@pytest.mark.parametrize("options", [(), POPUP], ids=["simple", "popup"])
def test_a_signal_before_the_start_writes_nothing(
    straight_flight, tmp_path, at_step, capsys, options
):
    at_step(BEGUN)
    out = tmp_path / "out"
    assert main(["fly", straight_flight, *options, "--out", str(out)]) == 128 + signal.SIGTERM
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"pathgene: Interrupted before the flight began; nothing is written to {out}."
    )
    assert list(out.iterdir()) == []


def test_a_signal_ends_a_plan_in_flight(straight_flight, out, monkeypatch, capsys):
    def endless(*_):
        os.kill(os.getpid(), signal.SIGHUP)
        time.sleep(60)

    monkeypatch.setattr(InFlightPlanner, "attempt", endless)
    begun = time.monotonic()
    command = ["fly", straight_flight, *POPUP, "--out", str(out), "--json"]
    assert main(command) == 128 + signal.SIGHUP
    assert time.monotonic() - begun < 30
    table = json.loads(capsys.readouterr().out)
    assert_interrupted(out, table)
    assert table["ended"] == "interrupted"
    assert table["flight_time_s"] == pytest.approx(20, abs=2 * PERIOD_S)


@pytest.mark.parametrize("options", [(), POPUP], ids=["simple", "popup"])
def test_a_second_signal_while_the_flight_is_judged_loses_nothing(
    straight_flight, out, at_step, monkeypatch, capsys, options
):
    at_step(UNDERWAY)

    def signalled(value):
        time.sleep(0.2)  # A signal any sooner would count as the same request.
        os.kill(os.getpid(), signal.SIGINT)
        return json_bytes(value)

    monkeypatch.setattr("pathgene.host.flight.fly.json_bytes", signalled)
    monkeypatch.setattr("pathgene.host.replanning.fly.json_bytes", signalled)
    command = ["fly", straight_flight, *options, "--out", str(out), "--json"]
    assert main(command) == 128 + signal.SIGTERM
    assert_interrupted(out, json.loads(capsys.readouterr().out))


@pytest.mark.parametrize("options", [(), POPUP], ids=["simple", "popup"])
@pytest.mark.parametrize("moment", ["written", "drawn"])
def test_a_signal_after_the_end_keeps_the_whole_flight(
    straight_flight, out, monkeypatch, capsys, options, moment
):
    def signalled(value):
        os.kill(os.getpid(), signal.SIGQUIT)
        return json_bytes(value)

    def endless(*_):
        os.kill(os.getpid(), signal.SIGQUIT)
        time.sleep(60)

    for package in ("pathgene.host.flight", "pathgene.host.replanning"):
        if moment == "written":
            monkeypatch.setattr(f"{package}.fly.json_bytes", signalled)
        else:
            monkeypatch.setattr(f"{package}.picture.draw", endless)
    command = ["fly", straight_flight, *options, "--out", str(out), "--json"]
    assert main(command) == 128 + signal.SIGQUIT
    printed, said = capsys.readouterr()
    assert said.splitlines()[-1] == WHOLE
    table = json.loads(printed)
    assert table["files"] == [str(out / "flight.json")]
    assert (table["interrupted"], table["kept"]) == (False, True)
    assert [file.name for file in out.iterdir()] == ["flight.json"]


@pytest.mark.parametrize("number", NUMBERS)
def test_a_served_board_ends_after_a_signal(number):
    command = ["board", "serve", "--board", board_url("sim", SMALL), "--json"]
    with started(*command, start_new_session=True) as process:
        text = ""
        while not text.endswith("}\n"):
            line = process.stdout.readline()
            assert line, "The command has ended."
            text += line
        wait_for(process, "pathgene: Serving until Ctrl-C.")
        os.killpg(process.pid, number)
        output, error = process.communicate(timeout=60)
    assert (process.returncode, output, error) == (128 + number, "", "")
    assert is_gone(process.pid)
    with pytest.raises(ProcessLookupError):
        os.kill(json.loads(text)["pid"], 0)


def test_a_served_board_heeds_a_signal_that_another_thread_takes():
    """A signal to a stopped process may be taken like this."""
    command = ["board", "serve", "--board", board_url("sim", SMALL)]
    program = (
        "import signal, sys, threading, time\n"
        "from pathgene.host.cli import main\n"
        "def send():\n"
        "    time.sleep(0.5)\n"
        "    signal.pthread_kill(threading.get_ident(), signal.SIGTERM)\n"
        "import pathgene.sim.board.process as process\n"
        "wait = process.SimulatedBoard.wait\n"
        "def begun(*arguments):\n"
        "    process.SimulatedBoard.wait = wait\n"
        "    threading.Thread(target=send).start()\n"
        "    return wait(*arguments)\n"
        "process.SimulatedBoard.wait = begun\n"
        "sys.exit(main())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *command], cwd=ROOT, timeout=60, check=False
    )
    assert done.returncode == 128 + signal.SIGTERM
