"""Frames that a chip of this protocol does not send: a link takes none of them as an answer."""

import re

import pytest

from pathgene.hdl.protocol import Command, Status
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from pathgene.host.device.link import Link, LinkTimeoutError, RefusedError
from tests.support.gateware.faults import FaultyTransport, VirtualClock
from tests.unit.device.link_bench import FIRST, Recorder, Script, connect


def test_reports_a_board_that_refuses_info():
    def refuse(data):
        ((body, plain),) = map(decode_frame, FrameSplitter().feed(data))
        return encode_frame(body[:2] + bytes([Status.UNKNOWN_COMMAND]), plain=plain)

    clock = VirtualClock()
    link = Link(FaultyTransport(refuse, clock), clock=clock)
    sentence = (
        "The board refused the command INFO with UNKNOWN_COMMAND: host and board disagree; use "
        "the release it was built with."
    )
    with pytest.raises(RefusedError, match=f"^{re.escape(sentence)}$"):
        link.info()


@pytest.mark.parametrize("stray", ["another-session", "plain"])
def test_ignores_frames_of_other_conversations(stray):
    def add(frame):
        (told, _) = decode_frame(frame[:-1])
        if stray == "plain":
            return encode_frame(told[:3] + b"other", plain=True) + frame
        return encode_frame(bytes([told[0] - 1]) + told[1:3] + b"other") + frame

    link, chip, clock = connect(from_board=Script(dict.fromkeys(range(FIRST, 9), add)))
    for number in range(3):
        assert link.request(Command.WRITE, bytes([number])) == bytes([number])
    assert len(chip.executed) == 3
    assert link.traffic.frames_repeated == 0
    assert clock() < 0.01


def test_ignores_a_refusal_of_a_command_that_was_executed():
    def add(frame):
        (told, _) = decode_frame(frame[:-1])
        return frame + encode_frame(told[:2] + bytes([Status.BAD_VALUE]))

    link, chip, _ = connect(from_board=Script({FIRST: add}))
    commands = [(Command.WRITE, bytes([number])) for number in range(4)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert chip.executed == commands


def test_late_refusals_of_a_command_do_not_meet_the_next(monkeypatch):
    """The next command has the number of a refused one."""
    # Frames arrive one by one.
    first = property(lambda port: port._received.find(b"\0") + 1)
    monkeypatch.setattr(FaultyTransport, "in_waiting", first)
    late = []

    def keep(frame):
        late.append(frame)
        return b""

    def both(frame):
        return frame + b"".join(late)

    # The first refusal arrives after the refusal of the repeated command.
    link, chip, _ = connect(from_board=Script({FIRST: keep, FIRST + 1: both}))
    with pytest.raises(RefusedError):
        link.request(Command.WRITE, b"!")
    assert link.traffic.frames_repeated == 1
    assert link.request(Command.WRITE, b"next") == b"next"
    assert chip.executed == [(Command.WRITE, b"next")]


def test_a_duplicate_does_not_stand_for_the_answer_to_the_latest_command():
    class Chip(Recorder):
        def _execute(self, session, sequence, code, payload):
            status, reply = super()._execute(session, sequence, code, payload)
            return (Status.DUPLICATE, b"") if code == Command.READ else (status, reply)

    link, _, _ = connect(chip=Chip(), attempts=3)
    assert link.request(Command.WRITE, b"seed") == b"seed"
    with pytest.raises(LinkTimeoutError, match=r"^The board did not answer READ in 3 attempts"):
        link.request(Command.READ, b"\5")
    assert link.session is None
