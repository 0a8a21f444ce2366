"""Random frames with correct checksums to simulated boards and the model, byte for byte."""

import collections

import pytest

from pathgene.hdl.protocol.codes import Status
from tests.support.gateware.command_fuzz import CHIPS, fuzz, table
from tests.support.gateware.frame_mix import KINDS
from tests.support.planner.run_fuzz import fuzz_during_runs


pytestmark = pytest.mark.cosim

#: Costly: a run is slow in simulated hardware.
PLANNER = pytest.param("planner", marks=pytest.mark.ci)


def fuzz_board(chip, seeds, frames):
    counts = collections.Counter()
    for seed in range(seeds):
        counts += fuzz(chip, seed, frames, board=True)
    print(table(counts))
    assert counts.total() == seeds * frames
    assert {kind for kind, _ in counts} == set(KINDS)
    assert {status for _, status in counts} == {*Status, None} - {Status.BUSY}


@pytest.mark.parametrize("chip", ["paper", PLANNER])
def test_answers_as_the_model(chip):
    """Each answer matches, and so does the state in later answers, also in valid sessions."""
    fuzz_board(chip, 1, 500)


@pytest.mark.long
@pytest.mark.parametrize("chip", CHIPS)
def test_answers_to_thousands_as_the_model(chip):
    """With the frames to runs, both chips get 20,000 frames."""
    fuzz_board(chip, 6, 1500)


@pytest.mark.parametrize(
    ("seeds", "frames"),
    [pytest.param(1, 200, marks=pytest.mark.ci), pytest.param(4, 500, marks=pytest.mark.long)],
)
def test_a_run_makes_commands_wait(seeds, frames):
    """A run delays commands by the rules, in order; a refused command changes nothing."""
    counts = collections.Counter()
    for seed in range(seeds):
        counts += fuzz_during_runs(seed, frames)
    print(table(counts))
    assert counts.total() == seeds * frames
    # Few are BAD_VALUE, because a repeated RUN is the only command with values that need not wait.
    rare = {Status.DUPLICATE, Status.BAD_VALUE}
    assert {status for _, status in counts} >= {*Status, None} - rare
