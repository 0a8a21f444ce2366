"""The host's end of the line: dead, silent and babbling boards, faults, interrupts."""

import random
import re

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Command, LinkMode, Status
from pathgene.hdl.protocol.messages import info_reply
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError, RefusedError
from pathgene.host.errors import JobError
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.core import Limits
from tests.support.gateware.faults import ByteFaults, FaultyTransport, FrameFaults, VirtualClock
from tests.unit.device.link_bench import (
    CONFIG,
    FIRST,
    USES_UP_THE_NUMBER,
    Recorder,
    Script,
    connect,
    lose,
    twice,
)


def test_gives_up_a_dead_board():
    link, _, clock = connect(Script(dict.fromkeys(range(FIRST, 99), lose)), attempts=3)
    sentence = (
        "The board did not answer GENERATE in 3 attempts of 0.25 s: "
        "check its power, the cable and the line rate."
    )
    with pytest.raises(LinkTimeoutError, match=f"^{re.escape(sentence)}$"):
        link.request(Command.GENERATE)
    assert 0.75 <= clock() < 0.76
    assert link.session is None


def test_reports_a_missing_board():
    clock = VirtualClock()
    link = Link(FaultyTransport(lambda data: b"", clock), timeout_s=0.5, attempts=4, clock=clock)
    with pytest.raises(LinkTimeoutError, match=r"^The board did not answer INFO in 4 attempts"):
        link.info()
    assert clock() == 2.0


def test_a_late_reply_to_open_does_not_match_the_first_command():
    held = []

    def hold(frame):
        held.append(frame)
        return b""

    # OPEN is repeated because its reply is late; then the first command is lost.
    link, chip, _ = connect(Script({3: lose}), Script({1: hold}))
    link._transport._received += held[0]
    assert link.request(Command.STATUS, b"payload") == b"payload"
    assert chip.executed == [(Command.STATUS, b"payload")]


