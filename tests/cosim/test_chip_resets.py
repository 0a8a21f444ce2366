"""A reset of the whole chip for one cycle, at any moment of any command.

The host must notice and report it, unless it has already finished. All earlier answers must be
correct, and a new session on the same chip must do the same job with the same results.
"""

import contextlib
import random

import numpy as np
import pytest

from pathgene.hdl.protocol.codes import LinkMode
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.cli import main
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError
from pathgene.sim.board.scheme import start_simulated
from tests.support.gateware.chips import CHECKING, SMALL, random_paths
from tests.support.planner.cases import SMALL as SMALL_PLANNER
from tests.support.planner.cases import ground, record, shape
from tools.chips import board_url


pytestmark = pytest.mark.cosim

PLANNER = SMALL_PLANNER.replace(clocks_per_bit=4, receive_buffer=512)
#: Maximum cycles from a byte to the reset: within a byte, within a reply, within a run.
FAR = (40, 3_000, 40_000)
#: Bytes of INFO and OPEN, during which at least one reset in four happens.
OPENING_BYTES = 24
RESET = "The board was reset or taken by another host: open it again."
LAST_SESSION = "The last session with the board cannot be resumed: open it again."


def breed(chip):
    """Yield all results of map, generations in each mode, counts and reads."""
    config, rng = chip.config, random.Random(1)
    slots = range(config.population)
    if config.checks_paths:
        chip.update_map(np.random.default_rng(1).integers(0, 9, (config.map_size,) * 2))
    chip.start(7, (config.map_size - 1,) * 2 + (9,), avoid_ground=config.checks_paths)
    chip.load(random_paths(config, rng))
    for mode in (*LinkMode, *LinkMode):
        yield chip.step(rng.sample(slots, len(slots)), mode)
    if config.checks_paths:
        start, goal = (rng.getrandbits(config.waypoint_bits) for _ in range(2))
        yield chip.check_population(start, goal, counting=True)
        yield chip.check_population(start, goal)
        yield chip.check_path([start, *chip.paths[0], goal], counting=True)
    yield chip.status()["generation"]
    yield chip.read(0, len(slots))
    assert chip.counters()["generations"] >= 6


def plan(chip):
    """Yield all results of a run, of a warm run around a shape, and of one that is stopped."""
    config, rng, runs = chip.config, np.random.default_rng(2), chip.runs

    def ended():
        return next(status for status in iter(runs.status, None) if not status.running)

    chip.update_map(ground(config, rng))
    runs.set_problem(record(config, rng))
    options = RunOptions(seed=5, cycles=10**6, generations=5, seeds=16, give_up_rank=3)
    runs.start(options)
    yield ended()
    yield runs.best()
    runs.block(shape(config, rng))
    runs.start(
        RunOptions(seed=6, cycles=10**6, generations=5, slopes=(), give_up_rank=3, warm=True)
    )
    yield ended()
    yield runs.best()
    runs.start(RunOptions(seed=7, cycles=(1 << 32) - 1, seeds=16, give_up_rank=3))
    runs.stop()
    assert not ended().running
    assert chip.counters()["generations"] >= 10


def session(port):
    """Open a session over the port; a silence of 0.1 s is a lost frame."""
    return Chip(Link(port, timeout_s=0.1, attempts=100))


def error_of(call, *arguments):
    """Return the sentence of the LinkError that the call raises, or None."""
    try:
        call(*arguments)
    except LinkError as error:
        return str(error)
    return None


def interrupted(port, job):
    """Execute the job; return its results until the reset was noticed, and whether it was."""
    results, chips = [], []

    def do():
        chips.append(session(port))
        results.extend(job(chips[0]))

    error = error_of(do)
    assert error in (None, RESET)
    if error and chips:
        assert error_of(chips[0].link.reopen) in (RESET, LAST_SESSION)
    return results, error is not None


def reset(board, after_bytes, after_cycles=0):
    """Reset the chip for one cycle, or cancel that with 0 bytes: see ``sim/board/bridge.hpp``."""
    board._order(f"reset {after_bytes} {after_cycles}")
    board._answer("armed")


@pytest.mark.ci
@pytest.mark.parametrize(
    ("config", "job", "resets"),
    [
        pytest.param(CHECKING, breed, 8, id="checker"),
        pytest.param(PLANNER, plan, 8, id="planner"),
        pytest.param(SMALL, breed, 16, id="core"),
        pytest.param(CHECKING, breed, 400, id="long-checker", marks=pytest.mark.long),
        pytest.param(PLANNER, plan, 400, id="long-planner", marks=pytest.mark.long),
        pytest.param(SMALL, breed, 200, id="long-core", marks=pytest.mark.long),
    ],
)
def test_a_reset_at_any_moment(config, job, resets):
    rng = random.Random(resets)
    noticed = 0
    url = board_url("sim", config, idle_clocks=4096)
    with start_simulated(url) as board, contextlib.closing(board.open()) as port:
        chip = session(port)
        expected = list(job(chip))
        size = chip.link.traffic.bytes_to_board
        for _ in range(resets):
            last = rng.choice((OPENING_BYTES, size, size, size))
            moment = rng.randint(1, last), rng.randrange(rng.choice(FAR))
            reset(board, *moment)
            results, cut = interrupted(port, job)
            assert results == expected[: len(results)], moment
            assert cut or len(results) == len(expected), moment
            noticed += cut
            reset(board, 0)
            assert list(job(session(port))) == expected, moment
    assert noticed > resets // 2


@pytest.mark.ci
@pytest.mark.parametrize(
    ("config", "planner", "after_bytes"),
    [(CHECKING, ("ga-fpga", "--generations", "1000"), 4_000), (PLANNER, ("ga-chip",), 1_500)],
    ids=["ga-fpga", "ga-chip"],
)
def test_a_reset_ends_a_plan_with_a_sentence(tmp_path, capsys, config, planner, after_bytes):
    terrain = tmp_path / "plain.npz"
    np.savez(terrain, elevation=np.zeros((21, 21)), dx_m=100.0, dy_m=100.0)
    with start_simulated(board_url("sim", config), keep=True) as board:
        command = ["plan", "--terrain", terrain, "--agl", "--start", "100,100,50", "--goal",
                   "1900,1900,50", "--board", board.url, "--planner", *planner,
                   "--out", tmp_path / "out"]  # fmt: skip
        reset(board, after_bytes)
        assert main(list(map(str, command))) == 1
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"pathgene: {RESET[:-1]}")


def test_a_reset_happens_once_and_can_be_taken_back():
    with (
        start_simulated(board_url("sim", SMALL)) as board,
        contextlib.closing(board.open()) as port,
    ):
        for number in range(3):
            assert session(port).info["session"] == number
        reset(board, 1000)
        reset(board, 0)
        chip = session(port)
        for _ in range(200):
            chip.status()
        reset(board, 1)  # In the start bit of the first byte, a delimiter.
        assert error_of(chip.status) == RESET
        assert session(port).info["session"] == 0
