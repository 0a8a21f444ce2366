"""What goes in and out of the units that take commands and give answers."""

from amaranth.lib import data, enum, stream
from amaranth.lib.wiring import In, Out


__all__ = [
    "AnswerKind",
    "answer_layout",
    "payload_members",
    "request_layout",
]

#: One byte of a request's or an answer's body.
request_layout = data.StructLayout({"data": 8, "last": 1, "plain": 1})


class AnswerKind(enum.Enum, shape=4):
    """Payload of an answer."""

    #: No answer at all.
    SILENCE = 0
    EMPTY = 1
    INFO = 2
    STATUS = 3
    COUNTERS = 4
    #: Paths of ``count`` slots from ``slot``.
    PATHS = 5
    #: The survivors' slots, then the children.
    CHILDREN = 6
    RECIPE = 7
    #: Totals of the latest check.
    TOTALS = 8
    #: The same, then the results of all its paths.
    CHECKED = 9
    #: Results of ``count`` of its paths from ``slot``.
    RESULTS = 10


#: What the transmitting unit needs to know to answer.
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
    """Members of every unit that takes what follows the fixed fields of a request.

    on : In(1)
        Its command is being taken, and the fixed fields are steady. While it is low, the unit is
        as after reset.
    repeated : In(1)
        The command has been executed already: nothing may change. Steady while ``on``.
    bytes : In(stream.Signature(8))
        The rest of the payload.
    ended : In(1)
        The last byte of the request has been taken; high from the first clock if nothing follows.
    done : Out(1)
        The unit has settled what it makes of the request. If bytes are left, ``status`` is an
        error.
    status : Out(8)
        :class:`hdl.protocol.Status` of the request; valid with ``done``.
    """
    return {
        "on": In(1),
        "repeated": In(1),
        "bytes": In(stream.Signature(8)),
        "ended": In(1),
        "done": Out(1),
        "status": Out(8),
    }
