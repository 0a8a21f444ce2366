"""Standard output and error that are closed, full or without a reader."""

import contextlib
import json
import os
import pty
import select
import shlex
import stat
import subprocess
import sys

import numpy as np
import pytest

from tests.support.gateware.chips import SMALL
from tests.support.host.foreign import write_planted
from tests.support.host.processes import Started
from tests.unit.mission.autopilot.mavsdk_autopilot import Autopilot
from tools.chips import board_url

from .conftest import ENDS, ROOT, run_here


FILES = ["path.geojson", "path.png", "summary.json", "terrain.npz"]
SILENT = (
    pytest.param("2>&-", marks=pytest.mark.ci),
    pytest.param("2>full", marks=pytest.mark.long),
    "2>broken",
)
REASONS = {">&-": "Bad file descriptor", ">full": "No space left on device"}


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """A device like /dev/full that a test may overwrite."""
    device = tmp_path_factory.mktemp("devices") / "full"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 7))
        device.open("wb").close()
    except OSError as error:
        pytest.skip(f"Devices cannot be made here ({error.strerror})")
    return device


@pytest.fixture
def redirected(request, tmp_path):
    """Function that runs ``pathgene`` with redirections; ``broken`` is a pipe without a reader."""

    def run(redirections, *arguments):
        if "full" in redirections:
            device = request.getfixturevalue("full")
            redirections = redirections.replace("full", shlex.quote(str(device)))
        ours, broken = os.pipe()
        os.close(ours)
        redirections = redirections.replace("broken", "&0")
        # The pipe is standard input, because a shell may not know descriptors of two digits.
        command = shlex.join([sys.executable, "-m", "pathgene", *map(str, arguments)])
        done = subprocess.run(
            ["sh", "-c", f"{command} {redirections}"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            stdin=broken,
        )
        os.close(broken)
        return done

    return run


def plan(hills, out):
    return (
        "plan",
        "--terrain",
        hills,
        *ENDS,
        "--generations",
        "60",
        "--seed",
        "1",
        "--out",
        out,
        "--json",
    )


def names(directory):
    return sorted(entry.name for entry in directory.iterdir())


@pytest.mark.parametrize("redirection", SILENT)
def test_a_plan_needs_no_progress(redirected, hills, tmp_path, redirection):
    done = redirected(redirection, *plan(hills, tmp_path))
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == json.loads((tmp_path / "summary.json").read_text())
    assert names(tmp_path) == FILES


@pytest.mark.parametrize("redirection", [pytest.param(">&-", marks=pytest.mark.ci), ">full"])
def test_a_plan_without_standard_output_is_written(redirected, hills, tmp_path, redirection):
    done = redirected(redirection, *plan(hills, tmp_path))
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        f"pathgene: Cannot write to standard output ({REASONS[redirection]})."
    )
    assert "Exception" not in done.stderr
    assert names(tmp_path) == FILES


@pytest.mark.parametrize(
    "redirection",
    [
        pytest.param(">broken 2>&1", marks=pytest.mark.long),
        pytest.param(">full 2>&1", marks=pytest.mark.long),
        pytest.param(">&- 2>&-", marks=pytest.mark.ci),
    ],
)
def test_a_plan_without_any_stream_is_written(redirected, hills, tmp_path, redirection):
    done = redirected(redirection, *plan(hills, tmp_path))
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
    assert json.loads((tmp_path / "summary.json").read_text())["generations"] == 60
    assert names(tmp_path) == FILES


