"""Payloads and registers that the units of the command interface share."""

from amaranth import *
from amaranth.lib import data, enum, stream
from amaranth.lib.wiring import In, Out


__all__ = ["AnswerKind", "Request", "answer_layout", "payload_members"]


class AnswerKind(enum.Enum, shape=4):
    """Payload of an answer."""

    #: No answer at all.
    SILENCE = 0
    EMPTY = 1
    INFO = 2
    STATUS = 3
    COUNTERS = 4
    #: Paths in ``count`` slots from ``slot`` on.
    PATHS = 5
    #: The survivors' slots, then the children.
    CHILDREN = 6
    RECIPE = 7
    #: Totals of the latest check.
    TOTALS = 8
    #: The totals, then the results of all paths.
    CHECKED = 9
    #: Results of ``count`` paths from ``slot`` on.
    RESULTS = 10
    #: Paths of the latest run; shares its value because no chip has both.
    BEST = RESULTS


#: Answer that the transmitter is to send.
answer_layout = data.StructLayout(
    {
        "kind": AnswerKind,
        "session": 8,
        "sequence": 8,
        "status": 8,
        "plain": 1,
        "slot": 8,
        "count": 9,
    }
)


def payload_members() -> dict:
    """Return the members that every parser of a payload has.

    on : In(1)
        The command of the parser is being taken, and the fixed fields are steady. While ``on`` is
        low, the parser is in its reset state.
    repeated : In(1)
        The command has been executed before, so nothing may change. Steady while ``on``.
    bytes : In(stream.Signature(8))
        Payload after the fixed fields.
    ended : In(1)
        The last byte of the request has been taken; high from the first cycle if there is no
        payload.
    done : Out(1)
        The parser has checked the request. If bytes are left, ``status`` is an error.
    status : Out(8)
        :class:`pathgene.hdl.protocol.codes.Status` of the request; valid with ``done``.
    """
    return {
        "on": In(1),
        "repeated": In(1),
        "bytes": In(stream.Signature(8)),
        "ended": In(1),
        "done": Out(1),
        "status": Out(8),
    }


class Request:
    """Registers of the current request, which the states of the receiver share.

    Parameters
    ----------
    size : int
        Maximum bytes of fixed fields.
    """

    def __init__(self, size: int):
        self.taken = Signal()  # A byte is taken in this cycle.
        self.ended = Signal()  # The last byte has been taken.
        self.code = Signal(8)
        self.repeated = Signal()  # Executed before, so the request is only answered.
        self.collecting = Signal()  # Fixed fields are being received.
        self.left = Signal(range(size + 1))  # Remaining bytes of the fixed fields.
        self.verdict = Signal(8)  # Status that the parser gives.
        self.refused = Signal()
        self.cleared = Signal()
