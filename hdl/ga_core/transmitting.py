"""Transmitting unit: sends one answer."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC
from amaranth.lib.wiring import In, Out

from hdl.commands.layouts import AnswerKind, answer_layout, request_layout, struct
from hdl.config import CheckerBuild, Config
from hdl.feasibility.result_store import record_layout
from hdl.ga_core.layouts import read_layout, waypoint_layout
from hdl.protocol import (
    BODY_HEADER_BYTES,
    Layout,
    check_reply,
    counters_reply,
    info_reply,
    info_values,
    recipe_reply,
    status_reply,
    survivors_reply,
)


__all__ = ["TransmittingUnit"]


class TransmittingUnit(wiring.Component):
    """Sends the answer that the receiving unit has settled, as a body without CRC.

    Registers on the chip are copied when the unit is turned on, all in one clock. The first byte is
    offered 2 clocks later, then a byte a clock while ``replies`` is ready; paths follow as the core
    reads them out, results of a check as they are served. A recipe waits for the CRC of the
    population, a clock per waypoint and a few more.

    Source: *allaire-2008*, section 4.7. Differs: only what the host asked for is sent.

    Parameters
    ----------
    config : Config

    Members
    -------
    on, over : In(1), Out(1)
        Hand-over with the control unit.
    answer : In(answer_layout)
        What to answer.
    session : In(8)
        The open session, for ``INFO``.
    status, counters, recipe, survivors : In
        Registers of the chip, as the replies of :mod:`hdl.protocol` lay them out; ``recipe`` is
        without its checksum.
    reads : Out(stream of slot, count)
        Slots to read out.
    waypoints : In(stream of waypoint, last, final)
        Their waypoints. ``last`` ends a path, ``final`` the last path.
    replies : Out(stream of request_layout)
        The body, byte by byte.

    Only where ``config`` has a checker:

    checked : In(9), totals : In, result_reads : Out(stream), records : In(stream)
        Paths of the latest check, and its results: see
        :class:`hdl.feasibility.result_store.ResultStore`.
    """

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Configuration must be a Config, not {config!r}")
        self.config = config
        self.has_checker = config.checker is not CheckerBuild.NONE

        recipe = recipe_reply(config)
        assert recipe.fields[-1][0] == "checksum"
        self.status_layout = struct(status_reply(config))
        self.counters_layout = struct(counters_reply(config))
        self.recipe_layout = struct(Layout(recipe.fields[:-1]))
        self.survivors_layout = data.ArrayLayout(config.slot_bits, config.survivors)
        self.read_layout = read_layout(config)
        self.waypoint_layout = waypoint_layout(config)
        self.totals_layout = struct(check_reply(config))
        self.result_read_layout = data.StructLayout({"path": 8, "count": 9})
        self.record_layout = record_layout(config)
        results = {
            "checked": In(9),
            "totals": In(self.totals_layout),
            "result_reads": Out(stream.Signature(self.result_read_layout)),
            "records": In(stream.Signature(self.record_layout)),
        }
        super().__init__(
            {
                "on": In(1),
                "over": Out(1),
                "answer": In(answer_layout),
                "session": In(8),
                "status": In(self.status_layout),
                "counters": In(self.counters_layout),
                "recipe": In(self.recipe_layout),
                "survivors": In(self.survivors_layout),
                "reads": Out(stream.Signature(self.read_layout)),
                "waypoints": In(stream.Signature(self.waypoint_layout)),
                "replies": Out(stream.Signature(request_layout)),
                **(results if self.has_checker else {}),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        answer = self.answer

        word_bits = 8 * config.waypoint_bytes
        m.submodules.checksum = checksum = CRC32_ISO_HDLC(data_width=word_bits).create()
        word = Signal(word_bits)
        m.d.comb += [
            word.eq(Cat(self.waypoints.p.waypoint, self.waypoints.p.last)),
            checksum.data.eq(word),
        ]

        # Each reply of fixed fields, with its size in bytes.
        constants = info_values(config)
        info = Cat(
            self.session if name == "session" else Const(constants[name], width)
            for name, width in info_reply(config).fields
        )
        pad = Const(0, 8 - config.slot_bits)
        survivors = Cat(Cat(slot, pad) for slot in self.survivors)
        replies = {
            AnswerKind.INFO: (info, info_reply(config).size),
            AnswerKind.STATUS: (self.status.as_value(), status_reply(config).size),
            AnswerKind.COUNTERS: (self.counters.as_value(), counters_reply(config).size),
            AnswerKind.CHILDREN: (survivors, survivors_reply(config).size),
            AnswerKind.RECIPE: (
                Cat(self.recipe.as_value(), checksum.crc),
                recipe_reply(config).size,
            ),
        }
        if self.has_checker:
            totals = (self.totals.as_value(), check_reply(config).size)
            replies |= {AnswerKind.TOTALS: totals, AnswerKind.CHECKED: totals}

        size = max(size for _, size in replies.values())
        fields = Signal(8 * (BODY_HEADER_BYTES + size))
        left = Signal(range(BODY_HEADER_BYTES + size + 1))  # Bytes of fields.
        paths = Signal()  # Paths follow the fields.
        results = Signal()  # Results do.
        part = Signal(range(config.waypoint_bytes))
        held = Signal(word_bits)
        final = Signal()
        m.d.comb += [
            self.replies.p.plain.eq(answer.plain),
            self.reads.p.slot.eq(answer.slot),
            self.reads.p.count.eq(answer.count),
        ]

        with m.FSM():
            with m.State("Off"):
                m.d.comb += checksum.start.eq(1)
                with m.If(self.on):
                    m.next = "Load"
                    with m.Switch(answer.kind):
                        with m.Case(AnswerKind.SILENCE):
                            m.next = "Over"
                        with m.Case(AnswerKind.RECIPE):
                            m.next = "Ask for all"

            with m.State("Ask for all"):
                m.d.comb += [
                    self.reads.valid.eq(1),
                    self.reads.p.slot.eq(0),
                    self.reads.p.count.eq(config.population),
                ]
                with m.If(self.reads.ready):
                    m.next = "Sum up"

            with m.State("Sum up"):
                m.d.comb += [
                    self.waypoints.ready.eq(1),
                    checksum.valid.eq(self.waypoints.valid),
                ]
                with m.If(self.waypoints.valid & self.waypoints.p.final):
                    m.next = "Load"

            with m.State("Load"):
                header = Cat(answer.session, answer.sequence, answer.status)
                m.d.sync += [
                    fields.eq(header),
                    left.eq(BODY_HEADER_BYTES),
                    paths.eq(
                        (answer.kind == AnswerKind.PATHS) | (answer.kind == AnswerKind.CHILDREN)
                    ),
                ]
                with m.Switch(answer.kind):
                    for kind, (value, size) in replies.items():
                        with m.Case(kind):
                            m.d.sync += [
                                fields.eq(Cat(header, value)),
                                left.eq(BODY_HEADER_BYTES + size),
                            ]
                if self.has_checker:
                    m.d.sync += results.eq(
                        (answer.kind == AnswerKind.RESULTS)
                        | ((answer.kind == AnswerKind.CHECKED) & (self.checked != 0))
                    )
                m.next = "Fields"

            with m.State("Fields"):
                m.d.comb += [
                    self.replies.valid.eq(1),
                    self.replies.p.data.eq(fields[:8]),
                    self.replies.p.last.eq((left == 1) & ~paths & ~results),
                ]
                with m.If(self.replies.ready):
                    m.d.sync += [fields.eq(fields[8:]), left.eq(left - 1)]
                    with m.If(left == 1):
                        m.next = "Over"
                        with m.If(paths):
                            m.next = "Ask"
                        if self.has_checker:
                            with m.Elif(results):
                                m.next = "Ask for results"

            with m.State("Ask"):
                m.d.comb += self.reads.valid.eq(1)
                with m.If(self.reads.ready):
                    m.next = "Take"

            with m.State("Take"):
                m.d.comb += self.waypoints.ready.eq(1)
                m.d.sync += [held.eq(word), final.eq(self.waypoints.p.final), part.eq(0)]
                with m.If(self.waypoints.valid):
                    m.next = "Waypoint"

            with m.State("Waypoint"):
                ends = Signal()
                m.d.comb += [
                    ends.eq(part == config.waypoint_bytes - 1),
                    self.replies.valid.eq(1),
                    self.replies.p.data.eq(held[:8]),
                    self.replies.p.last.eq(ends & final),
                ]
                with m.If(self.replies.ready):
                    m.d.sync += [held.eq(held[8:]), part.eq(part + 1)]
                    with m.If(ends):
                        m.next = "Take"
                        with m.If(final):
                            m.next = "Over"

            if self.has_checker:
                with m.State("Ask for results"):
                    every = answer.kind == AnswerKind.CHECKED
                    m.d.comb += [
                        self.result_reads.valid.eq(1),
                        self.result_reads.p.path.eq(Mux(every, 0, answer.slot)),
                        self.result_reads.p.count.eq(Mux(every, self.checked, answer.count)),
                    ]
                    with m.If(self.result_reads.ready):
                        m.next = "Results"

                with m.State("Results"):
                    m.d.comb += [
                        self.replies.valid.eq(self.records.valid),
                        self.replies.p.data.eq(self.records.p.data),
                        self.replies.p.last.eq(self.records.p.last),
                        self.records.ready.eq(self.replies.ready),
                    ]
                    with m.If(self.records.valid & self.replies.ready & self.records.p.last):
                        m.next = "Over"

            with m.State("Over"):
                m.d.comb += self.over.eq(1)
                with m.If(~self.on):
                    m.next = "Off"

        return m