@pytest.mark.ci
@pytest.mark.parametrize("redirection", SILENT)
def test_a_comparison_needs_no_progress(redirected, hills, tmp_path, redirection):
    done = redirected(
        redirection,
        "compare",
        "--terrain",
        hills,
        *ENDS,
        "--planners",
        "ga-pc",
        "--runs",
        2,
        "--generations",
        5,
        "--jobs",
        1,
        "--out",
        tmp_path,
        "--json",
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == json.loads((tmp_path / "compare.json").read_text())
    assert (tmp_path / "runs.jsonl").read_bytes().count(b"\n") == 2


@pytest.mark.ci
def test_auv_needs_no_progress(redirected, tmp_path):
    done = redirected("2>broken", "auv", "--generations", 3, "--out", tmp_path, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == json.loads((tmp_path / "auv.json").read_text())


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(("planners", "--json"), marks=pytest.mark.ci),
        ("planners",),
        pytest.param(("--help",), marks=pytest.mark.ci),
    ],
)
@pytest.mark.parametrize("redirection", [">&-", ">full"])
def test_reports_lost_output_in_a_sentence(redirected, redirection, command):
    done = redirected(redirection, *command)
    assert (done.returncode, done.stderr) == (
        1,
        f"pathgene: Cannot write to standard output ({REASONS[redirection]}).\n",
    )


def test_a_closed_reader_is_not_reported(redirected):
    done = redirected(">broken", "planners")
    assert (done.returncode, done.stderr) == (1, "")


def test_bad_input_keeps_its_status_without_standard_error(redirected):
    assert redirected("2>&-", "planner").returncode == 2


def test_verilog_to_special_files(redirected, pathgene, full):
    device = pathgene("verilog", "--top", "uart", "--out", full)
    assert (device.returncode, device.stderr) == (
        2,
        f"pathgene: Cannot write to {str(full)!r} (No space left on device); give another file "
        "(--out).\n",
    )
    assert full.is_char_device()
    piped = pathgene("verilog", "--top", "uart", "--out", "/dev/stdout")
    assert piped.returncode == 0, piped.stderr
    verilog, _, report = piped.stdout.rpartition("endmodule\n")
    assert verilog.startswith("/* Generated by Amaranth")
    assert report.startswith("top ")


def test_a_terrain_to_a_fifo(tmp_path):
    fifo = tmp_path / "grid.npz"
    os.mkfifo(fifo)
    with Started(
        [sys.executable, "-m", "pathgene", "terrain", "synth", "river", "--out", fifo],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
    ) as process:
        # A process with a time limit: if the FIFO were replaced, its reader would wait forever.
        read = subprocess.run(["cat", fifo], capture_output=True, timeout=60, check=True)
    assert read.stdout.startswith(b"PK")
    assert process.returncode == 0
    assert fifo.is_fifo()


@pytest.fixture(params=["pipe", "terminal"])
def stalled(request):
    """Both ends of a pipe or a terminal that is full, the reader's first."""
    reader, writer = os.pipe() if request.param == "pipe" else pty.openpty()
    os.set_blocking(writer, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(writer, b"." * 4096)
    # The mode belongs to the descriptor, whichever process has it.
    os.set_blocking(writer, True)
    yield reader, writer
    os.close(reader)
    os.close(writer)


def started(writer, *arguments):
    command = [sys.executable, "-m", "pathgene", *map(str, arguments)]
    return Started(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=writer)


@pytest.mark.ci
def test_a_stalled_reader_of_progress_is_not_waited_for(stalled, hills, tmp_path):
    with started(stalled[1], *plan(hills, tmp_path)) as process:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=120)
        assert process.poll() == 0
    assert names(tmp_path) == FILES


def test_a_slow_reader_gets_the_sentence(stalled):
    reader, writer = stalled
    with started(writer, "planner") as process:
        read = b""
        while b"see pathgene --help" not in read:
            assert select.select([reader], [], [], 60)[0], read[-200:]
            read += os.read(reader, 4096)
        assert process.wait(timeout=60) == 2


