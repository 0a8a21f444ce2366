import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.sim.model.planner.definition.memo import Memo
from pathgene.sim.model.planner.memo import (
    HITS,
    MARGIN,
    NO_ROW,
    START,
    STOP,
    empty_memo,
    packed,
    row_of,
)
from tests.support.planner.cases import SMALL, USUAL, path


@pytest.mark.parametrize("size", [0, 2, 16, 512])
@pytest.mark.parametrize("config", [SMALL, USUAL], ids=["small", "usual"])
def test_both_memos_answer_for_the_same_segments(config: Config, size):
    """And for no other segment than the one that was kept."""
    rng = np.random.default_rng(9)
    plain, compiled = Memo(config, size), empty_memo(size)
    width = max(size.bit_length() - 1, 0)
    known = {}
    points = path(config, rng, waypoints=5)
    hits = 0
    for number in range(3000):
        start, stop = (points[i] for i in rng.integers(len(points), size=2))
        ends = [packed(config.coordinate_bits, *end) for end in (start, stop)]
        row = row_of(size, width, *ends)
        is_known = row != NO_ROW and compiled[row, [START, STOP]].tolist() == ends
        walked = plain.get(start, stop)
        assert is_known == (walked is not None)
        if is_known:
            hits += 1
            assert walked == known[start, stop] == tuple(compiled[row, [HITS, MARGIN]].tolist())
        else:
            known[start, stop] = number, -number
            plain.put(start, stop, known[start, stop])
            if row != NO_ROW:
                compiled[row, [START, STOP, HITS, MARGIN]] = *ends, *known[start, stop]
    assert (hits > 0) == (size > 0)
