"""A link, a correct chip, and faulty lines between them."""

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.host.device.link import Link
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.faults import FaultyTransport, VirtualClock


CONFIG = Config(receive_buffer=256)


class Recorder:
    """A chip that follows :mod:`pathgene.hdl.protocol` and records every command it executes.

    It replies with the payload of the command, except to the payload ``!`` with ``BAD_VALUE``, and
    to READ with as many bytes as its payload requests.
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
    """A line that loses or changes numbered frames, in either direction."""

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
    """Return a link with an open session, its chip and its clock."""
    chip = Recorder() if chip is None else chip
    clock = VirtualClock()
    port = FaultyTransport(chip, clock, to_board=to_board, from_board=from_board)
    link = Link(port, timeout_s=0.25, attempts=attempts, clock=clock)
    link.open(link.info()[0], credit=CONFIG.receive_buffer)
    return link, chip, clock


# Frames 0 and 1 are INFO and OPEN.
FIRST = 2
#: Command after a refused one: late second refusals must not meet the command after it.
USES_UP_THE_NUMBER = (Command.STATUS, b"")
