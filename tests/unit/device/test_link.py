"""The host's end of the line: sessions, and commands executed once and in order."""

import dataclasses
import re

import pytest

from pathgene.hdl.protocol.codec import CRC_BYTES
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError, RefusedError
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.faults import FaultyTransport, VirtualClock
from tests.unit.device.link_bench import (
    CONFIG,
    FIRST,
    USES_UP_THE_NUMBER,
    Recorder,
    Script,
    connect,
    lose,
    twice,
    without_delimiter,
)


def test_opens_the_chips_next_session():
    link, chip, clock = connect()
    assert link.session == chip.session == 42
    assert clock() < 0.001
    assert link.traffic.frames_to_board == link.traffic.frames_from_board == 2
    assert link.traffic.frames_repeated == 0


def test_traffic_since_an_earlier_state():
    link, _, _ = connect()
    before = dataclasses.replace(link.traffic)
    link.request(Command.WRITE, b"12345")
    since = link.traffic.since(before)
    assert (since.frames_to_board, since.frames_from_board, since.exchanges) == (1, 1, 1)
    assert since.bytes_to_board == link.traffic.bytes_to_board - before.bytes_to_board > 5


def test_sessions_wrap_past_that_of_a_reset_chip():
    chip = Recorder()
    chip.session = 255
    link, _, _ = connect(chip=chip)
    assert link.session == chip.session == 1
    assert link.request(Command.STATUS) == b""


@pytest.mark.parametrize("previous", range(256))
def test_a_reset_is_noticed_in_every_session(previous):
    """The next command and the next session notice it, because a reset chip has neither number."""
    sentence = r"^The board was reset or taken by another host: open it again\.$"
    chip = Recorder()
    chip.session = previous
    link, _, _ = connect(chip=chip)
    executed = link.request(Command.WRITE, b"before")
    chip.__init__()
    chip.session = 0
    with pytest.raises(LinkError, match=sentence):
        link.request(Command.STATUS)
    with pytest.raises(LinkError, match=sentence if link._latest_session < 255 else LAST_SESSION):
        link.reopen()
    assert executed == b"before"
    assert chip.executed == []
    link.open(link.info()[0], credit=CONFIG.receive_buffer)
    assert link.session == 1


LAST_SESSION = r"^The last session with the board cannot be resumed: open it again\.$"


def test_the_last_session_is_not_resumed():
    chip = Recorder()
    chip.session = 254
    link, _, _ = connect(chip=chip)
    assert link.session == 255
    with pytest.raises(LinkError, match=LAST_SESSION):
        link.reopen()
    assert link.session is None
    link.open(link.info()[0], credit=CONFIG.receive_buffer)
    assert link.session == 1


def test_requests_are_numbered_and_answered():
    link, chip, _ = connect()
    for number in range(600):
        payload = number.to_bytes(2, "little")
        assert link.request(Command.WRITE, payload) == payload
    assert chip.executed == [(Command.WRITE, n.to_bytes(2, "little")) for n in range(600)]
    assert link.traffic.frames_repeated == 0


@pytest.mark.parametrize("change", [lose, without_delimiter, lambda frame: b"\7" + frame])
@pytest.mark.parametrize("direction", ["to_board", "from_board"])
def test_a_damaged_frame_costs_one_timeout(direction, change):
    link, chip, clock = connect(**{direction: Script({FIRST: change})})
    assert link.request(Command.START, b"seed") == b"seed"
    assert link.request(Command.STATUS) == b""
    assert chip.executed == [(Command.START, b"seed"), (Command.STATUS, b"")]
    assert link.traffic.frames_repeated == 1
    assert 0.25 <= clock() < 0.26
    assert 0.25 <= link.traffic.waiting_s < 0.26


@pytest.mark.parametrize("direction", ["to_board", "from_board"])
def test_a_repeated_frame_changes_nothing(direction):
    link, chip, _ = connect(**{direction: Script(dict.fromkeys(range(9), twice))})
    for number in range(5):
        assert link.request(Command.WRITE, bytes([number])) == bytes([number])
    assert chip.executed == [(Command.WRITE, bytes([n])) for n in range(5)]
    assert link.traffic.frames_repeated == 0


def test_info_and_open_are_repeated():
    link, chip, _ = connect(Script({0: lose, 1: lose, 3: lose}), Script({0: lose, 2: lose}))
    assert link.session == chip.session == 42
    assert link.request(Command.STATUS) == b""


def test_transfer_fills_exactly_the_window():
    held = bytearray()

    def hold(data):
        held.extend(data)
        return b""

    link, chip, _ = connect()
    payloads = [bytes([n]) * 50 for n in range(40)]
    link._transport._to_board = hold
    link.attempts = 1
    with pytest.raises(LinkTimeoutError):
        link.transfer([(Command.WRITE, payload) for payload in payloads])
    bodies = [body for body, _ in FrameReceiverModel(CONFIG).feed(bytes(held))]
    assert len(bodies) == 4
    assert sum(len(body) + CRC_BYTES for body in bodies) <= CONFIG.receive_buffer
    assert sum(len(body) + CRC_BYTES for body in bodies) + 57 > CONFIG.receive_buffer
    assert chip.executed == []


