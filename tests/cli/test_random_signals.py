"""Signals at random moments: no file is truncated, and no process or hidden file is left."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from dataclasses import dataclass
from pathlib import Path

import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.report.run_files import verify
from tests.cli.conftest import ROOT
from tests.support.gateware.chips import SMALL
from tests.support.host.processes import Started
from tools.chips import board_url


SIGNALS = [signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGQUIT]
COMMANDS = ["plan-model", "plan-sim", "compare", "fly", "replan", "serve"]
# A minute of simulation for each flight.
LONG = [*COMMANDS, "replan-sim"]
WRITTEN = "pathgene: Interrupted; the best path so far is written."
ENDED = "pathgene: Interrupted before the end."
EARLY = "pathgene: Interrupted before a path was found; nothing is written to "
FLOWN = "pathgene: Interrupted; the flight until then is written."
WHOLE = "pathgene: Interrupted; the flight is written, but not all of its pictures."
GROUNDED = "pathgene: Interrupted before the flight began; nothing is written to "
# Each process of a trial has this variable in its environment.
MARK = "PATHGENE_TRIAL"
# A flight of a minute or two.
ENDS = ("--start", "500,500,100", "--goal", "2500,1500,100", "--agl")
# Boards whose first use builds them.
BOARDS = {"plan-sim": board_url("sim", SMALL), "replan-sim": "sim:?map_size=128&lanes=4"}
# A board is served until a signal ends it.
SERVED_S = 3.0
# Maximum time from the end of a search to the last file of its path, seconds.
WRITING_S = 2.0
PROGRAM = (sys.executable, "-m", "pathgene")


@pytest.fixture(scope="module")
def trial(hills, tmp_path_factory):
    """Function that sends a signal to a command at a share of its usual time and checks its end.

    It returns the exit status. All trials of a command write to one folder.
    """
    durations = {}
    folders = {name: tmp_path_factory.mktemp(name) for name in LONG}
    search = ["--terrain", hills, *ENDS, "--generations", "10000000"]
    plan = ["plan", *search, "--time-limit", "1", "--planner", "ga-fpga", "--board"]
    replan = [
        *["fly", folders["plan-model"] / "summary.json", "--popup", "ahead:800,250@20"],
        *["--planner", "ga-chip", "--board"],
    ]
    commands = {
        "plan-model": [*plan, board_url("model", SMALL), "--out", folders["plan-model"]],
        "plan-sim": [*plan, BOARDS["plan-sim"], "--out", folders["plan-sim"]],
        "compare": [
            *["compare", *search, "--planners", "ga-pc", "--runs", "4", "--time-limit", "0.3"],
            *["--jobs", "2", "--out", folders["compare"]],
        ],
        "fly": [
            *["fly", folders["plan-model"] / "summary.json", "--gusts", "light"],
            *["--out", folders["fly"]],
        ],
        "replan": [*replan, "model:?map_size=128&lanes=4", "--out", folders["replan"]],
        "replan-sim": [*replan, BOARDS["replan-sim"], "--out", folders["replan-sim"]],
        "serve": ["board", "serve", "--board", board_url("sim", SMALL)],
    }

    def usual_s(name):
        """Run a command to its end, and return its time in seconds."""
        if name not in durations:
            if name == "serve":
                durations[name] = SERVED_S
                return SERVED_S
            if name in ("fly", "replan", "replan-sim"):
                usual_s("plan-model")
            if name in BOARDS:
                open_board(BOARDS[name]).close()
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
        """Assert that a command now works."""
        if name == "serve":
            answers(commands[name])
        else:
            finished(commands[name])
            assert_whole(folders[name])

    run.clean = clean
    return run


def started(command, mark, program=PROGRAM, **streams):
    return Started(
        [*program, *map(str, command)],
        cwd=ROOT,
        env={**os.environ, MARK: mark},
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
        text=True,
        start_new_session=True,
    )


def finished(command):
    with started(command, "none") as process:
        error = process.communicate(timeout=300)[1]
    # A path need not be feasible, and a flight need not be kept.
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


@dataclass(frozen=True)
class Moment:
    """A snapshot of a command just before its signal, taken while the command is stopped."""

    #: The program has set its signal handlers and not removed them yet.
    announced: bool
    #: Its text on standard output and standard error before the signal.
    printed: str
    said: str
    #: Seconds since the epoch.
    at_s: float


def interrupted(command, number, delay_s, *, to_group, program=PROGRAM):
    """Send a signal to a command, or to all processes of its session, and check its end."""
    mark = uuid.uuid4().hex
    begun_s = time.time()
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        with started(command, mark, program, stdout=output, stderr=errors) as process:
            time.sleep(delay_s)
            moment = signalled(process, number, output, errors, to_group=to_group)
            status = process.wait(timeout=60)
        printed, error = written(output), written(errors)
    deadline = time.monotonic() + 10
    while left := processes(mark):
        assert time.monotonic() < deadline, (left, error)
        time.sleep(0.05)
    judge(command, number, status, moment, printed, error, begun_s)
    return status


def signalled(process, number, output, errors, *, to_group):
    """Stop a process, inspect it, and send it a signal; return None if it has ended before."""
    tasks = Path(f"/proc/{process.pid}/task")
    if process.poll() is not None:
        return None
    os.kill(process.pid, signal.SIGSTOP)
    deadline = time.monotonic() + 30
    states = set()
    while states != {"T"}:
        if "Z" in states:
            return None
        assert time.monotonic() < deadline, states
        time.sleep(0.001)
        with contextlib.suppress(OSError):  # A thread has ended.
            states = {field(task / "status", "State") for task in tasks.iterdir()}
    caught = int(field(tasks.parent / "status", "SigCgt"), 16)
    # Python itself catches only SIGINT before the program does.
    needed = {number, signal.SIGTERM if number == signal.SIGINT else number}
    announced = all(caught >> (each - 1) & 1 for each in needed)
    moment = Moment(announced, written(output), written(errors), time.time())
    (os.killpg if to_group else os.kill)(process.pid, number)
    process.send_signal(signal.SIGCONT)
    return moment


def field(file, name):
    """Return a field of a file of ``/proc``."""
    (line,) = (line for line in file.read_text().splitlines() if line.startswith(f"{name}:"))
    return line.split()[1]


def written(file):
    """Return the text that a program has written to a file."""
    return os.pread(file.fileno(), os.fstat(file.fileno()).st_size, 0).decode()


def judge(command, number, status, moment, printed, error, begun_s):
    """Assert that a command ended in a permitted way after a signal at a moment."""
    told = f"status {status}, {moment}, printed: {printed}, said: {error}"
    assert "Internal error" not in error, told
    serves = command[0] == "board"
    if moment is None:
        assert not serves, told
        assert status in (0, 1), told
        return
    if status == 128 + number:
        judge_words(command, moment, error, begun_s)
        return
    if not moment.announced:
        if moment.printed and not serves:
            # After its end, the handlers are removed and everything is printed.
            assert printed == moment.printed, told
            assert status in (-number, 0, 1), told
            return
        # Before its start, Python's own handler of SIGINT ends it with status 1.
        files = [] if serves else list(Path(command[-1]).iterdir())
        files = [file for file in files if file.stat().st_mtime >= begun_s]
        assert [moment.printed, moment.said, files] == ["", "", []], told
        assert "pathgene:" not in error, told
        assert status in ((-number, 1) if number == signal.SIGINT else (-number,)), told
        return
    # Only a search that had ended by itself continues, to write its path.
    assert command[0] == "plan", told
    assert status in (0, 1), told
    assert printed, told
    summary = Path(command[-1]) / "summary.json"
    assert json.loads(summary.read_text())["interrupted"] is False, told
    assert error == moment.said or summary.stat().st_mtime - moment.at_s < WRITING_S, told


def judge_words(command, moment, error, begun_s):
    """Assert that an interrupted command names the files that it has written."""
    assert "Traceback" not in error, error
    said = error.splitlines()[-1]
    if command[0] == "board":
        assert said.startswith((ENDED, "pathgene: Serving until")), error
        return
    folder = Path(command[-1])
    if command[0] == "compare":
        kept = said.startswith("pathgene: Interrupted; ") and "runs are kept" in said
        assert kept or said == ENDED, error
    elif command[0] == "fly":
        assert said.startswith((FLOWN, WHOLE, ENDED, GROUNDED)), error
        if said in (FLOWN, WHOLE) or " s: a zone appears" in moment.said:
            file = folder / "flight.json"
            assert file.stat().st_mtime >= begun_s, error
            flight = json.loads(file.read_text())
            assert not (flight["interrupted"] and flight["kept"]), error
            assert said not in (FLOWN, WHOLE) or flight["interrupted"] == (said == FLOWN), error
    else:
        assert said.startswith((WRITTEN, ENDED, EARLY)), error
        if "generation " in error:
            assert said == WRITTEN, error
        if said == WRITTEN:
            summary = json.loads((folder / "summary.json").read_text())
            assert summary["interrupted"] is True
            assert summary["stopped_by"] == "interrupt"


def processes(mark):
    """Return the commands of the processes of a trial that are still running."""
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
    """Assert that every file in a folder is complete and none is hidden."""
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


#: Programs that search, and do not heed the signal as a command has to.
CARELESS = {
    "killed": "time.sleep(60)",
    "silent": "signal.signal(signal.SIGTERM, lambda *_: sys.exit(143)); time.sleep(60)",
    "content": "signal.signal(signal.SIGTERM, lambda *_: sys.exit(0)); time.sleep(60)",
    "deaf": """
