"""Counts of the traffic on a link."""

from __future__ import annotations

from dataclasses import dataclass, fields


__all__ = ["Traffic"]


@dataclass
class Traffic:
    """Traffic of a link since it was made.

    Attributes
    ----------
    bytes_to_board, bytes_from_board : int
        Bytes, delimiters and damaged bytes included.
    frames_to_board, frames_from_board : int
        Frames sent, repeated frames included, and good frames received.
    frames_damaged : int
        Damaged frames received and discarded.
    frames_repeated : int
        Frames repeated because their answer was missing.
    exchanges : int
        Number of times that the host waited for answers, to one command or to several sent
        together.
    waiting_s : float
        Seconds spent waiting for bytes from the board.
    """

    bytes_to_board: int = 0
    bytes_from_board: int = 0
    frames_to_board: int = 0
    frames_from_board: int = 0
    frames_damaged: int = 0
    frames_repeated: int = 0
    exchanges: int = 0
    waiting_s: float = 0.0

    def since(self, before: Traffic) -> Traffic:
        """Return the traffic since an earlier state, of which ``before`` is a copy."""
        return Traffic(
            *(getattr(self, each.name) - getattr(before, each.name) for each in fields(self))
        )