def test_at_most_64_commands_are_unanswered():
    held = bytearray()
    link, _, _ = connect()
    link.open(link.info()[0], credit=10_000)
    link._transport._to_board = lambda data: held.extend(data) or b""
    link.attempts = 1
    with pytest.raises(LinkTimeoutError):
        link.transfer([(Command.WRITE, bytes([n])) for n in range(200)])
    assert bytes(held).count(b"\0") - bytes(held).startswith(b"\0") == 64


def test_transfer_without_faults():
    link, chip, _ = connect()
    commands = [(Command.WRITE, bytes([n % 256]) * (1 + n % 60)) for n in range(700)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert chip.executed == commands
    assert link.traffic.frames_repeated == 0
    assert link.transfer([]) == []
    assert link.request(Command.STATUS) == b""


def test_transfer_repeats_a_gap_without_a_timeout():
    link, chip, clock = connect(Script({FIRST + 1: lose}))
    commands = [(Command.WRITE, bytes([n]) * 20) for n in range(30)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert chip.executed == commands
    assert clock() < 0.25
    # A gap causes one repetition of everything after it.
    assert link.traffic.frames_repeated <= CONFIG.receive_buffer // 27
    assert chip.statuses.count(Status.OUT_OF_ORDER) <= CONFIG.receive_buffer // 27


def test_transfer_repeats_a_request_whose_reply_was_lost():
    link, chip, clock = connect(from_board=Script({FIRST + 1: lose, FIRST + 3: lose}))
    commands = [(Command.READ, bytes([n])) for n in range(1, 20)]
    assert link.transfer(commands) == [bytes(n) for n in range(1, 20)]
    assert chip.executed == [*commands, commands[1], commands[3]]
    # Later answers acknowledge these commands, so nobody waits for theirs.
    assert clock() < 0.25


def test_transfer_repeats_the_last_request():
    link, chip, clock = connect(from_board=Script({FIRST + 2: lose}))
    commands = [(Command.READ, bytes([n])) for n in range(1, 4)]
    assert link.transfer(commands) == [bytes(n) for n in range(1, 4)]
    assert chip.executed == commands
    assert 0.25 <= clock() < 0.26


def test_replaces_a_long_reply_by_a_shorter_one():
    def drop_long(frame):
        return b"" if len(frame) > 100 else frame

    link, chip, clock = connect(from_board=Script(dict.fromkeys(range(100), drop_long)))
    assert link.request(Command.READ, bytes([200]), shorter=bytes([5])) == bytes(5)
    assert chip.executed == [(Command.READ, bytes([200]))]
    assert 1.0 <= clock() < 1.01
    assert link.request(Command.STATUS) == b""


def test_a_refusal_names_command_and_status_and_keeps_the_session():
    link, chip, _ = connect()
    sentence = (
        "The board refused the command WRITE with BAD_VALUE: host and board disagree; "
        "use the release it was built with."
    )
    with pytest.raises(RefusedError, match=f"^{re.escape(sentence)}$") as caught:
        link.request(Command.WRITE, b"!")
    assert caught.value.status == Status.BAD_VALUE
    assert link.request(Command.WRITE, b"fine") == b"fine"
    assert chip.executed == [USES_UP_THE_NUMBER, (Command.WRITE, b"fine")]


def test_a_refusal_in_a_transfer_ends_the_session():
    link, chip, _ = connect()
    with pytest.raises(RefusedError):
        link.transfer([(Command.WRITE, b"1"), (Command.WRITE, b"!"), (Command.WRITE, b"3")])
    assert chip.executed == [(Command.WRITE, b"1")]
    sentence = r"^No session with the board is open; open the board again\.$"
    with pytest.raises(LinkError, match=sentence):
        link.request(Command.STATUS)
    link.reopen()
    assert link.session == 43
    assert link.request(Command.STATUS) == b""


def test_a_status_without_a_name_is_refused_by_number():
    assert str(RefusedError(77, 99)).startswith("The board refused the command 77 with 99: ")


def test_close_closes_the_port():
    link, _, _ = connect()
    link.close()
    assert link._transport.closed
    with pytest.raises(LinkError, match=r"^No session"):
        link.request(Command.STATUS)


def test_traffic_counts_every_byte():
    sent, received = [], []
    link, _, _ = connect(
        lambda data: sent.append(data) or data, lambda data: received.append(data) or data
    )
    link.transfer([(Command.WRITE, bytes(n)) for n in range(40)])
    assert link.traffic.bytes_to_board == sum(map(len, sent))
    assert link.traffic.bytes_from_board == sum(map(len, received))
    assert link.traffic.frames_to_board == link.traffic.frames_from_board == 42
    assert link.traffic.frames_damaged == 0


def test_refuses_parameters():
    port = FaultyTransport(lambda data: b"", VirtualClock())
    with pytest.raises(ValueError, match=r"^Timeout must be above 0 s, not 0$"):
        Link(port, timeout_s=0)
    with pytest.raises(ValueError, match=r"^Attempts must be 1 or more, not 0$"):
        Link(port, attempts=0)


def test_refuses_a_payload_longer_than_the_chips_buffer():
    link, chip, _ = connect()
    assert link.request(Command.WRITE, bytes(249)) == bytes(249)
    with pytest.raises(ValueError, match=r"^Payload must have at most 249 bytes, not 250$"):
        link.request(Command.WRITE, bytes(250))
    assert link.request(Command.STATUS) == b""
    assert len(chip.executed) == 2