signal.signal(signal.SIGTERM, lambda *_: None)
time.sleep(3)
print("generation 1", file=sys.stderr)
(Path(sys.argv[-1]) / "summary.json").write_text('{"interrupted": false}')
print("feasible")
""",
}


@pytest.mark.ci
@pytest.mark.parametrize("kind", CARELESS)
def test_a_command_that_does_not_heed_its_signal_is_noticed(tmp_path, kind):
    begin = "import signal, sys, time; from pathlib import Path; print('generation 0', "
    text = f"{begin} file=sys.stderr, flush=True)\n{CARELESS[kind]}"
    program = sys.executable, "-c", text
    for command in (["plan", "--out", tmp_path], ["fly", "--out", tmp_path], ["board", tmp_path]):
        with pytest.raises(AssertionError, match="generation 0"):
            interrupted(command, signal.SIGTERM, 1.0, to_group=True, program=program)


@pytest.mark.ci
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in ("compare", "plan-model") else name
        for name in COMMANDS
    ],
)
@pytest.mark.parametrize("count", [1, pytest.param(2, marks=pytest.mark.long)])
def test_two_signals(trial, name, count):
    for seed, number in enumerate((signal.SIGTERM, signal.SIGHUP)[:count]):
        trial(name, number, seed)
    trial.clean(name)


@pytest.mark.long
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("name", LONG)
def test_ten_signals(trial, name, number):
    statuses = [trial(name, number, seed) for seed in range(10)]
    print(f"{name}, {number.name}: {statuses}")
    trial.clean(name)
