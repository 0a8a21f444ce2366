"""Reply transmitter: sends one answer at a time."""

from amaranth import *
from amaranth.lib import data, enum, stream
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC
from amaranth.lib.wiring import In, Out

from pathgene.hdl.command.layouts import AnswerKind, answer_layout
from pathgene.hdl.command.reply_words import WORD_BYTES, ReplyWords
from pathgene.hdl.config import Config
from pathgene.hdl.layouts import (
    read_layout,
    record_layout,
    result_read_layout,
    struct,
    waypoint_layout,
)
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.codes import Counter
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import (
    check_reply,
    counters_reply,
    info_reply,
    info_values,
    recipe_reply,
    status_reply,
    survivors_reply,
)


__all__ = ["ReplyTransmitter"]


class _After(enum.Enum, shape=3):
    """Part of the answer that follows the bytes in the register."""

    NOTHING = 0
    FIELDS = 1
    READ_OUT = 2
    WAYPOINT = 3
    RESULTS = 4
    BEST = RESULTS


class ReplyTransmitter(Unit):
    """Sends the answer that the command receiver has chosen, as a body without CRC.

    The first byte is offered 3 cycles after the transmitter is turned on, then one byte per cycle
    while ``replies`` is ready, with one more cycle before every word of up to six bytes of fields
    and before each waypoint. Registers of the chip are read when it is their turn, a word per
    cycle, so that a running counter is consistent. The counter of bytes sent is copied when the
    transmitter is turned on, so it does not include the current answer. Paths are sent as the core
    reads them, results of a check as the result store serves them, and paths of a run as the
    planner core serves them. A recipe waits for the CRC of the population, one cycle per waypoint
    and a few more.

    Source: *allaire-2008*, section 4.7. Difference: only the data that the host requested is sent.

    Members
    -------
    on, done : In(1), Out(1)
        Handshake with the control unit.
    answer : In(answer_layout)
        Answer to send.
    session : In(8)
        The open session, for ``INFO``.
    status, counters : In
        Registers of the chip, laid out as in the replies of :mod:`pathgene.hdl.protocol`.
    replies : Out(stream of body_layout)
        The body, byte by byte.

    Only if ``config`` has the paper core:

    recipe, survivors : In
        More registers, laid out as in the replies; ``recipe`` lacks its checksum.
    reads : Out(stream of slot, count)
        Slots to read.
    waypoints : In(stream of waypoint, last, final)
        Waypoints of these slots. ``last`` ends a path, ``final`` the last path.

    Only if ``config`` has a checker that checks the paths of commands:

    checked : In(9), totals : In, result_reads : Out(stream), records : In(stream)
        Paths of the latest check, and its results: see
        :class:`pathgene.hdl.feasibility.result_store.ResultStore`.

    Only if ``config`` has the planner core:

    has_best : In(1)
        A run has left paths. Otherwise, only a header answers a BEST.
    best : Out(1)
        Pulse: serve the paths of the latest run.
    records : In(stream of record_layout)
        Their bytes, after ``best``.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.status_layout = struct(status_reply(config))
        self.counters_layout = struct(counters_reply(config))
        members = {
            "on": In(1),
            "done": Out(1),
            "answer": In(answer_layout),
            "session": In(8),
            "status": In(self.status_layout),
            "counters": In(self.counters_layout),
            "replies": Out(stream.Signature(body_layout)),
        }
        if config.paper_core:
            recipe = recipe_reply(config)
            assert recipe.fields[-1][0] == "checksum"
            self.recipe_layout = struct(Layout(recipe.fields[:-1]))
            self.survivors_layout = data.ArrayLayout(config.slot_bits, config.survivors)
            self.read_layout = read_layout(config.slot_bits)
            self.waypoint_layout = waypoint_layout(config.waypoint_bits)
            members |= {
                "recipe": In(self.recipe_layout),
                "survivors": In(self.survivors_layout),
                "reads": Out(stream.Signature(self.read_layout)),
                "waypoints": In(stream.Signature(self.waypoint_layout)),
            }
        if config.checks_paths:
            self.totals_layout = struct(check_reply(config))
            members |= {
                "checked": In(9),
                "totals": In(self.totals_layout),
                "result_reads": Out(stream.Signature(result_read_layout)),
                "records": In(stream.Signature(record_layout)),
            }
        if config.planner_core:
            members |= {
                "has_best": In(1),
                "best": Out(1),
                "records": In(stream.Signature(record_layout)),
            }
        return members

    def elaborate(self, platform):
        m = Module()
        answer = self.answer

        checksum = Signal(32)
        m.submodules.fields = fields = ReplyWords(
            Cat(answer.session, answer.sequence, answer.status),
            self._replies(self._counters(m), checksum),
        )

        # The bytes being sent, and the part of the answer after them.
        word = Signal(8 * WORD_BYTES, reset_less=True)
        left = Signal(range(WORD_BYTES + 1))
        after = Signal(_After)
        m.d.comb += [fields.kind.eq(answer.kind), self.replies.p.plain.eq(answer.plain)]

        # Steady from the cycle after `on`.
        after_fields = Signal(_After)
        m.d.sync += after_fields.eq(_After.NOTHING)
        with m.Switch(answer.kind):
            if self.config.paper_core:
                with m.Case(AnswerKind.PATHS, AnswerKind.CHILDREN):
                    m.d.sync += after_fields.eq(_After.READ_OUT)
            if self.config.planner_core:
                with m.Case(AnswerKind.BEST):
                    with m.If(self.has_best):
                        m.d.sync += after_fields.eq(_After.BEST)
            if self.config.checks_paths:
                with m.Case(AnswerKind.RESULTS):
                    m.d.sync += after_fields.eq(_After.RESULTS)
                with m.Case(AnswerKind.CHECKED):
                    with m.If(self.checked != 0):
                        m.d.sync += after_fields.eq(_After.RESULTS)

        with m.FSM():
            with m.State("Off"):
                m.d.comb += fields.begin.eq(1)
                with m.If(self.on):
                    m.next = "Choose"
                    with m.Switch(answer.kind):
                        with m.Case(AnswerKind.SILENCE):
                            m.next = "Done"
                        if self.config.paper_core:
                            with m.Case(AnswerKind.RECIPE):
                                m.next = "Ask"

            with m.State("Choose"):
                m.next = "Fields"

            # The next word is ready before the bytes of this word are sent.
            with m.State("Fields"):
                m.d.comb += fields.next.eq(1)
                m.d.sync += [
                    word.eq(fields.word),
                    left.eq(fields.size),
                    after.eq(Mux(fields.final, after_fields, _After.FIELDS)),
                ]
                m.next = "Send"

            with m.State("Send"):
                m.d.comb += [
                    self.replies.valid.eq(1),
                    self.replies.p.data.eq(word[:8]),
                    self.replies.p.last.eq((left == 1) & (after == _After.NOTHING)),
                ]
                with m.If(self.replies.ready):
                    m.d.sync += [word.eq(word >> 8), left.eq(left - 1)]
                    with m.If(left == 1):
                        m.next = "Done"
                        with m.Switch(after):
                            with m.Case(_After.FIELDS):
                                m.next = "Fields"
                            if self.config.paper_core:
                                with m.Case(_After.READ_OUT):
                                    m.next = "Ask"
                                with m.Case(_After.WAYPOINT):
                                    m.next = "Take"
                            if self.config.checks_paths:
                                with m.Case(_After.RESULTS):
                                    m.next = "Ask for results"
                            if self.config.planner_core:
                                with m.Case(_After.BEST):
                                    m.next = "Ask for paths"

            if self.config.paper_core:
                self._read_out(m, checksum, word, left, after)
            if self.config.checks_paths:
                self._serve_results(m)
            if self.config.planner_core:
                with m.State("Ask for paths"):
                    m.d.comb += self.best.eq(1)
                    m.next = "Results"
                self._pass_records(m)

            with m.State("Done"):
                # The next header is ready even if the next answer follows soon.
                m.d.comb += [self.done.eq(1), fields.begin.eq(1)]
                with m.If(~self.on):
                    m.next = "Off"

        return m

    def _counters(self, m):
        """Return the counters in the order of the reply."""
        was_on = Signal()
        bytes_sent = Signal.like(self.counters.bytes_sent, reset_less=True)
        m.d.sync += was_on.eq(self.on)
        with m.If(~was_on):
            m.d.sync += bytes_sent.eq(self.counters.bytes_sent)
        return Cat(
            bytes_sent if name == Counter.BYTES_SENT else self.counters[name]
            for name in self.counters_layout.members
        )

    def _replies(self, counters, checksum):
        """Return the fields of each reply that has fields."""
        config = self.config
        constants = info_values(config)
        info = Cat(
            self.session if name == "session" else Const(constants[name], width)
            for name, width in info_reply(config).fields
        )
        replies = {
            (AnswerKind.INFO,): (info_reply(config), info),
            (AnswerKind.STATUS,): (status_reply(config), self.status),
            (AnswerKind.COUNTERS,): (counters_reply(config), counters),
        }
        if config.paper_core:
            survivors = Cat(Cat(slot, Const(0, 8 - len(slot))) for slot in self.survivors)
            replies |= {
                (AnswerKind.CHILDREN,): (survivors_reply(config), survivors),
                (AnswerKind.RECIPE,): (recipe_reply(config), Cat(self.recipe, checksum)),
            }
        if config.checks_paths:
            replies[AnswerKind.TOTALS, AnswerKind.CHECKED] = (check_reply(config), self.totals)
        parts = {
            kinds: [Cat(value, Const(0, 8 * layout.size - layout.bits))]
            for kinds, (layout, value) in replies.items()
        }
        parts[AnswerKind.STATUS,] = self._status_parts()
        return parts

    def _status_parts(self):
        """Return the status, split so that no field is in two words."""
        parts = [[]]
        for name in self.status_layout.members:
            field = self.status[name]
            if sum(map(len, [*parts[-1], field])) > 8 * WORD_BYTES:
                parts.append([])
            parts[-1].append(field)
        return [Cat(part) for part in parts]

    def _read_out(self, m, checksum, word, left, after):
        """Add the states that read waypoints, for the checksum or to be sent."""
        config, answer, waypoint = self.config, self.answer, self.waypoints.p
        m.submodules.checksum = unit = CRC32_ISO_HDLC(data_width=8 * config.waypoint_bytes).create()
        summing = Signal()  # The waypoints are read for the checksum.
        summed = Signal()  # A waypoint for the checksum is in the word.
        m.d.comb += [
            unit.start.eq(~summing),
            unit.data.eq(word[: config.waypoint_bits + 1]),
            unit.valid.eq(summed),
            checksum.eq(unit.crc),
            self.reads.p.slot.eq(Mux(summing, 0, answer.slot)),
            self.reads.p.count.eq(Mux(summing, config.population, answer.count)),
        ]
        m.d.sync += [
            summing.eq(self.on & (answer.kind == AnswerKind.RECIPE)),
            summed.eq(0),
        ]

        with m.State("Ask"):
            m.d.comb += self.reads.valid.eq(1)
            with m.If(self.reads.ready):
                m.next = "Take"
                with m.If(summing):
                    m.next = "Sum up"

        with m.State("Sum up"):
            m.d.comb += self.waypoints.ready.eq(1)
            m.d.sync += [
                word.eq(Cat(waypoint.waypoint, waypoint.last)),
                summed.eq(self.waypoints.valid),
            ]
            with m.If(self.waypoints.valid & waypoint.final):
                m.next = "Choose"

        with m.State("Take"):
            m.d.comb += self.waypoints.ready.eq(1)
            m.d.sync += [
                word.eq(Cat(waypoint.waypoint, waypoint.last)),
                left.eq(config.waypoint_bytes),
                after.eq(Mux(waypoint.final, _After.NOTHING, _After.WAYPOINT)),
            ]
            with m.If(self.waypoints.valid):
                m.next = "Send"

    def _serve_results(self, m):
        """Add the states that send the results of a check."""
        answer = self.answer
        every = answer.kind == AnswerKind.CHECKED
        m.d.comb += [
            self.result_reads.p.path.eq(Mux(every, 0, answer.slot)),
            self.result_reads.p.count.eq(Mux(every, self.checked, answer.count)),
        ]

        with m.State("Ask for results"):
            m.d.comb += self.result_reads.valid.eq(1)
            with m.If(self.result_reads.ready):
                m.next = "Results"
        self._pass_records(m)

    def _pass_records(self, m):
        """Add the state that sends the records of an answer as they arrive."""
        with m.State("Results"):
            m.d.comb += [
                self.replies.valid.eq(self.records.valid),
                self.replies.p.data.eq(self.records.p.data),
                self.replies.p.last.eq(self.records.p.last),
                self.records.ready.eq(self.replies.ready),
            ]
            with m.If(self.records.valid & self.replies.ready & self.records.p.last):
                m.next = "Done"
