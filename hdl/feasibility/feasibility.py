"""Feasibility check of a path in a memory, with the interface of *allaire two-tier*."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["Feasibility", "place_layout"]


def place_layout(config: Config) -> data.StructLayout:
    """Return the layout of a place in cells and altitude steps."""
    return data.StructLayout(
        {
            "x": config.coordinate_bits,
            "y": config.coordinate_bits,
            "altitude": config.altitude_bits,
        }
    )


class Feasibility(Unit):
    """Checks the path in a path memory, one at a time.

    The checker gets the aircraft in the cycle of ``enable`` and a point in each cycle after it. The
    flags therefore rise ``verdict.cycles - 1`` cycles after ``enable``.

    Source: *allaire two-tier*, section 3.1. Differences: a verdict in addition to the flags,
    counts, and a port to write the map.

    Members
    -------
    enable : In(1)
        Start a check; ignored while ``busy``. ``aircraft``, ``goal`` and ``waypoint_count`` are
        valid in this cycle, ``path_address`` and the first waypoint already in the previous cycle.
    aircraft, goal : In(place_layout)
    waypoint_count : In(length_bits)
        Waypoints between them, 0..max_waypoints.
    path_address : In(address_bits)
        Address of the first waypoint.
    read_address : Out(address_bits)
        To the path memory, of ``population * max_waypoints`` waypoints.
    waypoint : In(place_layout)
        The waypoint at the ``read_address`` of the previous cycle.
    count : In(1)
        Also count colliding cells, so that the path is walked to its end. Steady while ``busy``.
    busy : Out(1)
        A check is in progress, from the cycle after ``enable`` to the cycle in which a flag rises.
    collision, clear : Out(1)
        The path collides; the path is clear. Each flag stays up to and including the cycle of the
        next ``enable``.
    verdict : Out(verdict_layout)
        Valid from the cycle in which it is offered until the next verdict is offered.
    counts : Out(stream.Signature(count_layout))
    writes : In(stream.Signature(cell_layout))
        Cells to write into the map, ``last`` with the last cell of a rectangle. A check that is
        enabled after that cell waits until the coarse map is up to date.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.checker = Checker(config)
        place = place_layout(config)
        self.verdict_layout = verdict_layout(
            config.coordinate_bits, config.segment_bits, config.path_cells_bits
        )
        counts = count_layout(config.coordinate_bits, config.segment_bits)
        cells = cell_layout(config.coordinate_bits, config.altitude_bits)
        self.address_bits = ceil_log2(config.population * config.max_waypoints)
        return {
            "enable": In(1),
            "aircraft": In(place),
            "goal": In(place),
            "waypoint_count": In(config.length_bits),
            "path_address": In(self.address_bits),
            "read_address": Out(self.address_bits),
            "waypoint": In(place),
            "count": In(1),
            "busy": Out(1),
            "collision": Out(1),
            "clear": Out(1),
            "verdict": Out(self.verdict_layout),
            "counts": Out(stream.Signature(counts)),
            "writes": In(stream.Signature(cells)),
        }

    def elaborate(self, platform):
        m = Module()
        m.submodules.checker = checker = self.checker
        place = place_layout(self.config)

        connect(m, checker.counts, flipped(self.counts))
        connect(m, flipped(self.writes), checker.writes)
        # The checker's flags fall with the first point, which may have to wait.
        waiting = Signal()
        m.d.comb += [
            checker.count.eq(self.count),
            self.collision.eq(checker.collision & ~waiting),
            self.clear.eq(checker.clear & ~waiting),
        ]

        held = Signal(self.verdict_layout)
        m.d.comb += [
            checker.verdicts.ready.eq(1),
            self.verdict.eq(Mux(checker.verdicts.valid, checker.verdicts.p, held)),
        ]
        m.d.sync += held.eq(self.verdict)

        # The waypoint after `ahead` is at the memory's output, held there by its address.
        point = Signal(place)
        start, finish, ahead = Signal(place), Signal(place), Signal(place)
        fetched = Signal(self.address_bits)
        left = Signal(self.config.length_bits)
        moves = Signal()
        m.d.comb += [
            checker.points.p.x.eq(point.x),
            checker.points.p.y.eq(point.y),
            checker.points.p.altitude.eq(point.altitude),
            moves.eq(checker.points.valid & checker.points.ready),
            self.read_address.eq(fetched + moves),
        ]
        m.d.sync += fetched.eq(self.read_address)
        with m.If(moves):
            m.d.sync += ahead.eq(self.waypoint)

        with m.FSM() as states:
            m.d.comb += self.busy.eq(~states.ongoing("Idle"))
            with m.State("Idle"):
                m.d.comb += [
                    point.eq(self.aircraft),
                    checker.points.valid.eq(self.enable),
                    self.read_address.eq(self.path_address + moves),
                ]
                m.d.sync += [
                    start.eq(self.aircraft),
                    finish.eq(self.goal),
                    left.eq(self.waypoint_count),
                ]
                with m.If(moves):
                    m.next = "Waypoints"
                with m.Elif(self.enable):
                    m.next = "Aircraft"

            with m.State("Aircraft"):
                m.d.comb += [point.eq(start), checker.points.valid.eq(1), waiting.eq(1)]
                with m.If(moves):
                    m.next = "Waypoints"

            with m.State("Waypoints"):
                m.d.comb += [
                    point.eq(Mux(left.any(), ahead, finish)),
                    checker.points.valid.eq(1),
                    checker.points.p.last.eq(~left.any()),
                ]
                with m.If(moves):
                    m.d.sync += left.eq(left - 1)
                    with m.If(~left.any()):
                        m.next = "Checking"

            # An early collision decides a path before all its points are taken.
            with m.State("Checking"):
                with m.If(~checker.busy | checker.verdicts.valid):
                    m.next = "Idle"

        return m
