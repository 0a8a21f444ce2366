"""Registers of the request that the command receiver has at hand."""

from amaranth import *


__all__ = ["Request"]


class Request:
    """Registers of the request at hand, which the states of the receiver share.

    Parameters
    ----------
    size : int
        Most bytes of fixed fields.
    """

    def __init__(self, size: int):
        self.taken = Signal()  # A byte is taken in this cycle.
        self.ended = Signal()  # The last byte has been taken.
        self.code = Signal(8)
        self.repeated = Signal()  # Executed before: it is answered only.
        self.collecting = Signal()  # Fixed fields are coming in,
        self.left = Signal(range(size + 1))  # and these many bytes of them are to come.
        self.verdict = Signal(8)  # Status that the parser gives.
        self.refused = Signal()
        self.cleared = Signal()