def test_writing_time_does_not_count_as_waiting():
    """A write longer than an attempt causes no repetition."""
    link, chip, clock = connect()
    write = link._transport.write

    def slow(data):
        clock.now_s += 3.0
        return write(data)

    link._transport.write = slow
    link.open(link.info()[0], credit=CONFIG.receive_buffer)
    commands = [(Command.WRITE, bytes([n]) * 40) for n in range(10)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert link.request(Command.STATUS) == b""
    assert chip.executed == [*commands, (Command.STATUS, b"")]
    assert link.traffic.frames_repeated == 0


@pytest.mark.parametrize("command", ["info", "open"])
def test_ignores_an_echo(command):
    clock = VirtualClock()
    link = Link(FaultyTransport(bytes, clock), timeout_s=0.25, attempts=3, clock=clock)
    asked = link.info if command == "info" else lambda: link.open(41, credit=256)
    with pytest.raises(LinkTimeoutError, match=rf"did not answer {command.upper()} in 3 attempts"):
        asked()
    assert 0.75 <= clock() < 0.76


def test_accepts_a_reply_after_an_echo():
    chip = Recorder()
    clock = VirtualClock()
    link = Link(FaultyTransport(lambda data: data + chip(data), clock), clock=clock)
    link.open(link.info()[0], credit=256)
    assert (link.session, chip.session) == (42, 42)


def test_gives_up_a_babbling_board():
    clock = VirtualClock()
    port = FaultyTransport(lambda data: b"", clock)
    link = Link(port, timeout_s=0.25, attempts=2, clock=clock)
    for noise in (b"\7", encode_frame(b"\1\2\3"), encode_frame(b"\1\2\3", plain=True)):
        start = clock()

        def read(size, noise=noise):
            clock.now_s += 0.01
            return noise

        port.read = read
        with pytest.raises(LinkTimeoutError):
            link.info()
        assert clock() - start == pytest.approx(2 * 8 * 0.25, rel=0.02)


def test_reports_a_reset_board():
    link, chip, _ = connect()
    chip.session = 7
    sentence = r"^The board was reset or taken by another host: open it again\.$"
    with pytest.raises(LinkError, match=sentence):
        link.request(Command.STATUS)
    with pytest.raises(LinkError, match=sentence):
        link.reopen()
    link.open(link.info()[0], credit=256)
    assert link.request(Command.STATUS) == b""


def test_reports_a_failed_port():
    link, _, _ = connect()

    def fail(*_):
        raise OSError("device reports readiness to read but returned no data.")

    link._transport.read = fail
    sentence = "The board was lost: device reports readiness to read but returned no data."
    with pytest.raises(LinkError, match=f"^{re.escape(sentence)}$"):
        link.request(Command.STATUS)
    link._transport.write = fail
    link.session = 42
    with pytest.raises(LinkError, match=f"^{re.escape(sentence)}$"):
        link.request(Command.STATUS)
    assert issubclass(LinkError, JobError)


def test_a_session_after_an_interrupt_loses_nothing():
    link, chip, _ = connect()
    read = link._transport.read

    def interrupt(size):
        raise KeyboardInterrupt

    link._transport.read = interrupt
    with pytest.raises(KeyboardInterrupt):
        link.request(Command.GENERATE, b"order")
    link._transport.read = read
    assert link.session is None
    link.reopen()
    assert link.request(Command.COUNTERS, b"?") == b"?"
    assert chip.executed == [(Command.GENERATE, b"order"), (Command.COUNTERS, b"?")]


@pytest.mark.parametrize("seed", range(4))
def test_exactly_once_over_a_line_with_byte_faults(seed):
    # Each of the five faults at 1e-3 per byte, in both directions.
    rng = random.Random(seed)
    faults = [ByteFaults(1e-3, rng), ByteFaults(1e-3, rng)]
    link, chip, _ = connect(*faults)
    asked = []
    for number in range(400):
        payload = number.to_bytes(2, "little") * rng.randrange(1, 25)
        asked.append((Command.START, payload))
        assert link.request(*asked[-1]) == payload
    assert chip.executed == asked
    assert all(fault.count > 20 for fault in faults)
    assert link.traffic.frames_repeated > 20


@pytest.mark.parametrize("seed", range(4))
def test_exactly_once_over_a_line_with_frame_faults(seed):
    rng = random.Random(seed)
    faults = [FrameFaults(0.05, rng), FrameFaults(0.05, rng)]
    link, chip, _ = connect(*faults)
    asked = [(Command.START, number.to_bytes(2, "little")) for number in range(500)]
    assert [link.request(*command) for command in asked] == [payload for _, payload in asked]
    assert chip.executed == asked
    assert all(fault.count > 50 for fault in faults)


@pytest.mark.parametrize(("faults", "rate"), [(ByteFaults, 1e-3), (FrameFaults, 0.04)])
def test_transfers_over_a_bad_line(faults, rate):
    rng = random.Random(3)
    link, chip, _ = connect(faults(rate, rng), faults(rate, rng))
    for _ in range(6):
        chip.executed.clear()
        commands = [(Command.READ, bytes([n % 100, n // 100])) for n in range(300)]
        assert link.transfer(commands) == [bytes(payload[0]) for _, payload in commands]
        # Each command is executed once and in order, then the commands whose replies were lost.
        assert chip.executed[:300] == commands
        assert set(chip.executed[300:]) < set(commands)


def test_generations_over_a_bad_line_match_the_core():
    """60 generations of a chip over a line with 5e-3 faults per byte, each executed once."""
    rng = random.Random(5)
    config = Config()
    chip, twin = Chip(config), Chip(config)
    clock = VirtualClock()
    faults = [ByteFaults(1e-3, rng), ByteFaults(1e-3, rng)]
    port = FaultyTransport(chip.feed, clock, to_board=faults[0], from_board=faults[1])
    link = Link(port, timeout_s=0.25, clock=clock)
    info = info_reply(config).unpack(link.info())
    link.open(info["session"], credit=info["receive_buffer"])

    seed = bytes(range(8)) + b"\xff\1\xff\1\x80\x0c\0"
    assert link.request(Command.START, seed) == b""
    twin.core.start(int.from_bytes(seed[:8], "little"), Limits(511, 511, 0xC80))
    for _ in range(60):
        order = rng.sample(range(config.population), config.population)
        rank = bytes((LinkMode.RANK, *order))
        recipe = bytes((LinkMode.RECIPE, *order))
        assert link.request(Command.GENERATE, rank, shorter=recipe)
        twin.core.run(order)
    assert chip.core.paths == twin.core.paths
    assert chip.core.generation == 60
    assert all(fault.count > 20 for fault in faults)


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


@pytest.fixture
def one_by_one(monkeypatch):
    """Frames arrive one by one."""
    first = property(lambda port: port._received.find(b"\0") + 1)
    monkeypatch.setattr(FaultyTransport, "in_waiting", first)


@pytest.mark.usefixtures("one_by_one")
def test_a_second_refusal_of_a_command_does_not_meet_the_next():
    """The line brings the refused command twice, and the host does not wait for a silence."""
    link, chip, clock = connect(Script({FIRST: twice}))
    with pytest.raises(RefusedError):
        link.request(Command.WRITE, b"!")
    assert link.request(Command.WRITE, b"next") == b"next"
    assert chip.executed == [USES_UP_THE_NUMBER, (Command.WRITE, b"next")]
    assert clock() < 0.001


@pytest.mark.usefixtures("one_by_one")
def test_late_refusals_of_a_command_do_not_meet_the_next():
    """The next command has the number of a refused one."""
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
    assert chip.executed == [USES_UP_THE_NUMBER, (Command.WRITE, b"next")]


@pytest.mark.parametrize("frames_between", range(4))
def test_a_second_refusal_that_is_still_under_way_does_not_meet_the_next(frames_between):
    """The Verilog answers later than the model, so nothing has arrived when the host sends more."""
    late = []

    def first(frame):
        late.append(frame)
        return frame

    def after(frame):
        return late[0] + frame

    line = Script({FIRST: first, FIRST + 1 + frames_between: after})
    link, chip, clock = connect(from_board=line)
    with pytest.raises(RefusedError):
        link.request(Command.WRITE, b"!")
    for number in range(5):
        assert link.request(Command.WRITE, bytes([number])) == bytes([number])
    assert chip.executed == [USES_UP_THE_NUMBER, *((Command.WRITE, bytes([n])) for n in range(5))]
    assert clock() < 0.001


def test_a_late_repetition_of_a_refused_command_is_not_taken_for_the_next():
    """The chip was busy the first time, and executes the repetition."""
    link, chip, _ = connect(Script({FIRST: twice}))
    execute = chip._execute

    def busy_once(session, sequence, code, payload):
        if code == Command.BEST and Command.BEST not in asked:
            asked.append(code)
            return Status.BUSY, b""
        return execute(session, sequence, code, payload)

    asked = []
    chip._execute = busy_once
    with pytest.raises(RefusedError):
        link.request(Command.BEST, b"best")
    assert link.request(Command.WRITE, b"next") == b"next"
    assert chip.executed == [(Command.BEST, b"best"), (Command.WRITE, b"next")]


def test_a_lost_status_after_a_refusal_is_repeated():
    link, chip, clock = connect(Script({FIRST + 1: lose}))
    with pytest.raises(RefusedError):
        link.request(Command.WRITE, b"!")
    assert link.request(Command.WRITE, b"next") == b"next"
    assert chip.executed == [USES_UP_THE_NUMBER, (Command.WRITE, b"next")]
    assert 0.25 <= clock() < 0.26


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
