"""The whole chip: line, receiving and transmitting units, genetic core or checker, or both."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect

from hdl.check_control import CheckControl
from hdl.command.receiver import CommandReceiver
from hdl.command.transmitter import ReplyTransmitter
from hdl.config import CheckerBuild, Config
from hdl.feasibility.check_controller import CheckController
from hdl.feasibility.checker import Checker
from hdl.ga_core.core import Core
from hdl.link.line import Line
from hdl.primitives.skid_buffer import SkidBuffer
from hdl.protocol import Counter


__all__ = ["Planner"]


class Planner(wiring.Component):
    """The chip behind its UART; :mod:`hdl.protocol` says what it answers.

    Source: *allaire-2008*, figure 6; where ``config`` has a checker, with the processor of *allaire
    two-tier* beside the core, which hands it its paths and asks it for the ground under new
    waypoints. Where ``config`` has no genetic core, the checker is alone.

    Parameters
    ----------
    config : Config

    Members
    -------
    clk, rst : In(1)
        Clock, and reset, which acts one to three clocks later, and for four clocks at least.
    rx, tx : In(1), Out(1)
        UART pins, 8N1, ``config.clocks_per_bit`` clocks per bit; high when idle.
    """

    clk: In(1)
    rst: In(1)
    rx: In(1, init=1)
    tx: Out(1, init=1)

    def __init__(self, config: Config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")
        self.config = config
        super().__init__()

    def elaborate(self, platform):
        m = Module()

        # On a large chip, the reset comes to one part after the other, from a register each: all of
        # them are out of reach for one. It lasts until all parts are reset at once.
        m.domains.unreset = ClockDomain(reset_less=True)
        m.d.comb += ClockSignal("unreset").eq(self.clk)
        lasting = Signal(3)
        reset = Signal()
        m.d.comb += reset.eq(self.rst | lasting.any())
        m.d.unreset += lasting.eq(Cat(self.rst, lasting))
        for domain in ("sync", "core", "checker"):
            setattr(m.domains, domain, ClockDomain(domain))
            m.d.comb += ClockSignal(domain).eq(self.clk)
            m.d.unreset += ResetSignal(domain).eq(reset)
            if self.config.genetic:
                reset = ResetSignal(domain)

        m.submodules.line = line = Line(self.config)
        m.submodules.receiving = receiving = CommandReceiver(self.config)
        # Either has the control unit and its counters.
        core = (Core if self.config.genetic else CheckControl)(self.config)
        m.submodules.core = DomainRenamer("core")(core)
        m.submodules.transmitting = transmitting = ReplyTransmitter(self.config)

        m.d.comb += [line.rx.eq(self.rx), self.tx.eq(line.tx)]
        connect(m, line.requests, receiving.requests)
        connect(m, transmitting.replies, line.replies)
        has_checker = self.config.checker is not CheckerBuild.NONE
        if has_checker:
            checker, checking = self._add_checker(m, core, receiving, transmitting)
        if self.config.genetic:
            self._connect_core(m, core, receiving, transmitting)
        if has_checker and self.config.genetic:
            self._share_core(m, core, checker, checking, transmitting)
        elif self.config.genetic:
            connect(m, transmitting.reads, core.reads)
            connect(m, core.waypoints, transmitting.waypoints)

        # Hand-overs.
        m.d.comb += [
            core.line_busy.eq(line.busy),
            core.line_sending.eq(line.sending),
            core.pending.eq(receiving.pending),
            receiving.on.eq(core.receive_on),
            core.receive_over.eq(receiving.done),
            transmitting.on.eq(core.transmit_on),
            core.transmit_over.eq(transmitting.done),
        ]

        # What the answers tell.
        m.d.comb += [
            receiving.line_errors.eq(line.errors),
            transmitting.answer.eq(receiving.answer),
            transmitting.session.eq(receiving.session),
            transmitting.status.state.eq(core.state),
            transmitting.status.history.eq(core.history),
            transmitting.status.errors.eq(receiving.errors),
            transmitting.counters[Counter.BYTES_RECEIVED].eq(line.bytes_received),
            transmitting.counters[Counter.BYTES_SENT].eq(line.bytes_sent),
        ]
        for counter, _ in core.counters.shape():
            m.d.comb += transmitting.counters[counter].eq(core.counters[counter])

        return m

    def _connect_core(self, m, core, receiving, transmitting):
        """Connect what only a genetic core has."""
        connect(m, receiving.start_requests, core.starts)
        connect(m, receiving.writes, core.writes)
        connect(m, receiving.ranking, core.ranking)
        m.d.comb += [
            receiving.ranked.eq(core.ranked),
            core.generate.eq(receiving.generate),
            transmitting.status.generation.eq(core.generation),
        ]
        for unit, _ in core.clocks.shape():
            m.d.comb += transmitting.status[unit].eq(core.clocks[unit])

        recipe = transmitting.recipe
        for i, slot in enumerate(core.parents):
            m.d.comb += recipe[f"parent_{i}"].eq(slot)
        for i, slot in enumerate(core.survivors):
            m.d.comb += [
                recipe[f"survivor_{i}"].eq(slot),
                transmitting.survivors[i].eq(slot),
            ]
        for i, mutation in enumerate(core.mutations):
            m.d.comb += [
                recipe[f"applied_{i}"].eq(mutation.applied),
                recipe[f"child_{i}"].eq(mutation.child),
                recipe[f"index_{i}"].eq(mutation.index),
            ]
        for i, waypoint in enumerate(core.patches):
            m.d.comb += recipe[f"waypoint_{i}"].eq(waypoint)

    def _add_checker(self, m, core, receiving, transmitting):
        """Add the checker, between the units that take commands and answer them."""
        checker = Checker(self.config)
        m.submodules.checker = DomainRenamer("checker")(checker)
        m.submodules.checking = checking = CheckController(self.config)

        if self.config.genetic:
            # On a large chip, the checker's `ready` comes late and from afar.
            m.submodules.cells = cells = SkidBuffer(receiving.cells.payload.shape())
            connect(m, receiving.cells, cells.words)
            connect(m, cells.passed, checker.writes)
        else:
            connect(m, receiving.cells, checker.writes)
        connect(m, receiving.points, checking.points)
        connect(m, checking.paths, checker.points)
        connect(m, checker.verdicts, checking.verdicts)
        connect(m, checker.counts, checking.counts)
        connect(m, transmitting.result_reads, checking.result_reads)
        connect(m, checking.records, transmitting.records)
        m.d.comb += [
            core.check.eq(receiving.check),
            checking.on.eq(core.check_on),
            core.check_over.eq(checking.done),
            checking.forget.eq(receiving.forget),
            checking.checks.eq(receiving.checks),
            checker.count.eq(checking.counting),
            receiving.checked.eq(checking.checked),
            transmitting.checked.eq(checking.checked),
            transmitting.totals.eq(checking.totals),
        ]
        for counter, _ in checking.counters.shape():
            m.d.comb += transmitting.counters[counter].eq(checking.counters[counter])
        return checker, checking

    def _share_core(self, m, core, checker, checking, transmitting):
        """Let the core ask the checker for the ground, and others have its paths read out."""
        m.d.comb += [
            checker.lookup_valid.eq(core.lookup_valid),
            checker.lookup_x.eq(core.lookup_x),
            checker.lookup_y.eq(core.lookup_y),
            core.lookup_altitude.eq(checker.lookup_altitude),
        ]
        # One of them at a time has paths read out: the one that is on.
        with m.If(core.check_on):
            self._read_out(m, core, checking)
        with m.Else():
            self._read_out(m, core, transmitting)

    def _read_out(self, m, core, unit):
        m.d.comb += [
            core.reads.valid.eq(unit.reads.valid),
            core.reads.payload.eq(unit.reads.payload),
            unit.reads.ready.eq(core.reads.ready),
            unit.waypoints.valid.eq(core.waypoints.valid),
            unit.waypoints.payload.eq(core.waypoints.payload),
            core.waypoints.ready.eq(unit.waypoints.ready),
        ]
