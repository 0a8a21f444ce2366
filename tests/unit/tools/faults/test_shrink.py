"""Shrinking of a case to the faults that it needs."""

import pytest

from tools.faults.case import Case
from tools.faults.line import LineEvent, LineFault, Way
from tools.faults.shrink import shrunk


EVENTS = tuple(LineEvent(at, Way.TO_BOARD, LineFault.DROP) for at in range(100))


@pytest.mark.parametrize("needed", [(), (0,), (99,), (3, 4), (7, 50, 93)])
def test_what_is_needed_is_left(needed):
    case = Case(seed=1, session="paper", work=0, line=EVENTS, jumps=((3, 5.0),), signal_at=9)

    def fails(each):
        return {event.at for event in each.line} >= set(needed)

    least = shrunk(case, fails)
    assert tuple(event.at for event in least.line) == needed
    assert least.jumps == ()
    assert least.signal_at is None


def test_faults_of_every_kind_may_be_needed():
    case = Case(seed=1, session="paper", work=0, line=EVENTS, jumps=((3, 5.0),), signal_at=9)
    least = shrunk(case, lambda each: each.jumps != () and each.signal_at is not None)
    assert least == case.with_faults([("jumps", (3, 5.0)), ("signal_at", 9)])
