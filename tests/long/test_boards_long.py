"""Long runs of the simulated board against the software model; the paper's chip at its pins."""

import random

import pytest

from hdl.config import Config, SurvivorSelection
from hdl.protocol import LinkMode
from sim.board.scheme import start_simulated
from sim.exported import exported_verilog
from tests.chips import SMALL, board_url
from tests.fuzz import Fuzz
from tools.runner import BENCHES, run


pytestmark = [pytest.mark.long, pytest.mark.cosim]

DEFAULT = Config(clocks_per_bit=4)


@pytest.mark.parametrize(
    "config",
    [
        DEFAULT,
        DEFAULT.replace(max_waypoints=20, survivor_selection=SurvivorSelection.RANK),
    ],
    ids=["default", "long-paths-and-rank-survivors"],
)
def test_a_thousand_generations(pair, config):
    chips = pair(config, seed=11)
    rng = random.Random(12)
    for _ in range(10):
        chips.start()
        for _ in range(100):
            chips.step(rng.choice([LinkMode.RANK, LinkMode.RANK, LinkMode.RECIPE]))
        chips.check()


def test_ten_thousand_generations_of_full_length_parents(pair):
    """The promise on the clocks of a generation, by the chip's own counter."""
    chips = pair(DEFAULT, seed=13)
    full = DEFAULT.max_waypoints
    chips.start(full)
    for _ in range(10_000):
        chips.step(LinkMode.RECIPE)
        for slot, path in enumerate(chips.paths):
            if len(path) < full:
                chips.load(slot, [path + path[: full - len(path)]])
    counters = chips.check()
    assert counters["generations"] == 10_000
    assert counters["longest"] == full + 4 <= full + 8
    assert counters["crossover"] + counters["mutation"] + counters["update"] == 10_000 * (full + 4)


def test_icarus_for_fifty_generations(pair, icarus):
    chips = pair(DEFAULT, seed=14, sim="icarus")
    chips.start(2)  # As short as a run begins: this takes minutes.
    for _ in range(50):
        chips.step()
    chips.check()


@pytest.mark.parametrize("seed", range(2, 6))
def test_random_frames(seed):
    """As the short run of this, 120,000 frames in all."""
    fuzz = Fuzz(SMALL, seed)
    with start_simulated(board_url("sim", SMALL)) as board, board.open(timeout=10) as port:
        while fuzz.frames < 30_000:
            fuzz.exchange(port)
        port.timeout = 0.1
        assert port.read() == b""


def test_random_frames_to_the_default_chip():
    """Hundreds of frames upload its map; thousands follow."""
    fuzz = Fuzz(DEFAULT, 6)
    with start_simulated(board_url("sim", DEFAULT)) as board, board.open(timeout=30) as port:
        while fuzz.frames < 4000:
            fuzz.exchange(port)
    assert min(fuzz.statuses.values()) > 5


def test_default_chip_at_its_pins():
    """The bench of the whole chip at the paper's sizes."""
    result = run(
        "verilator",
        exported_verilog("planner", DEFAULT),
        "planner",
        BENCHES / "cosim_planner.py",
        env={"CHIP": "default"},
        label="planner-default-verilator",
    )
    assert result.tests == 5
