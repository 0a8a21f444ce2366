"""The answers that a host receives, read from the line, and the numbers of its commands."""

from __future__ import annotations

from collections import deque

from pathgene.hdl.protocol.codec import Frame, FrameError, FrameSplitter, decode_frame
from pathgene.hdl.protocol.codes import Command, Status


#: Answers that are remembered: more than can be under way at once.
_REMEMBERED = 64


class Watch:
    """State of a link that gives up: its latest new answer, and its frames.

    Attributes
    ----------
    answered_s : float
        Time at which the host received the latest answer that it did not have before.
    answers : int
        Number of such answers.
    asked : int
        Number of frames that the host has sent since.
    commands : dict
        By the code of a command and the bits of its size, the numbers of the bytes, in the session,
        with which each such command and its answer begin, if the chip answers at once.
    firsts : list of int
        Number of the byte, in the session, with which each command number 0 after the first begins.
    """

    def __init__(self) -> None:
        self.answered_s = 0.0
        self.answers = self.asked = 0
        self.commands: dict[tuple[int, int], list[tuple[int, int]]] = {}
        self.firsts: list[int] = []
        self._answers: deque[bytes] = deque(maxlen=_REMEMBERED)
        self._received, self._sent = FrameSplitter(), FrameSplitter()
        self._wraps = False

    def receive(self, data: bytes, now_s: float) -> None:
        """Note bytes that the host receives."""
        for body, _ in _frames(self._received, data):
            if body[2] == Status.OK and body[:2] not in self._answers:
                self._answers.append(body[:2])
                self.answers += 1
                self.answered_s, self.asked = now_s, 0

    def send(self, data: bytes, at: int, answer_at: int) -> None:
        """Note a frame of the host; its first byte and the answer's have these numbers."""
        self.asked += 1
        for body, is_plain in _frames(self._sent, data):
            self.commands.setdefault((body[2], len(body).bit_length()), []).append((at, answer_at))
            if is_plain or body[2] == Command.OPEN:
                self._wraps = False
            elif body[1] == 0 and self._wraps:
                self.firsts.append(at)
                self._wraps = False
            elif body[1] == 255:
                self._wraps = True


def _frames(splitter: FrameSplitter, data: bytes) -> list[Frame]:
    frames = []
    for encoded in splitter.feed(data):
        try:
            frames.append(decode_frame(encoded))
        except FrameError:
            continue
    return frames
