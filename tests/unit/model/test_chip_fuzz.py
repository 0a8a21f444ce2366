"""Random frames with right checksums to the model of each kind of chip."""

import collections

import pytest

from pathgene.hdl.protocol import Status
from pathgene.sim.model.chip import Chip
from tests.support.gateware.command_fuzz import CHIPS, fault_free, fuzz, table
from tests.support.gateware.frame_mix import KINDS


#: Seeds, and frames of each after a reset.
SHORT, LONG = (1, 2000), (50, 10_000)


@pytest.mark.parametrize("chip", CHIPS)
@pytest.mark.parametrize(
    ("seeds", "frames"),
    [
        pytest.param(*SHORT, id="short"),
        pytest.param(*LONG, id="million", marks=pytest.mark.long),
    ],
)
def test_answers_by_the_rules_and_works_as_before(chip, seeds, frames):
    """The long run sends half a million frames to each kind of chip; see ``command_fuzz``."""
    counts = collections.Counter()
    for seed in range(seeds):
        counts += fuzz(chip, seed, frames)
    print(table(counts))
    assert counts.total() == seeds * frames
    assert {kind for kind, _ in counts} == set(KINDS)
    # No model is busy: a run is over before the next command.
    assert {status for _, status in counts} == {*Status, None} - {Status.BUSY}


def test_a_failure_names_the_command_that_repeats_it(monkeypatch):
    assert fault_free("paper")
    read = Chip._read
    monkeypatch.setattr(Chip, "_read", lambda *request: read(*request)[:-1])
    again = r"; again by: python -m tests\.support\.gateware\.command_fuzz paper 3 500$"
    with pytest.raises(AssertionError, match=rf"^frame 500 of seed 3, .*{again}"):
        fuzz("paper", 3, 600)
