"""Receiving unit: takes one request and hands it to the core or to the checker."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.command.cell_parser import CellParser
from hdl.command.field_decoder import FieldDecoder, request_fields
from hdl.command.layouts import AnswerKind, answer_layout, request_layout
from hdl.command.path_parser import PathParser
from hdl.command.point_parser import PointParser
from hdl.command.ranking_parser import RankingParser
from hdl.config import CheckerBuild, Config
from hdl.layouts import (
    cell_layout,
    check_layout,
    point_layout,
    ranking_layout,
    start_layout,
    write_layout,
)
from hdl.protocol import Command, Status, StickyError


__all__ = ["CommandReceiver"]


class CommandReceiver(wiring.Component):
    """Takes requests apart, by the rules of :mod:`hdl.protocol`.

    Turned on with a request waiting, it takes one byte a clock, but for what the units of
    :mod:`hdl.command` say of ranks, waypoints and cells. It is over at most 6 clocks after the
    last byte; with a GENERATE or a MAP, when the core or the checker is ready for what follows.
    Whatever the request holds, all of it is taken and the unit ends. ``valid`` of every stream
    out of here is a register.

    A refused WRITE may have changed the slots it names, whose lengths stay within the limits, and a
    MAP of a wrong length cells of its rectangle.

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
    requests : In(stream of request_layout)
        Bodies of undamaged frames, without CRC.
    answer : Out(answer_layout)
        How to answer; steady from ``over`` to the next ``on``.
    session : Out(8)
        The open session.
    line_errors : In(4)
        Pulses from the line: FRAMING, OVERRUN, CRC, MALFORMED of :class:`hdl.protocol.StickyError`.
    errors : Out(8)
        All sticky errors.

    Only where ``config`` has a genetic core:

    generate : Out(1)
        With ``over``: a generation is to run before the answer.
    starts : Out(stream of seed, x, y, altitude, avoid_ground)
        Seed of the random source, limits of new waypoints.
    writes : Out(stream of slot, index, waypoint, last)
        Waypoints for the present population.
    ranking : Out(stream of rank, slot)
        The slots from the best path to the worst.
    ranked : In(1)
        The core has worked the ranking in.

    Only where ``config`` has a checker:

    cells : Out(stream of x, y, altitude, last)
        Cells of the map; see :class:`hdl.command.cell_parser.CellParser`.
    forget : Out(1)
        A check has come in: points handed on before and not checked are void.
    points : Out(stream of x, y, altitude, last)
        Those of one path.
    check : Out(1)
        With ``over``: ``checks`` is to be done before the answer.
    checks : Out(check_layout)
        Steady from ``over`` to the next ``on``.
    checked : In(9)
        Paths of the latest check, whose results can be asked for.
    """

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Configuration must be a Config, not {config!r}")
        self.config = config
        self.has_checker = config.checker is not CheckerBuild.NONE

        members = {
            "on": In(1),
            "over": Out(1),
            "pending": Out(1),
            "requests": In(stream.Signature(request_layout)),
            "answer": Out(answer_layout),
            "session": Out(8),
            "line_errors": In(4),
            "errors": Out(8),
        }
        if config.genetic:
            self.start_layout = start_layout(config)
            self.write_layout = write_layout(config)
            self.ranking_layout = ranking_layout(config)
            members |= {
                "generate": Out(1),
                "starts": Out(stream.Signature(self.start_layout)),
                "writes": Out(stream.Signature(self.write_layout)),
                "ranking": Out(stream.Signature(self.ranking_layout)),
                "ranked": In(1),
            }
        if self.has_checker:
            self.cell_layout = cell_layout(config)
            self.point_layout = point_layout(config)
            self.check_layout = check_layout(config)
            members |= {
                "cells": Out(stream.Signature(self.cell_layout)),
                "forget": Out(1),
                "points": Out(stream.Signature(self.point_layout)),
                "check": Out(1),
                "checks": Out(self.check_layout),
                "checked": In(9),
            }
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.fixed_fields = fixed_fields = FieldDecoder(config)
        takers = {}
        if config.genetic:
            m.submodules.path_writer = path_writer = PathParser(config)
            m.submodules.order_taker = order_taker = RankingParser(config)
            takers |= {Command.WRITE: path_writer, Command.GENERATE: order_taker}
            connect(m, path_writer.writes, flipped(self.writes))
            connect(m, order_taker.ranking, flipped(self.ranking))
            m.d.comb += [
                self.starts.p.eq(fixed_fields.start),
                path_writer.slot.eq(fixed_fields.write_slot),
                order_taker.identity.eq(fixed_fields.identity),
                order_taker.ranked.eq(self.ranked),
            ]
        if self.has_checker:
            m.submodules.cell_writer = cell_writer = CellParser(config)
            m.submodules.point_taker = point_taker = PointParser(config)
            takers |= {Command.MAP: cell_writer, Command.CHECK: point_taker}
            connect(m, cell_writer.writes, flipped(self.cells))
            connect(m, point_taker.points, flipped(self.points))
            m.d.comb += [
                cell_writer.rectangle.eq(fixed_fields.rectangle),
                self.checks.eq(fixed_fields.checks),
                fixed_fields.checked.eq(self.checked),
            ]

        byte = self.requests.p.data
        take = Signal()
        ended = Signal()  # The last byte has been taken.
        code = Signal(8)
        expected = Signal(8)
        repeated = Signal()
        packed = Signal(8 * fixed_fields.size)
        left = Signal(range(fixed_fields.size + 1))  # Bytes of the fixed fields.
        m.d.comb += [
            self.pending.eq(self.requests.valid),
            take.eq(self.requests.valid & self.requests.ready),
            fixed_fields.code.eq(code),
            fixed_fields.packed.eq(packed),
            fixed_fields.ended.eq(ended),
        ]
        with m.If(take):
            m.d.sync += ended.eq(self.requests.p.last)

        # Who takes the rest is known from the code, long before it is turned on by a register of
        # its own: neither code nor state are looked at in the middle of what the takers do.
        takes_rest = Signal()
        rest_taken = Signal()
        demanded = []
        overs = []
        statuses = []
        for command, taker in takers.items():
            meant = Signal(name=f"{command.name.lower()}_meant", reset_less=True)
            on = Signal(name=f"{command.name.lower()}_on")
            m.d.sync += [
                meant.eq(code == command),
                on.eq((on | (takes_rest & meant)) & ~rest_taken),
            ]
            m.d.comb += [
                taker.on.eq(on),
                taker.repeated.eq(repeated),
                taker.ended.eq(ended),
                taker.bytes.valid.eq(on & self.requests.valid & ~ended),
                taker.bytes.payload.eq(byte),
            ]
            demanded.append(on & taker.bytes.ready)
            overs.append(on & taker.over)
            statuses.append(Mux(on, taker.status, 0))
        m.d.comb += rest_taken.eq(Cat(overs).any())

        # The fixed fields.
        collecting = Signal()
        collect = Signal()
        m.d.comb += collect.eq(collecting & self.requests.valid & ~ended)
        with m.If(collect):
            m.d.sync += [packed.eq(Cat(packed[8:], byte)), left.eq(left - 1)]

        # What the header says, registered while the rest of it comes in.
        at_hand = Signal()  # Its session is the open one,
        next_session = Signal()  # or the one after that.
        present = Signal()  # Its number is the expected one,
        previous = Signal()  # or the one before,
        future = Signal()  # or one that is to come.
        ahead = Signal(8)
        m.d.comb += ahead.eq(self.answer.sequence - expected)
        m.d.sync += [
            at_hand.eq(self.answer.session == self.session),
            next_session.eq(self.answer.session == (self.session + 1)[:8]),
            present.eq(ahead == 0),
            previous.eq(ahead == 255),
            future.eq((ahead != 0) & (ahead < 129)),
        ]

        verdict = Signal(8)  # Of the taker.
        refused = Signal()
        cleared = Signal()
        m.d.sync += [refused.eq(0), cleared.eq(0)]
        m.d.sync += self.errors.eq(
            Mux(cleared, 0, self.errors)
            | self.line_errors
            | Mux(refused, StickyError.REFUSED.value, 0)
        )

        if self.has_checker:
            m.d.sync += self.forget.eq(0)

        def answer_with(status):
            m.d.sync += [self.answer.status.eq(status), self.answer.kind.eq(AnswerKind.EMPTY)]

        def refuse(status):
            answer_with(status)
            m.d.sync += refused.eq(1)
            m.next = "Drain"

        with m.FSM():
            with m.State("Off"):
                m.d.sync += [ended.eq(0), repeated.eq(0)]
                if config.genetic:
                    m.d.sync += self.generate.eq(0)
                if self.has_checker:
                    m.d.sync += self.check.eq(0)
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
                    with m.If(next_session):
                        m.d.sync += [self.session.eq(self.answer.session), expected.eq(0)]
                    with m.Elif(~at_hand):
                        answer_with(Status.NO_SESSION)
                with m.Elif(~at_hand):
                    answer_with(Status.NO_SESSION)
                with m.Elif(future):
                    answer_with(Status.OUT_OF_ORDER)
                    m.d.sync += self.answer.sequence.eq(expected)
                with m.Elif(~present & ~previous):
                    answer_with(Status.DUPLICATE)
                with m.Else():
                    m.d.sync += repeated.eq(previous)
                    with m.Switch(code):
                        for command, layout in request_fields(config).items():
                            with m.Case(command):
                                m.d.sync += [
                                    left.eq(layout.size),
                                    collecting.eq(layout.size != 0),
                                ]
                                m.next = "Fixed" if layout.size else "Weigh"
                        with m.Default():
                            refuse(Status.UNKNOWN_COMMAND)

            with m.State("Drain"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(ended):
                    m.d.sync += self.over.eq(1)
                    m.next = "Over"

            with m.State("Fixed"):
                m.d.comb += self.requests.ready.eq(~ended)
                with m.If(ended):
                    m.d.sync += collecting.eq(0)
                    refuse(Status.BAD_LENGTH)
                with m.Elif(collect & (left == 1)):
                    m.d.sync += collecting.eq(0)
                    m.next = "Weigh"

            with m.State("Weigh"):
                m.next = "Weigh again"

            with m.State("Weigh again"):
                m.next = "Judge"

            with m.State("Judge"):
                m.d.sync += [
                    self.answer[name].eq(getattr(fixed_fields, name))
                    for name in ("kind", "slot", "count")
                ]
                m.d.comb += takes_rest.eq(fixed_fields.status == Status.OK)
                m.next = "Executed"
                with m.Switch(code):
                    with m.Case(*takers):
                        m.next = "Rest"
                    if config.genetic:
                        with m.Case(Command.START):
                            with m.If(~repeated):
                                m.next = "Start"
                if self.has_checker:
                    m.d.sync += self.forget.eq(
                        (code == Command.CHECK) | (code == Command.CHECK_PATHS)
                    )
                    m.d.sync += self.check.eq(
                        (code == Command.CHECK_PATHS)
                        & ~repeated
                        & (fixed_fields.status == Status.OK)
                    )
                with m.If(fixed_fields.status != Status.OK):
                    refuse(fixed_fields.status)
                with m.Elif(code == Command.CLEAR):
                    m.d.sync += cleared.eq(~repeated)
                if config.genetic:
                    with m.Elif(code == Command.START):
                        m.d.sync += self.starts.valid.eq(~repeated)

            if config.genetic:
                with m.State("Start"):
                    with m.If(self.starts.ready):
                        m.d.sync += self.starts.valid.eq(0)
                        m.next = "Executed"

            with m.State("Rest"):
                m.d.comb += self.requests.ready.eq(Cat(demanded).any() & ~ended)
                m.d.sync += verdict.eq(reduce(or_, statuses))
                with m.If(rest_taken):
                    m.next = "Taken"

            with m.State("Taken"):
                with m.If(verdict != Status.OK):
                    refuse(verdict)
                with m.Else():
                    if config.genetic:
                        m.d.sync += self.generate.eq((code == Command.GENERATE) & ~repeated)
                    if self.has_checker:
                        with m.If(code == Command.CHECK):
                            m.d.sync += self.check.eq(~repeated)
                    m.next = "Executed"

            with m.State("Executed"):
                with m.If(~repeated):
                    m.d.sync += expected.eq(expected + 1)
                m.d.sync += self.over.eq(1)
                m.next = "Over"

            with m.State("Over"):
                with m.If(~self.on):
                    m.d.sync += self.over.eq(0)
                    m.next = "Off"

        return m
