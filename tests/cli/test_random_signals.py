"""Signals at random moments: no file is torn, and no process and no hidden file is left."""

import json
import os
import random
import signal
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest

from host.device.boards import open_board
from host.report.run_files import verify
from tests.chips import SMALL, board_url
from tests.cli.conftest import ENDS, ROOT


SIGNALS = [signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGQUIT]
COMMANDS = ["plan-model", "plan-sim", "compare", "fly", "replan", "serve"]
WRITTEN = "pathgene: Interrupted; the best path so far is written."
ENDED = "pathgene: Interrupted before the end."
EARLY = "pathgene: Interrupted before a path was found; nothing is written to "
# Each process of a trial has this variable in its environment.
MARK = "PATHGENE_TRIAL"
# A board is served for ever.
SERVED_S = 3.0


@pytest.fixture(scope="module")
def trial(hills, tmp_path_factory):
    """Function that sends a signal to a command at a share of its usual time, and judges the end.

    It returns the exit status. All trials of a command write to one folder.
    """
    durations = {}
    folders = {name: tmp_path_factory.mktemp(name) for name in COMMANDS}
    search = ["--terrain", hills, *ENDS, "--generations", "10000000"]
    plan = ["plan", *search, "--time-limit", "1", "--planner", "ga-fpga", "--board"]
    commands = {
        "plan-model": [*plan, board_url("model", SMALL), "--out", folders["plan-model"]],
        "plan-sim": [*plan, board_url("sim", SMALL), "--out", folders["plan-sim"]],
        "compare": [
            *["compare", *search, "--planners", "ga-pc", "--runs", "4", "--time-limit", "0.3"],
            *["--jobs", "2", "--out", folders["compare"]],
        ],
        "fly": [
            *["fly", folders["plan-model"] / "summary.json", "--gusts", "light"],
            *["--out", folders["fly"]],
        ],
        "replan": [
            *["fly", folders["plan-model"] / "summary.json", "--popup", "ahead:1500,250@20"],
            *["--planner", "ga-chip", "--board", "sim:?map_size=128&lanes=4"],
            *["--out", folders["replan"]],
        ],
        "serve": ["board", "serve", "--board", board_url("sim", SMALL)],
    }

    def usual_s(name):
        """Run a command to its end, and return the time that takes, seconds."""
        if name not in durations:
            if name == "serve":
                durations[name] = SERVED_S
                return SERVED_S
            if name in ("fly", "replan"):
                usual_s("plan-model")
            finished(commands[name])
            started = time.monotonic()
            finished(commands[name])
            durations[name] = time.monotonic() - started
        return durations[name]

    def run(name, number, seed):
        share = random.Random(f"{name} {number} {seed}").random()
        delay_s = share * usual_s(name)
        if name == "compare":
            (folders[name] / "runs.jsonl").unlink(missing_ok=True)
        status = interrupted(commands[name], number, delay_s, to_group=bool(seed % 2))
        assert_whole(folders[name])
        return status

    def clean(name):
        """Assert that a command does its work now."""
        if name == "serve":
            answers(commands[name])
        else:
            finished(commands[name])
            assert_whole(folders[name])

    run.clean = clean
    return run


def started(command, mark):
    return subprocess.Popen(
        [sys.executable, "-m", "host", *map(str, command)],
        cwd=ROOT,
        env={**os.environ, MARK: mark},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def finished(command):
    with started(command, "none") as process:
        error = process.communicate(timeout=300)[1]
    # A path need not be feasible, nor a flight kept.
    assert process.returncode in (0, 1), error
    assert "Internal error" not in error


def answers(command):
    """Assert that a served board answers, and ends at a signal."""
    with started(command, "none") as process:
        url = process.stdout.readline().strip()
        with open_board(url) as chip:
            assert chip.config.population == SMALL.population
        process.send_signal(signal.SIGTERM)
        error = process.communicate(timeout=60)[1]
    assert process.returncode == 128 + signal.SIGTERM, error


def interrupted(command, number, delay_s, *, to_group):
    """Send a signal to a command, or to all processes of its session, and judge its end."""
    mark = uuid.uuid4().hex
    with started(command, mark) as process:
        time.sleep(delay_s)
        if process.poll() is None:
            (os.killpg if to_group else os.kill)(process.pid, number)
        _, error = process.communicate(timeout=60)
    status = process.returncode
    deadline = time.monotonic() + 10
    while left := processes(mark):
        assert time.monotonic() < deadline, (left, error)
        time.sleep(0.05)
    # Before Python has set its handlers, and after it has removed them, a signal kills.
    assert status in (128 + number, -number, 0, 1), error
    assert "Internal error" not in error
    if status == 128 + number:
        assert "Traceback" not in error
        said = error.splitlines()[-1]
        kept = said.startswith("pathgene: Interrupted; ") and "runs are kept" in said
        assert kept or said.startswith((WRITTEN, ENDED, EARLY, "pathgene: Serving until")), error
        if command[0] == "plan" and "generation " in error:
            assert said == WRITTEN, error
        if said == WRITTEN:
            summary = json.loads((Path(command[-1]) / "summary.json").read_text())
            assert summary["interrupted"] is True
            assert summary["stopped_by"] == "interrupt"
    return status


def processes(mark):
    """Return the commands of the processes of a trial that still run."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdecimal():
            try:
                if f"{MARK}={mark}".encode() in (folder / "environ").read_bytes():
                    found.append((folder / "cmdline").read_bytes().replace(b"\0", b" "))
            except OSError:
                pass  # It has ended.
    return found


def assert_whole(folder):
    """Assert that every file in a folder is whole and none is hidden."""
    for file in folder.iterdir():
        assert not file.name.startswith("."), file
        if file.suffix in (".json", ".geojson"):
            json.loads(file.read_text())
        elif file.suffix == ".jsonl":
            assert list(map(json.loads, file.read_text().splitlines())) is not None
        elif file.suffix == ".png":
            assert file.read_bytes().endswith(b"IEND\xaeB`\x82")
    summary = folder / "summary.json"
    if summary.exists():
        verify(summary, json.loads(summary.read_text()))


@pytest.mark.ci
@pytest.mark.parametrize("name", COMMANDS)
def test_two_signals(trial, name):
    for seed, number in enumerate((signal.SIGTERM, signal.SIGHUP)):
        trial(name, number, seed)
    trial.clean(name)


@pytest.mark.long
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("name", COMMANDS)
def test_ten_signals(trial, name, number):
    statuses = [trial(name, number, seed) for seed in range(10)]
    print(f"{name}, {number.name}: {statuses}")
    trial.clean(name)
