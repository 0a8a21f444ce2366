"""The simulated board compared with the software model, both driven by the same host code."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import LinkMode, Status, StickyError
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkTimeoutError
from pathgene.host.errors import JobError
from pathgene.sim.board.scheme import start_simulated
from tests.support.gateware.chips import SMALL, Pair
from tests.support.gateware.fuzz import fuzz_simulated_board
from tests.support.host.processes import Started
from tools.chips import board_url


pytestmark = pytest.mark.cosim

ROOT = Path(__file__).resolve().parents[2]
DEFAULT = Config(clocks_per_bit=4)
#: The longest paths of the papers, in a small population.
LONG_PATHS = SMALL.replace(max_waypoints=20)


@pytest.mark.parametrize(
    "generations",
    [pytest.param(10, marks=pytest.mark.ci), pytest.param(60, marks=pytest.mark.long)],
)
def test_default_chip_generation_by_generation(pair, generations):
    """Every generation matches, and the counters equal the model's."""
    chips = pair(DEFAULT)
    chips.start()
    for _ in range(generations):
        chips.step()
    counters = chips.check()
    assert counters["generations"] == generations
    assert counters["mutation"] == 2 * generations
    assert counters["update"] == generations
    assert counters["longest"] <= DEFAULT.max_waypoints + 8


@pytest.mark.ci
@pytest.mark.parametrize("mode", LinkMode)
def test_default_chip_in_every_mode(pair, mode):
    chips = pair(DEFAULT, seed=2)
    for _ in range(2):
        chips.start()
        for _ in range(4):
            chips.step(mode)
        chips.check()


@pytest.mark.ci
@pytest.mark.parametrize(
    "config",
    [
        pytest.param(SMALL, id="small"),
        pytest.param(LONG_PATHS, id="long-paths", marks=pytest.mark.ci),
    ],
)
def test_other_chips_in_every_mode(pair, config):
    chips = pair(config, seed=3)
    for _ in range(3):
        chips.start()
        for mode in LinkMode:
            for _ in range(10):
                chips.step(mode)
        chips.check()


@pytest.mark.long  # test_check_boards.py has the same with a checker.
def test_icarus_agrees(pair, icarus):
    chips = pair(SMALL, seed=4, sim="icarus")
    chips.start()
    for mode in LinkMode:
        chips.step(mode)
    chips.check()


@pytest.mark.ci
@pytest.mark.parametrize(
    ("config", "generations"),
    [
        pytest.param(DEFAULT, 60, id="default"),
        pytest.param(LONG_PATHS, 60, id="long-paths", marks=pytest.mark.ci),
    ],
)
def test_cycles_of_full_length_parents(pair, config, generations):
    """A generation takes at most ``max_waypoints + 8`` cycles after its command is accepted."""
    chips = pair(config, seed=5)
    chips.start(config.max_waypoints)
    for _ in range(generations):
        chips.step(LinkMode.RECIPE)
        chips.lengthen()
    counters = chips.check()
    assert counters["longest"] == config.max_waypoints + 4 <= config.max_waypoints + 8
    assert counters["crossover"] == generations * (config.max_waypoints + 1)


@pytest.mark.ci
def test_replies_to_random_frames_as_the_model():
    """Intact, broken, repeated and damaged frames with garbage between them match byte for byte."""
    fuzz = fuzz_simulated_board(SMALL, seed=1, frames=3000)
    counts = {status: fuzz.statuses[status] for status in Status if status is not Status.BUSY}
    assert min(counts.values()) > 20, counts
    assert fuzz.dropped == {StickyError.MALFORMED, StickyError.CRC, StickyError.OVERRUN}


def children():
    """Return the child processes of this one, including ended ones."""
    found = set()
    for task in Path("/proc/self/task").iterdir():
        found.update(map(int, (task / "children").read_text().split()))
    return found


@pytest.mark.ci
def test_reports_a_killed_board_in_a_sentence():
    before = children()
    chip = open_board(board_url("sim", SMALL))
    (simulator,) = children() - before
    chip.load([[1, 2]] * SMALL.population)
    order = list(range(SMALL.population))
    chip.step(order)
    os.kill(simulator, signal.SIGKILL)
    sentence = r"^The simulated board ended with signal SIGKILL: it printed nothing\.$"
    with pytest.raises(JobError, match=sentence):
        chip.step(order)
    with pytest.raises(JobError):
        chip.step(order)
    chip.close()
    assert children() <= before


def test_gives_up_a_stopped_board_after_the_patience_of_its_url():
    before = children()
    with open_board(board_url("sim", SMALL) + "&patience=1.5") as chip:
        (simulator,) = children() - before
        os.kill(simulator, signal.SIGSTOP)
        begun = time.monotonic()
        with pytest.raises(LinkTimeoutError, match=r"^The board did not answer STATUS in "):
            chip.status()
        assert 1.5 <= time.monotonic() - begun < 6


def test_gives_up_a_stopped_board():
    before = children()
    with start_simulated(board_url("sim", SMALL)) as board:
        chip = Chip(Link(board.open(), timeout_s=0.2, attempts=3))
        chip.load([[1, 2]] * SMALL.population)
        os.kill(board.pid, signal.SIGSTOP)
        sentence = (
            "The board did not answer GENERATE in 3 attempts of 0.2 s: "
            "check its power, the cable and the line rate."
        )
        begun = time.monotonic()
        with pytest.raises(LinkTimeoutError, match=f"^{re.escape(sentence)}$"):
            chip.step(list(range(SMALL.population)))
        assert 0.6 <= time.monotonic() - begun < 3
    assert children() <= before


@pytest.mark.ci
def test_ctrl_c_does_not_wait_for_a_stopped_board(tmp_path):
    """The best path found is written immediately, and the simulator ends with its host."""
    terrain = tmp_path / "plain.npz"
    np.savez(terrain, elevation=np.zeros((21, 21)), dx_m=100.0, dy_m=100.0)
    command = [sys.executable, "-m", "pathgene", "plan", "--terrain", terrain, "--agl", "--start",
               "100,100,50", "--goal", "1900,1900,50", "--board", board_url("sim", SMALL),
               "--planner", "ga-fpga", "--generations", "1000000",
               "--out", tmp_path / "out"]  # fmt: skip
    with Started(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        while not process.stderr.readline().startswith("generation 0/"):
            assert process.poll() is None
        (simulator,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(int(simulator), signal.SIGSTOP)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=300)[1]
    assert process.returncode == 130
    assert error.splitlines()[-1] == "pathgene: Interrupted; the best path so far is written."
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["stopped_by"], summary["hardware"]) == ("interrupt", None)
    # The time until the signal, and one second more. Waiting for the board would take three
    # attempts of 5 s. A loaded machine draws the picture late, but that is not link time.
    assert 1 < summary["seconds"]["link"] < 10
    assert not Path(f"/proc/{simulator}").exists()


def test_resumed_board_executes_repeated_requests_once():
    model = open_board(board_url("model", SMALL))
    with start_simulated(board_url("sim", SMALL)) as board:
        chips = Pair(Chip(Link(board.open(), timeout_s=0.1, attempts=3)), model)
        chips.start()
        chips.step()
        os.kill(board.pid, signal.SIGSTOP)
        with pytest.raises(LinkTimeoutError):
            chips.board.step(range(SMALL.population))
        os.kill(board.pid, signal.SIGCONT)
        chips.board.link.reopen()
        chips.model.step(range(SMALL.population))
        assert chips.board.read(0, 8) == chips.model.read(0, 8)
        assert chips.board.status()["generation"] == 2
