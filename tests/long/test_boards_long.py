"""Long runs of the simulated board, compared with the model; the default chip at its pins."""

import random

import pytest

from pathgene.hdl.config import Config, SurvivorSelection
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.sim.exported import exported_verilog
from tests.support.gateware.chips import SMALL
from tests.support.gateware.fuzz import fuzz_simulated_board
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
    """The maximum cycles of a generation hold, by the chip's counters."""
    chips = pair(DEFAULT, seed=13)
    full = DEFAULT.max_waypoints
    chips.start(full)
    for _ in range(10_000):
        chips.step(LinkMode.RECIPE)
        chips.lengthen()
    counters = chips.check()
    assert counters["generations"] == 10_000
    assert counters["longest"] == full + 4 <= full + 8
    assert counters["crossover"] + counters["mutation"] + counters["update"] == 10_000 * (full + 4)


def test_icarus_for_fifty_generations(pair, icarus):
    chips = pair(DEFAULT, seed=14, sim="icarus")
    chips.start(2)  # The shortest paths: this takes minutes.
    for _ in range(50):
        chips.step()
    chips.check()


@pytest.mark.parametrize("seed", range(2, 6))
def test_random_frames(seed):
    """The short run of this test, with 120,000 frames."""
    fuzz = fuzz_simulated_board(SMALL, seed, frames=30_000)
    assert min(fuzz.statuses.values()) > 100, fuzz.statuses


def test_random_frames_to_the_default_chip():
    """Hundreds of frames upload its map; thousands follow."""
    fuzz = fuzz_simulated_board(DEFAULT, 6, frames=4000)
    assert min(fuzz.statuses.values()) > 5


def test_default_chip_at_its_pins():
    """The bench drives the whole chip in the paper's sizes."""
    result = run(
        "verilator",
        exported_verilog("chip", DEFAULT),
        "chip",
        BENCHES / "cosim_chip.py",
        env={"CHIP": "default"},
        label="planner-default-verilator",
    )
    assert result.tests == 5
