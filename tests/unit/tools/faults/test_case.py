"""Cases: drawn from a seed, kept as text."""

from collections import Counter

import pytest

from tools.faults.case import Case, Extent, draw
from tools.faults.line import LineFault, Way


EXTENT = Extent({Way.TO_BOARD: 20_000, Way.FROM_BOARD: 10_000}, readings=500, lines=9_000)


def drawn(seed):
    return draw(seed, "paper", lambda work: EXTENT)


@pytest.mark.parametrize("seed", range(20))
def test_a_seed_decides_everything(seed):
    case = drawn(seed)
    assert case == drawn(seed)
    assert Case.from_json(case.to_json()) == case
    assert case.with_faults(case.faults) == case
    assert case.with_faults([]).faults == []


def test_every_fault_is_drawn():
    cases = [drawn(seed) for seed in range(500)]
    faults = Counter(event.fault for case in cases for event in case.line)
    assert set(faults) == set(LineFault)
    assert {event.way for case in cases for event in case.line} == set(Way)
    assert {case.sessions_before for case in cases} == {0, 1, 254, 255}
    assert any(case.jumps for case in cases)
    assert any(case.signal_at is not None for case in cases)
    assert {case.resumes for case in cases} == {True, False}
    # Some sessions have no fault but a signal, or none at all.
    assert any(not case.line for case in cases)
