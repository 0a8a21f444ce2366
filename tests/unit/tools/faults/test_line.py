"""The line of the fault simulator, fault by fault."""

import contextlib
from collections import deque

import pytest

from tools.faults.line import FaultyLine, HangError, LineEvent, LineFault, VirtualClock, Way


FRAMES = [b"first\0", b"second\0", b"third\0"]


class Recorder:
    """A chip that answers each frame with itself, and notes its frames."""

    def __init__(self):
        self.fed = []

    def feed(self, data, reset=None):
        self.fed.append(data if reset is None else (data, reset))
        return data if reset is None else b""

    def wait(self, seconds):
        return b"", seconds


def passed(*events, write_timeout=None, frames=FRAMES):
    """Return the bytes that reach the chip, and the bytes of 100 reads of the host."""
    chip = Recorder()
    line = FaultyLine(chip, VirtualClock(), events, patience_s=1e9)
    line.timeout, line.write_timeout = 0.01, write_timeout
    for frame in frames:
        assert line.write(frame) == len(frame)
    received = b"".join(line.read(line.in_waiting or 1) for _ in range(100))
    assert line.happened == sorted(events, key=lambda event: list(Way).index(event.way))
    return chip.fed, received


def at(number, fault, value=0, way=Way.TO_BOARD):
    return LineEvent(number, way, fault, value)


def test_a_line_without_faults_passes_everything():
    assert passed() == (FRAMES, b"".join(FRAMES))


@pytest.mark.parametrize(
    ("fault", "value", "first"),
    [
        (LineFault.DROP, 0, b"fist\0"),
        (LineFault.FLIP, 1, b"fipst\0"),
        (LineFault.INSERT, ord("x"), b"fixrst\0"),
        (LineFault.REPEAT, 0, b"firrst\0"),
        (LineFault.REPEAT_FRAME, 0, b"first\0first\0"),
        (LineFault.MERGE, 0, b"first"),
        (LineFault.RESET, 7, (b"first\0", 7)),
    ],
)
def test_a_fault_of_bytes(fault, value, first):
    fed, _ = passed(at(2, fault, value))
    assert fed == [first, *FRAMES[1:]]


def test_a_fault_on_the_way_back():
    assert passed(at(2, LineFault.DROP, way=Way.FROM_BOARD)) == (FRAMES, b"fist\0second\0third\0")


def test_a_lost_delimiter_merges_frames():
    assert b"".join(passed(at(5, LineFault.DROP))[0]) == b"firstsecond\0third\0"


def test_a_lost_frame_does_not_arrive():
    assert passed(at(0, LineFault.LOSE_FRAME))[0] == FRAMES[1:]


def test_a_late_frame_arrives_behind_the_next():
    assert passed(at(0, LineFault.DELAY_FRAME))[0] == [b"second\0", b"first\0", b"third\0"]


def test_a_held_frame_arrives_before_a_later_one():
    events = at(0, LineFault.HOLD_FRAME, 2)
    assert passed(events)[0] == [b"second\0", b"first\0", b"third\0"]


def test_long_frames_are_lost_from_a_moment_on():
    frames = [b"a long one\0", b"a\0", b"another long one\0", b"b\0"]
    lost = at(3, LineFault.LOSE_LONG, 6)
    assert passed(lost, frames=frames)[0] == [b"a\0", b"b\0"]


def test_all_frames_of_a_gap_are_lost():
    chip = Recorder()
    line = FaultyLine(chip, VirtualClock(), [at(6, LineFault.GAP, 1000)])
    line.timeout = 0.6
    received = []
    for frame in [*FRAMES, b"fourth\0"]:
        line.write(frame)
        received.append(line.read(9))
    assert chip.fed == received[:1] + received[3:] == [b"first\0", b"fourth\0"]
    assert received[1:3] == [b"", b""]


def test_a_babbling_board_repeats_its_latest_frame():
    line = FaultyLine(Recorder(), VirtualClock(), [at(9, LineFault.BABBLE, 100)], patience_s=1.0)
    line.timeout = 1.0
    for frame in FRAMES[:2]:
        line.write(frame)
        assert line.read(9) == FRAMES[0]
    assert line.clock.now_s == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(HangError, match=r"^no end after 8 s without a new answer$"):
        deque((line.read(9) for _ in range(100)), maxlen=0)
    line.heal()
    line.write(FRAMES[2])
    assert line.read(9) == FRAMES[2]


def test_frames_arrive_one_by_one():
    line = FaultyLine(Recorder(), VirtualClock())
    line.timeout = 0.01
    for frame in FRAMES:
        line.write(frame)
    assert [line.read(line.in_waiting) for _ in FRAMES] == FRAMES


def test_noise_is_as_long_as_it_says_and_always_the_same():
    fed = passed(at(2, LineFault.NOISE, 40))[0]
    assert len(fed[0]) == len(FRAMES[0]) + 40
    assert fed == passed(at(2, LineFault.NOISE, 40))[0]
    assert fed != passed(at(3, LineFault.NOISE, 40))[0]


def test_a_stall_holds_back_what_follows():
    chip, clock = Recorder(), VirtualClock()
    line = FaultyLine(chip, clock, [at(6, LineFault.STALL, 2000)])
    line.timeout = 1.0
    for frame in FRAMES:
        line.write(frame)
    assert chip.fed == FRAMES[:1]
    assert line.read(6) == FRAMES[0]
    assert line.read() == b""
    assert line.read(7) == FRAMES[1]
    assert clock.now_s == pytest.approx(2.0, abs=1e-3)
    assert chip.fed == FRAMES


def test_a_healed_line_passes_what_was_held_back():
    chip = Recorder()
    line = FaultyLine(chip, VirtualClock(), [at(0, LineFault.STALL, 10**6), at(9, LineFault.DROP)])
    line.timeout = 1.0
    line.write(FRAMES[0])
    line.heal()
    line.write(FRAMES[1])
    assert [line.read(13), line.read(13)] == FRAMES[:2]


@pytest.mark.parametrize("way", list(Way))
def test_a_cut_port_is_lost(way):
    line = FaultyLine(Recorder(), VirtualClock(), [at(3, LineFault.CUT, way=way)])
    line.timeout = 1.0
    with contextlib.suppress(OSError):  # The answer is lost after the write.
        line.write(FRAMES[0])
    with pytest.raises(OSError, match=r"^the device is gone$"):
        line.read()
    line.heal()
    with pytest.raises(OSError, match=r"^the device is gone$"):
        line.write(FRAMES[0])


def test_a_full_port_takes_time_or_fails():
    full = at(3, LineFault.FULL, 2000)
    assert passed(full, write_timeout=3.0)[0] == FRAMES
    assert passed(full)[0] == FRAMES
    with pytest.raises(TimeoutError, match=r"^the port took no bytes$"):
        passed(full, write_timeout=1.0)
    line = FaultyLine(Recorder(), VirtualClock(), [full], patience_s=1.0)
    with pytest.raises(HangError, match=r"^a write without a timeout$"):
        line.write(FRAMES[0])


def test_silence_without_end_is_a_hang():
    line = FaultyLine(Recorder(), VirtualClock(), patience_s=3.0)
    line.timeout = 1.0
    for _ in range(3):
        line.read()
    with pytest.raises(HangError, match=r"^no end after 4 s of silence$"):
        line.read()
    line.timeout = None
    with pytest.raises(HangError, match=r"^a read without a timeout$"):
        line.read()


def test_a_clock_jumps_where_it_is_told():
    clock = VirtualClock({1: 60.0})
    assert [clock() for _ in range(3)] == [0.0, 60.0, 60.0]
