"""The memo of segments: it answers for the segment that was kept last in a row, and no other."""

import numpy as np
import pytest

from pathgene.hdl.config import Config
from tests.support.planner.cases import SMALL, USUAL, path
from tests.support.planner.plain import Memo


@pytest.mark.parametrize("size", [0, 2, 16, 512])
@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_a_memo_answers_for_the_segments_that_it_holds(config: Config, size):
    """A row holds one segment: the latest of all that share the row."""
    rng = np.random.default_rng(9)
    memo = Memo(config, size)
    values, holders = {}, {}
    points = path(config, rng, waypoints=5)
    hits = 0
    for number in range(3000):
        start, stop = (points[i] for i in rng.integers(len(points), size=2))
        found = memo.get(start, stop)
        row = row_of(config, size, start, stop)
        assert (found is not None) == (size > 0 and holders.get(row) == (start, stop))
        if found is not None:
            hits += 1
            assert found == values[start, stop]
        else:
            values[start, stop], holders[row] = (number, -number), (start, stop)
            memo.put(start, stop, values[start, stop])
    assert (hits > 0) == (size > 0)


def row_of(config, size, start, stop):
    """Return the row: the ends, one shifted, folded by exclusive or to the width of a row."""
    bits = config.coordinate_bits
    start, stop = (x | y << bits | z << 2 * bits for x, y, z in (start, stop))
    mixed, row = start ^ stop << 3, 0
    while size and mixed:
        row ^= mixed & size - 1
        mixed >>= size.bit_length() - 1
    return row
