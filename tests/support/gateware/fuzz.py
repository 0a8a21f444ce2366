"""Random valid and broken frames for a chip, and the model's replies to them.

The draws avoid the cases in which chip and model may differ: a refused WRITE may change waypoints,
so all paths are rewritten after one; a command whose reply depends on bytes received while earlier
commands ran is sent alone; and a run is over before the next command.
"""

import random

import numpy as np

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.hdl.protocol.messages import counters_reply, status_reply
from pathgene.host.device.chip_map import map_frames
from pathgene.sim.board.scheme import start_simulated
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.chips import LINE_CYCLES
from tests.support.gateware.faults import ByteFaults
from tests.support.gateware.random_requests import RandomRequests
from tools.chips import board_url


#: Commands whose replies depend on the bytes received before they run.
_ALONE = (Command.STATUS, Command.COUNTERS, Command.CLEAR, Command.RUN)
#: Maximum number of polls until a run is over.
_LOOKS = 10_000


class Fuzz:
    """Source of random requests to a chip and of the replies it must give.

    Attributes
    ----------
    frames : int
        Number of frames drawn, including broken ones.
    statuses : dict of Status to int
        Number of replies with each status.
    dropped : set of StickyError
        Reasons for which frames were dropped.
    """

    def __init__(self, config, seed):
        self.config = config
        self.frames = 0
        self.statuses = dict.fromkeys(Status, 0)
        self.dropped = set()
        self._model = Chip(config)
        self._receiver = FrameReceiverModel(config)
        self._rng = random.Random(seed)
        self._faults = ByteFaults(0.01, self._rng)
        self._requests = RandomRequests(config, self._rng, np.random.default_rng(seed))
        self._map = []  # MAP payloads to send first.
        if config.checker is not CheckerBuild.NONE:
            edge, top = config.map_size, config.blocked_altitude
            heights = np.random.default_rng(seed).integers(0, top // 2, (edge, edge))
            self._map = [payload for payload, _ in map_frames(config, heights, 0, 0)]
        self._session = self._expected = 0
        self._rewrite = False
        self._runs = False  # A run may have begun whose end has not been awaited yet.
        self._held = None
        self._unended = 0

    def exchange(self, port):
        """Send a batch to ``port``, the serial port of a chip, and compare the replies."""
        batch, expected, counters = self.batch()
        port.write(batch)
        answers = port.read(len(expected))
        if counters:
            answers, expected = map(self._without_line_cycles, (answers, expected))
        assert answers == expected, (
            f"in frame {self.frames}: to {batch.hex(' ')} the answer {answers.hex(' ')}, "
            f"not {expected.hex(' ')}"
        )
        if self._runs:
            self._await_end(port)

    def _await_end(self, port):
        """Ask for the status until the run is over, then compare it."""
        self._runs, self._unended = False, 0
        layout = status_reply(self.config)
        # It ends the rest of a broken frame, or a whole one that lacked it, which has an answer.
        port.write(b"\0")
        expected = self._answers(b"\0")
        answer = port.read(len(expected))
        assert answer == expected, (answer.hex(" "), expected.hex(" "))
        for _ in range(_LOOKS):
            frame = encode_frame(self._body(Command.STATUS, b""))
            port.write(frame)
            expected = self._answers(frame)
            answer = port.read(len(expected))
            ((body, _),) = _bodies(answer)
            # A frame that was lost has left the number of the next command uncertain.
            is_told = body[2] == Status.OK
            if not (is_told and layout.unpack(body[BODY_HEADER_BYTES:])["running"]):
                assert answer == expected, (answer.hex(" "), expected.hex(" "))
                if is_told:
                    return
        raise TimeoutError(f"Run must end within {_LOOKS} looks")

    def batch(self):
        """Return bytes that fit into the receive buffer, the model's replies, and a flag.

        The flag is true if the bytes request the counters.
        """
        batch, answers = b"", b""
        while True:
            data, alone = piece = self._held or self._draw()
            self._held = None
            if batch and (alone or self._unended + len(batch + data) > self.config.receive_buffer):
                self._held = piece
                alone = None
                break
            batch += data
            answers += self._answers(data)
            if alone or self._rewrite or self._rng.random() < 0.2:
                break
        *ended, begun = batch.split(b"\0")
        self._unended = len(begun) + (0 if ended else self._unended)
        return batch, answers, alone == Command.COUNTERS

    def _without_line_cycles(self, answers):
        """Return ``answers`` without the cycle counts that depend on the line."""
        layout = counters_reply(self.config)
        told = b""
        for body, plain in _bodies(answers):
            header, reply = body[:BODY_HEADER_BYTES], body[BODY_HEADER_BYTES:]
            if len(reply) == layout.size:
                reply = layout.pack(**layout.unpack(reply) | dict.fromkeys(LINE_CYCLES, 0))
            told += encode_frame(header + reply, plain=plain)
        return told

    def _answers(self, data):
        """Feed the model, and track session and sequence numbers from its replies."""
        running = self._model.running
        before = running and running.latest
        answers = self._model.feed(data)
        self._runs |= running is not None and running.latest is not before
        self._receiver.feed(data)
        self.dropped.update(self._receiver.verdicts)
        for (session, sequence, status, *_), plain in _bodies(answers):
            self.statuses[Status(status)] += 1
            if plain:
                continue
            if status == Status.OK and session != self._session:
                self._session, self._expected = session, 0
            elif status == Status.OK and sequence == self._expected:
                self._expected = (sequence + 1) % 256
            elif status == Status.OUT_OF_ORDER:
                self._expected = sequence
            elif status in (Status.BAD_LENGTH, Status.BAD_VALUE):
                self._rewrite = self.config.paper_core
        return answers

    def _draw(self):
        """Return a few bytes, usually a frame, and its command if it must be sent alone."""
        rng = self._rng
        self.frames += 1
        if self._map:
            return encode_frame(self._body(Command.MAP, self._map.pop())), None
        if self._rewrite:
            self._rewrite = False
            body = self._body(Command.WRITE, self._requests.paths(0, self.config.population))
            # The delimiter ends the rest of a broken frame, or a whole one that lacked it.
            return b"\0" + encode_frame(body), None
        if rng.random() < 0.05:
            return bytes(rng.choices((0, 1, 2, *range(256)), k=rng.randrange(1, 12))), None

        code = self._requests.command()
        body = self._body(code, self._requests.payload(code))
        if rng.random() < 0.25:
            body = self._broken(body)
        data = encode_frame(body, plain=(code == Command.INFO) != (rng.random() < 0.03))
        alone = body[2] if body[2] in _ALONE else None
        if not alone and rng.random() < 0.1:
            data = self._faults(data)
        elif not alone and rng.random() < 0.05:
            data *= 2
        return data, alone

    def _body(self, code, payload):
        session, sequence = self._session, self._expected
        if code == Command.OPEN:
            session = (session + 1) % 256
        return bytes((session, sequence, code)) + payload

    def _broken(self, body):
        """Return ``body`` with one part changed, not always to an invalid value."""
        rng = self._rng
        session, sequence, code = body[:BODY_HEADER_BYTES]
        payload = body[BODY_HEADER_BYTES:]
        # A RUN with any other byte might last too long.
        match rng.randrange(6 if code == Command.RUN else 7):
            case 0:
                session = rng.choice((session - 1, session + 1, rng.randrange(256))) % 256
            case 1:
                sequence = (sequence + rng.choice((-127, -128, -2, 1, 128, 129))) % 256
            case 2 | 3:  # As if the reply had been lost.
                sequence = (sequence - 1) % 256
            case 4:
                known = len(Command) + 2 if self.config.planner_core else 16
                code = rng.choice((0, rng.randrange(known), rng.randrange(256)))
            case 5:
                length = rng.choice((0, len(payload) - 1, len(payload) + 1, rng.randrange(300)))
                payload = (payload + rng.randbytes(300))[: max(0, length)]
            case 6:
                changed = bytearray(payload or b"\0")
                at = rng.randrange(len(changed))
                changed[at] = rng.choice((changed[at] ^ 1 << rng.randrange(8), rng.randrange(256)))
                payload = bytes(changed)
        return bytes((session, sequence, code)) + payload


def fuzz_simulated_board(config, seed, frames):
    """Exchange random frames with a simulated board; return the :class:`Fuzz`."""
    fuzz = Fuzz(config, seed)
    with start_simulated(board_url("sim", config)) as board, board.open(timeout=30) as port:
        while fuzz.frames < frames:
            fuzz.exchange(port)
        port.timeout = 0.1
        assert port.read() == b""
    return fuzz


def _bodies(answers):
    return [decode_frame(encoded) for encoded in FrameSplitter().feed(answers)]
