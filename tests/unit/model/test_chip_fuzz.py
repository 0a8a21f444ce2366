"""Random frames with right checksums to the model of each kind of chip."""

import collections

import pytest

from hdl.protocol import Status
from tests.command_fuzz import CHIPS, fuzz, table
from tests.frame_mix import KINDS


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
    """Half a million frames of each kind of chip in the long run; :mod:`tests.command_fuzz`."""
    counts = collections.Counter()
    for seed in range(seeds):
        counts += fuzz(chip, seed, frames)
    print(table(counts))
    assert counts.total() == seeds * frames
    assert {kind for kind, _ in counts} == set(KINDS)
    # No model is busy: a run is over before the next command.
    assert {status for _, status in counts} == {*Status, None} - {Status.BUSY}
