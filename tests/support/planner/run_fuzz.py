"""Random frames to the planner's board during a run, which no model can follow in real time.

The model takes the same frames after a short run. By the rules of docs/protocol.md the board
refuses some with ``BUSY`` that the model executes; the model is then restored to its state before
them. A failure names the command that repeats it:
``python -m tests.support.planner.run_fuzz SEED FRAMES``.
"""

import collections
import copy
import sys

import numpy as np

from pathgene.hdl.command.field_decoder import request_fields
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, DELIMITER, encode_frame
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.hdl.protocol.messages import status_reply
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.sim.board.scheme import start_simulated
from tests.support.gateware.command_fuzz import CHIPS, CommandFuzz, answer_in, plan_on_the_map
from tests.support.planner.cases import record
from tools.chips import board_url


#: Commands that wait for the end of a run.
_WAITING = (
    Command.MAP,
    Command.PROBLEM,
    Command.RUN,
    Command.BEST,
    Command.BLOCK,
    Command.GUIDE,
    Command.CODED_MAP,
)
#: Commands whose answers depend on the time.
_TIMED = (Command.STATUS, Command.COUNTERS)
#: Number of frames sent to a run before it is stopped, if none of them stops it.
_EPISODE = 60
#: Maximum number of polls until a stopped run is over.
_LOOKS = 10_000
#: No chip reaches these numbers in a test.
_ENDLESS = RunOptions(seed=7, seeds=8, give_up_rank=3, cycles=(1 << 32) - 1)
_SHORT = RunOptions(seed=7, seeds=8, give_up_rank=3, cycles=0, generations=0)


class RunFuzz:
    """The planner's board, its model, and random frames for both.

    Parameters
    ----------
    port : serial port
        A board after its reset.

    Attributes
    ----------
    counts : collections.Counter
        Frames by kind and status; None if unanswered.
    """

    def __init__(self, seed, port):
        self.one = CommandFuzz("planner", seed, port)
        self.config = self.one.config
        self.counts = collections.Counter()
        self._port = port
        self._fields = request_fields(self.config)
        problem = record(self.config, np.random.default_rng(seed))
        self.one.command(Command.PROBLEM, problem.pack(self.config))

    def episode(self, frames):
        """Begin a run, send at most this many frames, end it; assert that they changed nothing."""
        one = self.one
        header = bytes((one.rules.session, one.rules.expected, Command.RUN))
        one.model.feed(encode_frame(header + _SHORT.pack(self.config)))
        one.model.running.settle()
        self._tell(header + _ENDLESS.pack(self.config), False, header[:2] + bytes([Status.OK]))
        for _ in range(frames):
            kind, body, plain = one.mix.draw()
            expected = one.rules.expected
            status = self._exchange(body, plain)
            self.counts[kind, status] += 1
            if body[2] == Command.STOP and one.rules.expected != expected:
                break
        else:
            self._exchange(bytes((one.rules.session, one.rules.expected, Command.STOP)), False)
        for _ in range(_LOOKS):
            if not self._running():
                break
        else:
            raise TimeoutError(f"Stopped run must end within {_LOOKS} looks")
        one.command(Command.CLEAR)
        for code, payload in plan_on_the_map(self.config):
            one.command(code, payload)

    def _exchange(self, body, plain):
        """Send a frame to the board during a run and to a copy of the model; return the status."""
        copied = copy.deepcopy(self.one.model)
        answer = answer_in(copied.feed(encode_frame(body, plain=plain)), plain)
        if self._must_wait(body, plain, answer):
            answer = body[: BODY_HEADER_BYTES - 1] + bytes([Status.BUSY])
        else:
            self.one.model = copied
        return self._tell(body, plain, answer)

    def _must_wait(self, body, plain, answer):
        """Return whether a run makes the command wait, given the model's ``answer``."""
        if plain or answer is None or body[2] not in _WAITING:
            return False
        repeated = body[1] == (self.one.rules.expected - 1) % 256
        status = answer[BODY_HEADER_BYTES - 1]
        if body[2] == Command.RUN and repeated:
            return False
        if body[2] in (Command.MAP, Command.CODED_MAP) and status == Status.BAD_LENGTH:
            # The length of the cells is checked last.
            return len(body) - BODY_HEADER_BYTES >= self._fields[body[2]].size
        return status in (Status.OK, Status.BAD_VALUE)

    def _tell(self, body, plain, expected):
        """Send a frame to the board and compare its answer with the body ``expected``."""
        self._port.write(encode_frame(body, plain=plain))
        told = self._answer(plain) if expected is not None else None
        status = self.one.rules.judge(body, plain, told)
        if body[2] in _TIMED and status is Status.OK:
            assert len(told) == len(expected)
        else:
            assert told == expected, (body.hex(" "), told, expected)
        if body[2] == Command.STATUS and status is Status.OK:
            assert status_reply(self.config).unpack(told[BODY_HEADER_BYTES:])["running"] == 1
        return status

    def _running(self):
        """Ask both for the status; return whether the board's run continues."""
        body = bytes((self.one.rules.session, self.one.rules.expected, Command.STATUS))
        self.one.model.feed(encode_frame(body))
        self._port.write(encode_frame(body))
        told = self._answer(False)
        self.one.rules.judge(body, False, told)
        return status_reply(self.config).unpack(told[BODY_HEADER_BYTES:])["running"]

    def _answer(self, plain):
        frame = bytearray()
        while not frame.endswith(bytes([DELIMITER])):
            byte = self._port.read(1)
            assert byte, "the board is silent"
            frame += byte
        return answer_in(bytes(frame), plain)


def fuzz_during_runs(seed, frames):
    """Send random frames to runs on the planner's board; return the counts by kind and status."""
    with start_simulated(board_url("sim", CHIPS["planner"])) as simulated:
        with simulated.open(timeout=30) as port:
            fuzz = RunFuzz(seed, port)
            while (sent := fuzz.counts.total()) < frames:
                try:
                    fuzz.episode(min(_EPISODE, frames - sent))
                except Exception as error:
                    raise AssertionError(
                        f"frame {fuzz.counts.total() + 1} of seed {seed}; "
                        f"again by: python -m tests.support.planner.run_fuzz {seed} {frames}"
                    ) from error
            return fuzz.counts


if __name__ == "__main__":
    fuzz_during_runs(*map(int, sys.argv[1:]))
