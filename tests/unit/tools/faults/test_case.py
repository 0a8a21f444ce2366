"""Cases: drawn from a seed, stored as text."""

import errno
import time
from collections import Counter

import pytest

from pathgene.host.interrupts import SIGNALS as CAUGHT
from tools.faults.case import Case, DiskExtent, Extent, draw, shrunk
from tools.faults.disk import SLOW, FaultyDisk
from tools.faults.line import LineEvent, LineFault, Way
from tools.faults.tracing import SIGNALS, signal_of


EXTENT = Extent(
    {Way.TO_BOARD: 20_000, Way.FROM_BOARD: 10_000},
    readings=500,
    lines=9_000,
    firsts=(17_000,),
    commands=(tuple((at, at + 500) for at in range(1_000, 9_000, 10)), ((12_000, 13_000),)),
)


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
    resets = [
        case
        for case in cases
        if any(event.fault is LineFault.RESET and event.at == 17_000 for event in case.line)
    ]
    assert {case.sessions_before for case in resets} == {255}
    # The only command of its kind meets a fault as often as 800 of another kind.
    places = [event.at for case in cases for event in case.line if event.fault is LineFault.GAP]
    assert any(at in range(12_000, 13_004) for at in places)
    assert any(at in range(1_000, 9_500) for at in places)
    assert any(case.signal_at is not None for case in cases)
    assert {case.resumes for case in cases} == {True, False}
    # Some sessions have only a signal as a fault, or none at all.
    assert any(not case.line for case in cases)


def test_every_signal_and_every_fault_of_the_disk_is_drawn():
    extent = DiskExtent(calls=40, lines=3_000)
    cases = [draw(seed, "comparison", lambda work: extent) for seed in range(500)]
    assert {signal_of(case.signal_at) for case in cases if case.signal_at is not None} == set(
        SIGNALS
    )
    assert set(SIGNALS) == set(CAUGHT)
    faults = [fault for case in cases for fault in case.disk]
    errors = {errno.ENOSPC, errno.EIO, errno.EROFS, SLOW}
    assert {fault.error for fault in faults if not fault.kill} == errors
    assert any(fault.kill and not fault.power for fault in faults)
    assert any(fault.kill and fault.power for fault in faults)
    assert any(fault.lasting and fault.calls for fault in faults)
    assert any(case.death_after is not None for case in cases)


def test_a_slow_disk_writes_everything(tmp_path):
    for lasting in (False, True):
        disk = FaultyDisk(1, error=SLOW, lasting=lasting)
        begun = time.monotonic()
        with disk.create(tmp_path / f"{lasting}") as file:
            file.write(b"all")
        assert time.monotonic() - begun > 0.003
        assert (disk.slowed, disk.failed) == (True, False)
        assert (tmp_path / f"{lasting}").read_bytes() == b"all"


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
