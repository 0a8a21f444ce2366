"""Simulated boards with the planner core, compared with the software model of the same chip."""

import dataclasses
import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.messages import map_request
from pathgene.hdl.protocol.paths import pack_cells
from pathgene.hdl.protocol.planner import PathClass
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.boards import open_board
from pathgene.host.device.link import RefusedError
from tests.support.gateware.fuzz import fuzz_simulated_board
from tests.support.planner.cases import SMALL, ground, record, shape
from tools.chips import board_url


pytestmark = pytest.mark.cosim

CHIP = SMALL.replace(clocks_per_bit=4, receive_buffer=512)
#: The same chip with a byte-wide port.
BYTES = CHIP.replace(clocks_per_bit=0)


@pytest.mark.parametrize("chip", [CHIP, BYTES], ids=["uart", "bytes"])
@pytest.mark.parametrize(
    "frames",
    [pytest.param(400, marks=pytest.mark.ci), pytest.param(20_000, marks=pytest.mark.long)],
)
def test_random_frames(chip, frames):
    """Intact and broken frames match, and for every run its paths and the cycles of all units."""
    fuzz = fuzz_simulated_board(chip, seed=frames, frames=frames)
    assert all(fuzz.statuses[status] for status in Status if status is not Status.BUSY)


@pytest.mark.ci
def test_a_run_makes_other_commands_wait():
    rng = np.random.default_rng(3)
    heights, problem, block = ground(CHIP, rng), record(CHIP, rng), shape(CHIP, rng)
    corner = map_request(CHIP).pack(x=1, y=2, width=1, height=1) + pack_cells(CHIP, [3])
    options = RunOptions(seed=5, cycles=(1 << 32) - 1, seeds=16, give_up_rank=3)
    with open_board(board_url("sim", CHIP)) as chip:
        chip.update_map(heights)
        runs = chip.runs
        runs.set_problem(problem)
        runs.start(options)
        for _ in range(2):
            for ask in (
                runs.best,
                lambda: runs.set_problem(problem),
                lambda: runs.block(block),
                lambda: runs.start(options),
                lambda: chip.link.request(Command.MAP, corner),
            ):
                with pytest.raises(RefusedError) as refused:
                    ask()
                assert refused.value.status == Status.BUSY
        seen = list(itertools.islice(iter(runs.status, None), 20))
        assert all(status.running for status in seen)
        assert seen[0].cycles < seen[-1].cycles
        assert chip.status()["errors"] == StickyError.REFUSED
        chip.clear_errors()
        runs.stop()
        ended = next(status for status in iter(runs.status, None) if not status.running)
        assert runs.status() == ended
        assert chip.counters()["generations"] == ended.generations > 0
        best = runs.best()
        assert best.classes[0] is PathClass.FEASIBLE
        assert best.keys[0] == ended.key
        # Opening a session again ends the run that the previous session left.
        runs.start(options)
        assert runs.status().running
        chip.reopen()
        assert not runs.status().running
        runs.set_problem(problem)


@pytest.mark.long
def test_a_run_is_the_same_on_every_board(icarus):
    """Paths, keys and cycles are equal on the model, Verilator and Icarus."""
    rng = np.random.default_rng(4)
    heights, problem, block = ground(CHIP, rng), record(CHIP, rng), shape(CHIP, rng)
    options = RunOptions(
        seed=5, cycles=10**6, generations=3, slopes=(0,), seeds=8, lifts=0, give_up_rank=3
    )
    warm = dataclasses.replace(options, seed=7, slopes=(), warm=True)
    told = []
    icarus_runs = {"sim": "icarus"}
    for scheme, config, query in (
        ("model", CHIP, {}),
        ("sim", CHIP, {}),
        ("sim", CHIP, icarus_runs),
        ("sim", BYTES, {}),
        ("sim", BYTES, icarus_runs),
    ):
        with open_board(board_url(scheme, config, **query)) as chip:
            chip.update_map(heights)
            chip.runs.set_problem(problem)
            chip.runs.block(block)
            runs = []
            for each in (options, warm):
                chip.runs.start(each)
                runs += [next(s for s in iter(chip.runs.status, None) if not s.running)]
            best = chip.runs.best()
            told.append((*runs, best.keys, best.paths))
    assert [run.generations for run in told[0][:2]] == [3, 3]
    assert all(each == told[0] for each in told)
