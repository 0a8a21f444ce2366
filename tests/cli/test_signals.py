"""Signals that end a command: it writes the best path and does not leave a process."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from pathgene.host.cli import main
from pathgene.host.errors import JobError
from tests.support.host.processes import Started

from .conftest import ENDS, ROOT, is_gone, started, wait_for


FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]
OTHERS = [
    signal.SIGTERM,
    pytest.param(signal.SIGHUP, marks=pytest.mark.ci),
    pytest.param(signal.SIGQUIT, marks=pytest.mark.ci),
]
MANY = "10000000"


def plan(hills, out, *options, **more):
    """Start an endless plan; return its process once it searches."""
    process = started(
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--generations",
        MANY,
        "--out",
        out,
        "--json",
        *options,
        **more,
    )
    wait_for(process, "generation 0/")
    return process


@pytest.mark.parametrize("number", OTHERS)
def test_a_plan_is_written_after_a_signal(hills, tmp_path, number):
    with plan(hills, tmp_path, start_new_session=True) as process:
        os.killpg(process.pid, number)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 128 + number, error
    assert error.splitlines()[-1] == "pathgene: Interrupted; the best path so far is written."
    summary = json.loads(output)
    assert (summary["interrupted"], summary["stopped_by"]) == (True, "interrupt")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    assert is_gone(process.pid)


@pytest.mark.ci
def test_further_signals_during_writing_lose_nothing(hills, tmp_path):
    with plan(hills, tmp_path) as process:
        process.send_signal(signal.SIGTERM)
        while not any(tmp_path.iterdir()):
            assert process.poll() is None
            time.sleep(0.002)
        # Send signals from the first file to the last.
        while not (tmp_path / "path.png").exists() and process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.send_signal(signal.SIGTERM)
            time.sleep(0.02)
        process.communicate(timeout=60)
    assert process.returncode in (128 + signal.SIGTERM, -signal.SIGTERM)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == FILES
    assert json.loads((tmp_path / "summary.json").read_text())["interrupted"]


def test_an_interrupt_before_a_path_is_found_writes_nothing(hills, tmp_path, monkeypatch, capsys):
    def interrupted(*arguments, **options):
        """Two signals during the first generation."""
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(60)

    monkeypatch.setattr("pathgene.host.mission.planning.plan_mission", interrupted)
    command = ["plan", "--terrain", str(hills), *ENDS, "--planner", "ga-pc", "--out", str(tmp_path)]
    assert main(command) == 128 + signal.SIGTERM
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"pathgene: Interrupted before a path was found; nothing is written to {tmp_path}."
    )
    assert list(tmp_path.iterdir()) == []


def test_a_job_that_fails_by_the_signal_is_an_interrupt(hills, tmp_path, monkeypatch, capsys):
    """A signal to a group ends a compiler or a simulator before this process checks it."""

    def failed(*arguments, **options):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(0.01)
        raise JobError("The simulated board failed with status -15: it printed nothing")

    def interrupted():
        assert main([*command, "--planner", "ga-pc", "--out", str(tmp_path)]) == 128 + 15
        return capsys.readouterr().err.splitlines()[-1]

    command = ["plan", "--terrain", str(hills), *ENDS]
    with monkeypatch.context() as patch:
        patch.setattr("pathgene.host.mission.planning.plan_mission", failed)
        assert interrupted() == (
            f"pathgene: Interrupted before a path was found; nothing is written to {tmp_path}."
        )
    monkeypatch.setattr("pathgene.host.mission.build.mission_of", failed)
    assert interrupted().startswith("pathgene: The simulated board failed with status -15: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "line", ["pathgene.host.errors", "pathgene.host.cli.streams", "pathgene.host.cli.parser"]
)
def test_an_interrupt_while_the_program_is_imported(line):
    """Standard error lists the imports up to then, and has no traceback."""
    command = [sys.executable, "-X", "importtime", "-m", "pathgene", "plan", "--help"]
    with Started(
        command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        assert any(each.rstrip().endswith(f" {line}") for each in process.stderr)
        process.send_signal(signal.SIGINT)
        said = [each for each in process.stderr if not each.startswith("import time:")]
    # After the imports the handlers are set.
    assert process.returncode in (-signal.SIGINT, 128 + signal.SIGINT, 0)
    assert said in ([], ["pathgene: Interrupted before the end.\n"])


@pytest.mark.ci
def test_a_plan_under_nohup_outlives_its_terminal(hills, tmp_path):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # Child processes inherit this.
    try:
        process = plan(hills, tmp_path)
    finally:
        signal.signal(signal.SIGHUP, before)
    with process:
        process.send_signal(signal.SIGHUP)
        time.sleep(1.5)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM


@pytest.mark.ci
def test_auv_is_written_after_a_signal(tmp_path):
    with started("auv", "--generations", MANY, "--out", tmp_path, "--json") as process:
        wait_for(process, "generation 1/")
        process.send_signal(signal.SIGTERM)
        output, error = process.communicate(timeout=60)
    assert process.returncode == 128 + signal.SIGTERM
    assert error.splitlines()[-1] == "pathgene: Interrupted; the best path so far is written."
    assert json.loads(output) == json.loads((tmp_path / "auv.json").read_text())
    assert json.loads(output)["interrupted"]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["auv.json", "auv.png"]


@pytest.mark.ci
@pytest.mark.parametrize("number", OTHERS)
def test_a_comparison_keeps_its_runs_and_ends_its_processes(hills, tmp_path, number):
    file = tmp_path / "runs.jsonl"
    with started(
        "compare",
        "--terrain",
        hills,
        *ENDS,
        "--planners",
        "ga-pc",
        "--runs",
        40,
        "--generations",
        MANY,
        "--time-limit",
        0.3,
        "--jobs",
        2,
        "--out",
        tmp_path,
        start_new_session=True,
    ) as process:
        while not (file.exists() and file.read_bytes().endswith(b"\n")):
            assert process.poll() is None
            time.sleep(0.05)
        os.killpg(process.pid, number)  # To all its processes, as from a terminal.
        output, error = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert output == ""
    done = file.read_bytes().count(b"\n")
    assert error.splitlines()[-1] == (
        f"pathgene: Interrupted; {done} of 40 runs are kept in {file}; repeat the command "
        "to continue."
    )
    assert "Traceback" not in error
    assert is_gone(process.pid)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["compare.json", "runs.jsonl"]
    report = json.loads((tmp_path / "compare.json").read_text())
    assert (report["interrupted"], len(report["planners"][0]["runs"])) == (True, done)
