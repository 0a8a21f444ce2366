"""The host's end of the line, against an honest chip behind lines that are not."""

import random
import re

import pytest

from hdl.config import Config
from hdl.framing import encode_frame
from hdl.protocol import CRC_BYTES, Command, LinkMode, Status, info_reply
from host.errors import JobError
from host.link import Link, LinkError, LinkTimeoutError, RefusedError
from sim.model.chip import ChipModel
from sim.model.core import Limits
from sim.model.frames import FrameReceiverModel
from tests.faults import ByteFaults, FaultyTransport, FrameFaults, VirtualClock


CONFIG = Config(receive_buffer=256)


class Recorder:
    """A chip by the rules of :mod:`hdl.protocol` that executes anything and remembers it.

    The answer to a command is its payload; to the payload ``!``, ``BAD_VALUE``; to READ, as many
    bytes as its payload says.
    """

    def __init__(self):
        self.executed = []
        self.statuses = []
        self.session = 41
        self._expected = 0
        self._receiver = FrameReceiverModel(CONFIG)

    def __call__(self, data):
        return b"".join(
            encode_frame(self._answer(body, plain), plain=plain)
            for body, plain in self._receiver.feed(data)
        )

    def _answer(self, body, plain):
        session, sequence, code = body[:3]
        payload = body[3:]
        if plain:
            return bytes((session, sequence, Status.OK, self.session))
        status, reply = self._execute(session, sequence, code, payload)
        self.statuses.append(status)
        if status == Status.OUT_OF_ORDER:
            sequence = self._expected
        return bytes((session, sequence, status)) + reply

    def _execute(self, session, sequence, code, payload):
        if code == Command.OPEN:
            if session == (self.session + 1) % 256:
                self.session, self._expected = session, 0
            return (Status.OK if session == self.session else Status.NO_SESSION), b""
        if session != self.session:
            return Status.NO_SESSION, b""
        ahead = (sequence - self._expected) % 256
        if ahead in (0, 255):
            if payload == b"!":
                return Status.BAD_VALUE, b""
            if ahead == 0:
                self.executed.append((code, payload))
                self._expected = (self._expected + 1) % 256
            return Status.OK, bytes(payload[0]) if code == Command.READ else payload
        return (Status.OUT_OF_ORDER if ahead < 129 else Status.DUPLICATE), b""


class Script:
    """Lets frames by number to the board or from it be lost or changed."""

    def __init__(self, changes):
        self.changes = changes
        self.count = 0
        self._begun = b""

    def __call__(self, data):
        *frames, self._begun = (self._begun + data).split(b"\0")
        arrived = b""
        for frame in frames:
            change = bytes
            if frame:
                change = self.changes.get(self.count, bytes)
                self.count += 1
            arrived += change(frame + b"\0")
        return arrived


def lose(frame):
    return b""


def twice(frame):
    return frame * 2


def without_delimiter(frame):
    return frame[:-1]


def connect(to_board=bytes, from_board=bytes, *, chip=None, attempts=20):
    """A link with an open session, its chip, and its clock."""
    chip = Recorder() if chip is None else chip
    clock = VirtualClock()
    port = FaultyTransport(chip, clock, to_board=to_board, from_board=from_board)
    link = Link(port, timeout_s=0.25, attempts=attempts, clock=clock)
    link.open(link.info()[0], credit=CONFIG.receive_buffer)
    return link, chip, clock


# Frames 0 and 1 are INFO and OPEN.
FIRST = 2


def test_opens_the_session_after_the_chips_last():
    link, chip, clock = connect()
    assert link.session == chip.session == 42
    assert clock() < 0.001
    assert link.traffic.frames_to_board == link.traffic.frames_from_board == 2
    assert link.traffic.frames_repeated == 0


def test_sessions_wrap():
    chip = Recorder()
    chip.session = 255
    link, _, _ = connect(chip=chip)
    assert link.session == 0


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


def test_transfer_fills_the_window_and_no_more():
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


