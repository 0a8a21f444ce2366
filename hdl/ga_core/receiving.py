"""Receiving unit: takes one request and hands it to the core."""

from amaranth import *
from amaranth.lib import data, enum, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.ga_core.layouts import ranking_layout, start_layout, write_layout
from hdl.protocol import Command, LinkMode, Status, StickyError, read_request, start_request


__all__ = ["AnswerKind", "ReceivingUnit", "answer_layout", "request_layout"]

#: One byte of a request's or an answer's body.
request_layout = data.StructLayout({"data": 8, "last": 1, "plain": 1})


class AnswerKind(enum.Enum, shape=3):
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


class ReceivingUnit(wiring.Component):
    """Takes requests apart, by the rules of :mod:`hdl.protocol`.

    Turned on with a request waiting, it takes one byte a clock, decides within 2 clocks of the last
    (a GENERATE waits for the core's mutators, some clocks more), and is over. Whatever the request
    holds, all of it is taken and the unit ends.

    A refused WRITE may have changed the slots it names; their lengths stay within the limits.

    Source: *allaire-2008*, section 4.3. Differs: the sequence numbers, and the order of the slots
    in place of the population itself.

    Parameters
    ----------
    config : Config

    Members
    -------
    on, over : In(1), Out(1)
        Hand-over with the control unit. ``over`` lasts while it waits to be turned off.
    pending : Out(1)
        A request waits.
    generate : Out(1)
        With ``over``: a generation is to run before the answer.
    requests : In(stream of request_layout)
        Bodies of undamaged frames, without CRC.
    starts : Out(stream of seed, x, y, altitude)
        Seed of the random source, limits of new waypoints.
    writes : Out(stream of slot, index, waypoint, last)
        Waypoints for the present population.
    ranking : Out(stream of rank, slot)
        The slots from the best path to the worst.
    ranked : In(1)
        The core has worked the ranking in.
    answer : Out(answer_layout)
        How to answer; steady from ``over`` to the next ``on``.
    session : Out(8)
        The open session.
    line_errors : In(4)
        Pulses from the line: FRAMING, OVERRUN, CRC, MALFORMED of :class:`hdl.protocol.StickyError`.
    errors : Out(8)
        All sticky errors.
    """

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Configuration must be a Config, not {config!r}")
        self.config = config

        self.start_layout = start_layout(config)
        self.write_layout = write_layout(config)
        self.ranking_layout = ranking_layout(config)
        super().__init__(
            {
                "on": In(1),
                "over": Out(1),
                "pending": Out(1),
                "generate": Out(1),
                "requests": In(stream.Signature(request_layout)),
                "starts": Out(stream.Signature(self.start_layout)),
                "writes": Out(stream.Signature(self.write_layout)),
                "ranking": Out(stream.Signature(self.ranking_layout)),
                "ranked": In(1),
                "answer": Out(answer_layout),
                "session": Out(8),
                "line_errors": In(4),
                "errors": Out(8),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        start, read = start_request(config), read_request(config)

        byte = self.requests.p.data
        take = Signal()
        ended = Signal()  # The last byte has been taken.
        code = Signal(8)
        expected = Signal(8)
        ahead = Signal(8)
        repeated = Signal()
        bad_value = Signal()
        m.d.comb += [
            self.pending.eq(self.requests.valid),
            ahead.eq(self.answer.sequence - expected),
            take.eq(self.requests.valid & self.requests.ready),
        ]
        with m.If(take):
            m.d.sync += ended.eq(self.requests.p.last)

        refused = Signal()
        cleared = Signal()
        m.d.sync += self.errors.eq(
            Mux(cleared, 0, self.errors)
            | self.line_errors
            | Mux(refused, StickyError.REFUSED.value, 0)
        )

        def refuse(status):
            return [self.answer.status.eq(status), self.answer.kind.eq(AnswerKind.EMPTY)]

        # Payloads of fixed size: the last byte taken is the highest of `fixed`.
        fixed = Signal(start.bits)
        count = Signal(range(start.size + 2))

        # Paths.
        slot = Signal(8)
        index = Signal(range(config.max_waypoints + 1))
        word = Signal(8 * config.waypoint_bytes)
        part = Signal(range(config.waypoint_bytes))
        any_path = Signal()
        is_last = word[config.waypoint_bits]

        # Order of the slots.
        rank = Signal(range(config.population + 1))
        seen = Signal(config.population)
        identity = Signal()
        m.d.comb += [
            self.starts.p.eq(fixed),
            self.writes.p.slot.eq(slot),
            self.writes.p.index.eq(index),
            self.writes.p.waypoint.eq(word),
            self.writes.p.last.eq(is_last),
            self.ranking.p.rank.eq(rank),
            self.ranking.p.slot.eq(Mux(identity, rank, byte)),
        ]

        with m.FSM():
            with m.State("Off"):
                m.d.sync += [
                    ended.eq(0),
                    repeated.eq(0),
                    bad_value.eq(0),
                    count.eq(0),
                    index.eq(0),
                    part.eq(0),
                    any_path.eq(0),
                    rank.eq(0),
                    seen.eq(0),
                    identity.eq(0),
                    self.generate.eq(0),
                ]
                with m.If(self.on):
                    m.next = "Session"

            with m.State("Session"):
                m.d.comb += self.requests.ready.eq(1)
                m.d.sync += [
                    self.answer.session.eq(byte),
                    self.answer.plain.eq(self.requests.p.plain),
                    self.answer.kind.eq(AnswerKind.EMPTY),
                    self.answer.status.eq(Status.OK),
                ]
                with m.If(take):
                    m.next = "Sequence"

            with m.State("Sequence"):
                m.d.comb += self.requests.ready.eq(1)
                m.d.sync += self.answer.sequence.eq(byte)
                with m.If(take):
                    m.next = "Code"

            with m.State("Code"):
                m.d.comb += self.requests.ready.eq(1)
                m.d.sync += code.eq(byte)
                with m.If(take):
                    m.next = "Decode"

            with m.State("Decode"):
                m.next = "Drain"
                with m.If(self.answer.plain):
                    m.d.sync += self.answer.kind.eq(
                        Mux(code == Command.INFO, AnswerKind.INFO, AnswerKind.SILENCE)
                    )
                with m.Elif(code == Command.OPEN):
                    with m.If(self.answer.session == (self.session + 1)[:8]):
                        m.d.sync += [self.session.eq(self.answer.session), expected.eq(0)]
                    with m.Elif(self.answer.session != self.session):
                        m.d.sync += refuse(Status.NO_SESSION)
                with m.Elif(self.answer.session != self.session):
                    m.d.sync += refuse(Status.NO_SESSION)
                with m.Elif((ahead != 0) & (ahead < 129)):
                    m.d.sync += refuse(Status.OUT_OF_ORDER)
                    m.d.sync += self.answer.sequence.eq(expected)
                with m.Elif((ahead != 0) & (ahead != 255)):
                    m.d.sync += refuse(Status.DUPLICATE)
                with m.Else():
                    m.d.sync += repeated.eq(ahead != 0)
                    with m.Switch(code):
                        with m.Case(
                            Command.STATUS,
                            Command.START,
                            Command.READ,
                            Command.COUNTERS,
                            Command.CLEAR,
                        ):
                            m.next = "Fixed"
                        with m.Case(Command.WRITE):
                            m.next = "Slot"
                        with m.Case(Command.GENERATE):
                            m.next = "Mode"
                        with m.Default():
                            m.d.sync += refuse(Status.UNKNOWN_COMMAND)
                            m.d.comb += refused.eq(1)

            with m.State("Drain"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(ended):
                    m.next = "Over"

            with m.State("Fixed"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(take):
                    m.d.sync += fixed.eq(Cat(fixed[8:], byte))
                    with m.If(count <= start.size):
                        m.d.sync += count.eq(count + 1)
                with m.If(ended):
                    m.next = "Check"

            with m.State("Check"):
                m.next = "Executed"
                with m.Switch(code):
                    with m.Case(Command.START):
                        limits = self.starts.p
                        with m.If(count != start.size):
                            m.d.sync += refuse(Status.BAD_LENGTH)
                            m.next = "Refused"
                        with m.Elif(
                            (limits.x >= config.map_size)
                            | (limits.y >= config.map_size)
                            | (limits.altitude >= config.blocked_altitude)
                        ):
                            m.d.sync += refuse(Status.BAD_VALUE)
                            m.next = "Refused"
                        with m.Elif(~repeated):
                            m.next = "Start"
                    with m.Case(Command.READ):
                        asked = data.View(data.StructLayout(dict(read.fields)), fixed[-read.bits :])
                        m.d.sync += [
                            self.answer.kind.eq(AnswerKind.PATHS),
                            self.answer.slot.eq(asked.slot),
                            self.answer.count.eq(asked.count),
                        ]
                        with m.If(count != read.size):
                            m.d.sync += refuse(Status.BAD_LENGTH)
                            m.next = "Refused"
                        with m.Elif(
                            (asked.count == 0) | (asked.slot + asked.count > config.population)
                        ):
                            m.d.sync += refuse(Status.BAD_VALUE)
                            m.next = "Refused"
                    with m.Default():
                        with m.If(count != 0):
                            m.d.sync += refuse(Status.BAD_LENGTH)
                            m.next = "Refused"
                        with m.Elif(code == Command.STATUS):
                            m.d.sync += self.answer.kind.eq(AnswerKind.STATUS)
                        with m.Elif(code == Command.COUNTERS):
                            m.d.sync += self.answer.kind.eq(AnswerKind.COUNTERS)
                        with m.Else():
                            m.d.comb += cleared.eq(~repeated)

            with m.State("Start"):
                m.d.comb += self.starts.valid.eq(1)
                with m.If(self.starts.ready):
                    m.next = "Executed"

            with m.State("Slot"):
                m.d.comb += self.requests.ready.eq(~ended)
                m.d.sync += slot.eq(byte)
                with m.If(ended):
                    m.d.sync += refuse(Status.BAD_LENGTH)
                    m.next = "Refused"
                with m.Elif(take):
                    m.next = "Waypoint"

            with m.State("Waypoint"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(take):
                    m.d.sync += [word.eq(Cat(word[8:], byte)), part.eq(part + 1)]
                    with m.If(part == config.waypoint_bytes - 1):
                        m.d.sync += [part.eq(0), any_path.eq(1)]
                        m.next = "Store"
                with m.Elif(ended):
                    m.next = "Executed"
                    with m.If((part != 0) | ~any_path):
                        m.d.sync += refuse(Status.BAD_LENGTH)
                        m.next = "Refused"
                    with m.Elif(bad_value | (index != 0)):
                        m.d.sync += refuse(Status.BAD_VALUE)
                        m.next = "Refused"

            with m.State("Store"):
                wrong = (
                    (slot >= config.population)
                    | (index >= config.max_waypoints)
                    | (is_last & (index < config.MIN_WAYPOINTS - 1))
                )
                m.d.comb += self.writes.valid.eq(~wrong & ~bad_value & ~repeated)
                with m.If(wrong | bad_value | repeated | self.writes.ready):
                    m.d.sync += bad_value.eq(bad_value | wrong)
                    m.d.sync += index.eq(index + ~wrong)
                    with m.If(is_last):
                        m.d.sync += [index.eq(0), slot.eq(slot + 1)]
                    m.next = "Waypoint"

            with m.State("Mode"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(ended):
                    m.d.sync += refuse(Status.BAD_LENGTH)
                    m.next = "Refused"
                with m.Elif(take):
                    m.next = "Order"
                    with m.Switch(byte):
                        with m.Case(LinkMode.POPULATION):
                            m.d.sync += [
                                identity.eq(1),
                                self.answer.kind.eq(AnswerKind.PATHS),
                                self.answer.slot.eq(0),
                                self.answer.count.eq(config.population),
                            ]
                            m.next = "Identity"
                        with m.Case(LinkMode.RANK):
                            m.d.sync += [
                                self.answer.kind.eq(AnswerKind.CHILDREN),
                                self.answer.slot.eq(config.elites + config.survivors),
                                self.answer.count.eq(config.children),
                            ]
                        with m.Case(LinkMode.RECIPE):
                            m.d.sync += self.answer.kind.eq(AnswerKind.RECIPE)
                        with m.Default():
                            m.d.sync += refuse(Status.BAD_VALUE)
                            m.d.comb += refused.eq(1)
                            m.next = "Drain"

            with m.State("Order"):
                fits = Signal()
                m.d.comb += [
                    fits.eq(
                        (byte < config.population) & ~seen.bit_select(byte[: config.slot_bits], 1)
                    ),
                    self.ranking.valid.eq(
                        self.requests.valid & ~ended & ~repeated & (rank != config.population)
                    ),
                    self.requests.ready.eq(~ended & (self.ranking.ready | ~self.ranking.valid)),
                ]
                with m.If(take):
                    m.d.sync += [
                        bad_value.eq(bad_value | ~fits),
                        seen.bit_select(byte[: config.slot_bits], 1).eq(1),
                        rank.eq(rank + 1),
                    ]
                    with m.If(rank == config.population):  # One byte too many.
                        m.d.sync += [refuse(Status.BAD_LENGTH), rank.eq(rank)]
                        m.d.comb += refused.eq(1)
                        m.next = "Drain"
                with m.If(ended):
                    m.next = "Ranked"
                    with m.If(rank != config.population):
                        m.d.sync += refuse(Status.BAD_LENGTH)
                        m.next = "Refused"
                    with m.Elif(repeated):
                        m.next = "Executed"
                    with m.Elif(bad_value):
                        m.d.sync += refuse(Status.BAD_VALUE)
                        m.next = "Refused"

            with m.State("Identity"):
                m.d.comb += self.ranking.valid.eq(ended & ~repeated)
                with m.If(~ended):
                    m.d.sync += refuse(Status.BAD_LENGTH)
                    m.d.comb += refused.eq(1)
                    m.next = "Drain"
                with m.Elif(repeated):
                    m.next = "Executed"
                with m.Elif(self.ranking.ready):
                    m.d.sync += rank.eq(rank + 1)
                    with m.If(rank == config.population - 1):
                        m.next = "Ranked"

            with m.State("Ranked"):
                with m.If(self.ranked):
                    m.d.sync += self.generate.eq(1)
                    m.next = "Executed"

            with m.State("Refused"):
                m.d.comb += refused.eq(1)
                m.next = "Over"

            with m.State("Executed"):
                with m.If(~repeated):
                    m.d.sync += expected.eq(expected + 1)
                m.next = "Over"

            with m.State("Over"):
                m.d.comb += self.over.eq(1)
                with m.If(~self.on):
                    m.next = "Off"

        return m
