"""Simulated boards with a collision checker, compared with the model of the same chip."""

import random

import numpy as np
import pytest

from pathgene.hdl.protocol.codes import Command, LinkMode, Status, StickyError
from pathgene.host.device.link import RefusedError
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.base import Options
from tests.support.gateware.chips import CHECKERS, random_path, without_line_cycles
from tests.support.gateware.fuzz import fuzz_simulated_board
from tools.chips import board_url


pytestmark = pytest.mark.cosim

CHIP = pytest.mark.parametrize(
    "config",
    [
        pytest.param(config, id=name, marks=[pytest.mark.ci] if name == "two-tier" else [])
        for name, config in CHECKERS.items()
    ],
)


@pytest.fixture
def pair(pair):
    """Function that opens a simulated board and its model with a map, closed after the test."""

    def open_pair(config, **options):
        chips = pair(config, **options)
        upload(chips, np.random.default_rng(1), config.map_size, config.map_size)
        return chips

    return open_pair


def upload(chips, rng, rows, columns, x=0, y=0):
    """Write low ground with peaks and blocked cells to both."""
    heights = rng.choice((0, 1, 2, 9, 15), (rows, columns), p=(0.5, 0.3, 0.16, 0.03, 0.01))
    for chip in (chips.board, chips.model):
        chip.upload_map(heights, x, y)


def check_all(chips, counting):
    """Check a path and the population on both; compare the results, cycles included."""
    config, rng = chips.config, chips.rng
    path = random_path(config, rng, rng.randint(2, config.max_waypoints + 2))
    start, goal = random_path(config, rng, 2)
    told, expected = (
        (chip.check_path(path, counting=counting),
         chip.check_population(start, goal, counting=counting))
        for chip in (chips.board, chips.model)
    )  # fmt: skip
    assert told == expected, (path, start, goal)
    return told


@pytest.mark.ci
@CHIP
def test_verdicts_and_cycles_match_the_model(pair, config):
    """Paths evolve and the map changes between the checks."""
    chips = pair(config)
    rng = np.random.default_rng(2)
    chips.start()
    collisions = paths = 0
    for number in range(12):
        one, every = check_all(chips, counting=bool(number % 2))
        collisions += sum(verdict.collision for verdict in one.verdicts + every.verdicts)
        paths += 1 + config.population
        chips.step(LinkMode.RANK)
        upload(chips, rng, 4, 6, int(rng.integers(11)), int(rng.integers(13)))
    counters = chips.check()
    assert counters["paths"] == paths
    assert 0.1 * paths < collisions < paths
    assert counters["feasibility"] > 0


@pytest.mark.ci
@CHIP
def test_new_waypoints_avoid_the_ground(pair, config):
    chips = pair(config)
    rng = random.Random(3)
    highest = config.map_size - 1
    for chip in (chips.board, chips.model):
        chip.start(7, (highest, highest, 4), avoid_ground=True)
    chips.load(0, [random_path(config, rng) for _ in range(config.population)])
    for _ in range(15):
        chips.step(LinkMode.RECIPE)
    counters = chips.check()
    assert counters["redrawn"] > 0
    assert counters["left_out"] > 0


@pytest.mark.ci
@pytest.mark.parametrize("checker", ["two-tier", pytest.param("parallel", marks=pytest.mark.long)])
def test_check_only_chip(pair, checker):
    """Verdicts and cycles match the model, and commands of the genetic core are refused."""
    chips = pair(CHECKERS[checker].replace(core="none"))
    rng, config = chips.rng, chips.config
    high = 12 << 2 * config.coordinate_bits  # Above all cells except blocked ones.
    told = []
    for number in range(20):
        path = random_path(config, rng, 2 + number % (config.max_waypoints + 1))
        if number < 10:
            path = [point | high for point in path]
        one, other = (
            chip.check_path(path, counting=bool(number % 2)) for chip in (chips.board, chips.model)
        )
        assert one == other, path
        told += one.verdicts
    assert 0 < sum(verdict.collision for verdict in told) < 20
    for chip in (chips.board, chips.model):
        with pytest.raises(RefusedError, match="START with UNKNOWN_COMMAND"):
            chip.link.request(Command.START, bytes(15))
    assert chips.board.status() == chips.model.status()
    counters, expected = chips.board.counters(), chips.model.counters()
    assert without_line_cycles(counters) == without_line_cycles(expected)
    assert counters["paths"] == 20


@CHIP
def test_plans_with_counted_collisions_as_the_model(config, evaluator):
    options = Options(generations=15, seed=2)
    board, model = (
        FpgaGeneticPlanner(board=board_url(scheme, config), feasibility="board").plan(
            evaluator, options
        )
        for scheme in ("sim", "model")
    )
    assert board.history == model.history
    assert np.array_equal(board.path, model.path)
    told, expected = (run.hardware["feasibility"] for run in (board, model))
    assert told == expected
    assert told["redrawn"] > 0
    assert board.hardware["cycles"]["feasibility"] == model.hardware["cycles"]["feasibility"] > 0


@pytest.mark.long
def test_icarus_agrees(pair, icarus):
    chips = pair(CHECKERS["parallel"], sim="icarus")
    chips.start()
    for counting in (False, True):
        chips.step()
        check_all(chips, counting)
    chips.check()


@pytest.mark.ci
def test_replies_to_random_frames_as_the_model():
    """Intact, broken, repeated and damaged frames of every command match byte for byte."""
    fuzz = fuzz_simulated_board(CHECKERS["parallel"], seed=1, frames=3000)
    counts = {status: fuzz.statuses[status] for status in Status if status is not Status.BUSY}
    assert min(counts.values()) > 20, counts
    assert StickyError.CRC in fuzz.dropped
