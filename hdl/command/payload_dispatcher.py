"""Dispatcher of payloads: passes the bytes after the fixed fields to the parser of the command."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.cell_parser import CellParser
from pathgene.hdl.command.coded_cell_parser import CodedCellParser
from pathgene.hdl.command.ranking_parser import RankingParser
from pathgene.hdl.command.waypoint_parsers import PathParser, PointParser
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.layouts import cell_layout, point_layout, ranking_layout, struct, write_layout
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.codes import Command
from pathgene.hdl.protocol.messages import coded_map_request, map_request


__all__ = ["PayloadDispatcher"]


class PayloadDispatcher(Unit):
    """The parsers of all commands with a variable-length payload; one parser is on at a time.

    The code selects the parser well before it is turned on, and a separate register turns it on, so
    that neither the code nor the state of the receiver is on a path through a parser.

    Members
    -------
    code : In(8)
        Command; steady from 2 cycles before ``launch`` to ``done``.
    launch : In(1)
        Turn on the parser of ``code`` in the next cycle, if it has one.
    repeated, bytes, ended, done, status
        As in a parser: see :func:`pathgene.hdl.command.layouts.payload_members`.

    Only if ``config`` has the paper core:

    write_slot : In(8)
        First slot of a WRITE.
    identity : In(1)
        A GENERATE does not carry an order of the slots.
    writes, ranking : Out(stream), ranked : In(1)
        Members of :class:`pathgene.hdl.command.waypoint_parsers.PathParser` and
        :class:`pathgene.hdl.command.ranking_parser.RankingParser`.

    Only if ``config`` has a checker:

    rectangle : In(struct of map_request)
        Fields of a MAP.
    coded : In(struct of coded_map_request)
        Only with the planner core: fields of a CODED_MAP.
    cells : Out(stream)
        ``writes`` of :class:`pathgene.hdl.command.cell_parser.CellParser` or
        :class:`pathgene.hdl.command.coded_cell_parser.CodedCellParser`.
    points : Out(stream)
        Only without the planner core: ``points`` of
        :class:`pathgene.hdl.command.waypoint_parsers.PointParser`.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.has_checker = config.checker is not CheckerBuild.NONE
        members = {
            "code": In(8),
            "launch": In(1),
            "repeated": In(1),
            "bytes": In(stream.Signature(8)),
            "ended": In(1),
            "done": Out(1),
            "status": Out(8),
        }
        if config.paper_core:
            writes = write_layout(config.slot_bits, config.index_bits, config.waypoint_bits)
            members |= {
                "write_slot": In(8),
                "identity": In(1),
                "writes": Out(stream.Signature(writes)),
                "ranking": Out(stream.Signature(ranking_layout(config.slot_bits))),
                "ranked": In(1),
            }
        if self.has_checker:
            cells = cell_layout(config.coordinate_bits, config.altitude_bits)
            members |= {
                "rectangle": In(struct(map_request(config))),
                "cells": Out(stream.Signature(cells)),
            }
        if config.planner_core:
            members["coded"] = In(struct(coded_map_request(config)))
        if config.checks_paths:
            points = point_layout(config.coordinate_bits, config.altitude_bits)
            members["points"] = Out(stream.Signature(points))
        return members

    def elaborate(self, platform):
        m = Module()

        wanted, done, statuses = [], [], []
        for command, parser in self._parsers(m).items():
            meant = Signal(name=f"{command.name.lower()}_meant", reset_less=True)
            on = Signal(name=f"{command.name.lower()}_on")
            m.d.sync += [
                meant.eq(self.code == command),
                on.eq((on | (self.launch & meant)) & ~self.done),
            ]
            m.d.comb += [
                parser.on.eq(on),
                parser.repeated.eq(self.repeated),
                parser.ended.eq(self.ended),
                parser.bytes.valid.eq(on & self.bytes.valid & ~self.ended),
                parser.bytes.payload.eq(self.bytes.payload),
            ]
            wanted.append(on & parser.bytes.ready)
            done.append(on & parser.done)
            statuses.append(Mux(on, parser.status, 0))
        m.d.comb += [
            self.bytes.ready.eq(Cat(wanted).any()),
            self.done.eq(Cat(done).any()),
            self.status.eq(reduce(or_, statuses)),
        ]

        return m

    def _parsers(self, m):
        """Add the parsers; return them by command."""
        parsers = {}
        config = self.config
        if config.paper_core:
            m.submodules.path_parser = path_parser = PathParser(
                config.population, config.waypoint_bits, config.MIN_WAYPOINTS, config.max_waypoints
            )
            m.submodules.ranking_parser = ranking_parser = RankingParser(config.population)
            parsers |= {Command.WRITE: path_parser, Command.GENERATE: ranking_parser}
            connect(m, path_parser.writes, flipped(self.writes))
            connect(m, ranking_parser.ranking, flipped(self.ranking))
            m.d.comb += [
                path_parser.slot.eq(self.write_slot),
                ranking_parser.identity.eq(self.identity),
                ranking_parser.ranked.eq(self.ranked),
            ]
        if self.has_checker:
            m.submodules.cell_parser = cell_parser = CellParser(
                config.coordinate_bits, config.altitude_bits, self.rectangle.shape()
            )
            parsers[Command.MAP] = cell_parser
            if config.planner_core:
                m.submodules.coded_parser = coded_parser = CodedCellParser(
                    config.coordinate_bits, config.altitude_bits, self.coded.shape()
                )
                parsers[Command.CODED_MAP] = coded_parser
                m.d.comb += [
                    coded_parser.rectangle.eq(self.coded),
                    cell_parser.writes.ready.eq(self.cells.ready),
                    coded_parser.writes.ready.eq(self.cells.ready),
                    self.cells.valid.eq(cell_parser.writes.valid | coded_parser.writes.valid),
                    self.cells.p.eq(
                        Mux(cell_parser.writes.valid, cell_parser.writes.p, coded_parser.writes.p)
                    ),
                ]
            else:
                connect(m, cell_parser.writes, flipped(self.cells))
            if config.checks_paths:
                m.submodules.point_parser = point_parser = PointParser(
                    config.coordinate_bits, config.altitude_bits, config.max_waypoints
                )
                parsers[Command.CHECK] = point_parser
                connect(m, point_parser.points, flipped(self.points))
            m.d.comb += cell_parser.rectangle.eq(self.rectangle)
        return parsers
