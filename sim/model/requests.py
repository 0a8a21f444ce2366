"""Requests in the model: the chip's receiver of frames, as a function of bytes, and refusals.

:mod:`pathgene.hdl.link.frame` is tested against this model: for any bytes it yields the same bodies
and the same errors, as long as the chip takes bodies from its buffer as fast as they arrive.
"""

from __future__ import annotations

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import Frame, FrameError, FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Status, StickyError


__all__ = ["FrameReceiverModel", "RefusedError", "encode_frame", "expect"]


class RefusedError(Exception):
    """A refused command, which is answered with ``status`` and changes nothing."""

    def __init__(self, status: Status) -> None:
        self.status = status


def expect(holds: bool, status: Status) -> None:
    """Refuse the command with ``status`` unless ``holds``."""
    if not holds:
        raise RefusedError(status)


class FrameReceiverModel:
    """Receives frames as :class:`pathgene.hdl.link.frame.FrameReceiver` does.

    Parameters
    ----------
    config : Config
        Configuration whose ``receive_buffer`` limits the bodies.

    Attributes
    ----------
    errors : StickyError
        All kinds of errors since the start, or since the caller cleared them.
    verdicts : list of StickyError
        The errors one by one, in the order of the discarded frames.
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self.errors = StickyError(0)
        self.verdicts: list[StickyError] = []
        self._splitter = FrameSplitter()

    @property
    def line_busy(self) -> bool:
        """True if a frame has begun but not ended."""
        return self._splitter.inside

    @property
    def longest_body(self) -> int:
        """Bytes of the longest body that fits into the buffer: one row is needed for its header."""
        return self.config.receive_buffer - 1

    def feed(self, data: bytes) -> list[Frame]:
        """Take bytes from the line and return the frames that they complete."""
        frames = []
        for encoded in self._splitter.feed(data):
            try:
                frame = decode_frame(encoded)
            except FrameError as error:
                self._drop(error.kind)
                continue
            if len(frame[0]) > self.longest_body:
                self._drop(StickyError.OVERRUN)
            else:
                frames.append(frame)
        return frames

    def _drop(self, kind: StickyError) -> None:
        self.errors |= kind
        self.verdicts.append(kind)