def test_transfer_without_faults():
    link, chip, _ = connect()
    commands = [(Command.WRITE, bytes([n % 256]) * (1 + n % 60)) for n in range(700)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert chip.executed == commands
    assert link.traffic.frames_repeated == 0
    assert link.transfer([]) == []
    assert link.request(Command.STATUS) == b""


def test_transfer_goes_back_without_waiting_for_a_timeout():
    link, chip, clock = connect(Script({FIRST + 1: lose}))
    commands = [(Command.WRITE, bytes([n]) * 20) for n in range(30)]
    assert link.transfer(commands) == [payload for _, payload in commands]
    assert chip.executed == commands
    assert clock() < 0.25
    # One gap, one repetition of what followed it.
    assert link.traffic.frames_repeated <= CONFIG.receive_buffer // 27
    assert chip.statuses.count(Status.OUT_OF_ORDER) <= CONFIG.receive_buffer // 27


def test_transfer_asks_again_where_an_answer_was_lost():
    link, chip, _ = connect(from_board=Script({FIRST + 1: lose, FIRST + 3: lose}))
    commands = [(Command.READ, bytes([n])) for n in range(1, 20)]
    assert link.transfer(commands) == [bytes(n) for n in range(1, 20)]
    assert chip.executed == [*commands, commands[1], commands[3]]


def test_transfer_repeats_the_last_for_its_answer():
    link, chip, clock = connect(from_board=Script({FIRST + 2: lose}))
    commands = [(Command.READ, bytes([n])) for n in range(1, 4)]
    assert link.transfer(commands) == [bytes(n) for n in range(1, 4)]
    assert chip.executed == commands
    assert 0.25 <= clock() < 0.26


def test_a_long_answer_is_replaced_by_a_shorter_one():
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
    assert chip.executed == [(Command.WRITE, b"fine")]


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


def test_a_dead_board_is_given_up():
    link, _, clock = connect(Script(dict.fromkeys(range(FIRST, 99), lose)), attempts=3)
    sentence = (
        "The board did not answer GENERATE in 3 attempts of 0.25 s: "
        "check its power, the cable and the line rate."
    )
    with pytest.raises(LinkTimeoutError, match=f"^{re.escape(sentence)}$"):
        link.request(Command.GENERATE)
    assert 0.75 <= clock() < 0.76
    assert link.session is None


def test_no_board_at_all():
    clock = VirtualClock()
    link = Link(FaultyTransport(lambda data: b"", clock), timeout_s=0.5, attempts=4, clock=clock)
    with pytest.raises(LinkTimeoutError, match=r"^The board did not answer INFO in 4 attempts"):
        link.info()
    assert clock() == 2.0


def test_the_time_of_writing_is_no_wait():
    """A slow port that takes longer to write than a try lasts: nothing is sent twice for it."""
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
def test_an_echo_is_no_answer(command):
    clock = VirtualClock()
    link = Link(FaultyTransport(bytes, clock), timeout_s=0.25, attempts=3, clock=clock)
    asked = link.info if command == "info" else lambda: link.open(41, credit=256)
    with pytest.raises(LinkTimeoutError, match=rf"did not answer {command.upper()} in 3 attempts"):
        asked()
    assert 0.75 <= clock() < 0.76


def test_a_board_that_answers_after_an_echo():
    chip = Recorder()
    clock = VirtualClock()
    link = Link(FaultyTransport(lambda data: data + chip(data), clock), clock=clock)
    link.open(link.info()[0], credit=256)
    assert (link.session, chip.session) == (42, 42)


def test_a_babbling_board_is_given_up():
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


def test_a_reset_board_is_told():
    link, chip, _ = connect()
    chip.session = 7
    sentence = r"^The board was reset or taken by another host: open it again\.$"
    with pytest.raises(LinkError, match=sentence):
        link.request(Command.STATUS)
    with pytest.raises(LinkError, match=sentence):
        link.reopen()
    link.open(link.info()[0], credit=256)
    assert link.request(Command.STATUS) == b""


def test_a_port_that_fails_is_told():
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


def test_an_interrupt_ends_the_session_and_the_next_loses_nothing():
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
        # In order and once each; what is given again for its lost answer follows.
        assert chip.executed[:300] == commands
        assert set(chip.executed[300:]) < set(commands)


def test_generations_over_a_bad_line_are_those_of_the_core():
    """The whole chip: 60 generations over a line with 5e-3 faults per byte, each executed once."""
    rng = random.Random(5)
    config = Config()
    chip, twin = ChipModel(config), ChipModel(config)
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