# Every command not run above, with a file that it writes.
COMMANDS = {
    "problem new": (("problem", "new", "{out}/new.toml"), "new.toml"),
    "problem check": (("problem", "check", "{problem}"), None),
    "batch": (
        ("batch", "{problem}", "--jobs", "1", "--no-picture", "--out", "{out}"),
        "batch.json",
    ),
    "compare": (
        (
            *("compare", "{problem}", "--planners", "ga-pc", "--runs", "1", "--generations", "5"),
            *("--jobs", "1", "--out", "{out}"),
        ),
        "runs.jsonl",
    ),
    "auv": (("auv", "--generations", "3", "--out", "{out}"), "auv.json"),
    "check": (("check", "--terrain", "{hills}", "--path", "{path}"), None),
    "diagnose": (("diagnose", "{problem}", "--out", "{out}"), "diagnosis.json"),
    "export": (("export", "{summary}", "--write", "geojson", "--out", "{out}"), "path.geojson"),
    "fly": (("fly", "{summary}", "--out", "{out}"), "flight.json"),
    "feasible": (("feasible", "--map", "{map}", "--path", "{cells}"), None),
    "board info": (("board", "info"), None),
    "terrain list": (("terrain", "list"), None),
    "terrain info": (("terrain", "info", "{hills}"), None),
    "terrain synth": (("terrain", "synth", "river", "--out", "{out}/river.npz"), "river.npz"),
    "verilog": (("verilog", "--top", "uart", "--out", "{out}/uart.v"), "uart.v"),
    "upload": (("upload", "{summary}", "--to", "{autopilot}"), None),
    # The URL is lost, so nobody could use the board, and it ends.
    "board serve": (("board", "serve", "--board", "{board}"), None),
    "mend": (("mend", "{mission}", "--terrain", "{ground}", "--out", "{out}/n.plan"), "n.plan"),
}


@pytest.fixture(scope="module")
def inputs(hills, tmp_path_factory):
    """Names of good files, one of each kind that a command reads."""
    folder = tmp_path_factory.mktemp("inputs")
    ends = ("--terrain", hills, "--start", "500,500,500", "--goal", "5500,3500,500")
    planned = ("--planner", "astar", "--origin", "46.1,7.6", "--no-picture", "--out", folder)
    problem = folder / "problem.toml"
    assert run_here("plan", *ends, *planned, "--save-problem", problem).returncode == 0
    (folder / "path.csv").write_text("x,y,z\n500,500,500\n5500,3500,500\n")
    np.save(folder / "map.npy", np.zeros((32, 32), np.int64))
    (folder / "cells.csv").write_text("x,y,z\n1,1,5\n20,20,5\n")
    mission, ground = write_planted(folder, "ridge", faulty=True)
    autopilot = Autopilot()
    yield {
        "autopilot": autopilot.address,
        "board": board_url("sim", SMALL),
        "hills": hills,
        "problem": problem,
        "summary": folder / "summary.json",
        "path": folder / "path.csv",
        "map": folder / "map.npy",
        "cells": folder / "cells.csv",
        "mission": mission,
        "ground": ground,
    }
    autopilot.close()


LOST = (">&- 2>&-", ">full 2>full", ">broken 2>broken", ">broken")


@pytest.mark.parametrize(
    ("name", "redirection"),
    [
        # Each command with one of them, in rotation, because all combinations take minutes.
        pytest.param(name, lost, marks=pytest.mark.ci if (i + j) % 4 == 0 else pytest.mark.long)
        for i, name in enumerate(COMMANDS)
        for j, lost in enumerate(LOST)
    ],
)
def test_every_command_without_its_output(redirected, inputs, tmp_path, name, redirection):
    """The job is done, its file exists, and the exit status says that the output is lost."""
    arguments, file = COMMANDS[name]
    given = [argument.format(**inputs, out=tmp_path) for argument in arguments]
    done = redirected(redirection, *given)
    assert (done.returncode, done.stdout) == (1, "")
    assert "Traceback" not in done.stderr
    assert "rror" not in done.stderr
    assert file is None or (tmp_path / file).stat().st_size > 0
