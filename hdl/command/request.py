"""Registers of the request that the command receiver processes."""

from amaranth import *


__all__ = ["Request"]


class Request:
    """Registers of the present request, which the states of the receiver share.

    Parameters
    ----------
    size : int
        Maximum bytes of fixed fields.
    """

    def __init__(self, size: int):
        self.taken = Signal()  # A byte is taken in this cycle.
        self.ended = Signal()  # The last byte has been taken.
        self.code = Signal(8)
        self.repeated = Signal()  # Executed before: the request is only answered.
        self.collecting = Signal()  # Fixed fields are coming in.
        self.left = Signal(range(size + 1))  # Bytes of the fixed fields still to come.
        self.verdict = Signal(8)  # Status that the parser gives.
        self.refused = Signal()
        self.cleared = Signal()
