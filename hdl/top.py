"""The whole chip: line, receiving and transmitting units, genetic core or checker, or both."""

from amaranth import *
from amaranth.lib.wiring import In, Out, connect

from pathgene.hdl.command.receiver import CommandReceiver
from pathgene.hdl.command.transmitter import ReplyTransmitter
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.control import Control
from pathgene.hdl.feasibility.check_controller import CheckController
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.ga_core.core import PaperCore
from pathgene.hdl.link.line import Line
from pathgene.hdl.planner.core import PlannerCore
from pathgene.hdl.primitives.buffers import SkidBuffer, StreamRegister
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.codes import Counter


__all__ = ["Chip"]


class Chip(Unit):
    """The chip with its line to the host; :mod:`pathgene.hdl.protocol` defines its answers.

    Source: *allaire-2008*, figure 6; if ``config`` has a checker, with the processor of *allaire
    two-tier* next to the core. The core passes its paths to the checker, and asks it for the ground
    under new waypoints. If ``config`` has no genetic core, the chip only has the checker. The
    planner core contains the map and plans on its own:
    :class:`pathgene.hdl.planner.core.PlannerCore`.

    Members
    -------
    clk, rst : In(1)
        Clock, and reset, which takes effect one to three cycles later, for at least four cycles.
    rx, tx : In(1), Out(1)
        UART pins, 8N1, ``config.clocks_per_bit`` cycles per bit; high when idle.
    rx_data, rx_valid, rx_ready : In(8), In(1), Out(1)
        Bytes from the host at a byte-wide port, which replaces the UART if
        ``config.clocks_per_bit`` is 0: a byte is taken in each cycle in which ``rx_valid`` and
        ``rx_ready`` are high.
    tx_data, tx_valid, tx_ready : Out(8), Out(1), In(1)
        Bytes for the host at a byte-wide port, in the same way.
    """

    config: InstanceOf(Config)

    def interface(self):
        if self.config.has_uart:
            line = {"rx": In(1, init=1), "tx": Out(1, init=1)}
        else:
            line = {
                "rx_data": In(8),
                "rx_valid": In(1),
                "rx_ready": Out(1),
                "tx_data": Out(8),
                "tx_valid": Out(1),
                "tx_ready": In(1),
            }
        return {"clk": In(1), "rst": In(1), **line}

    def elaborate(self, platform):
        m = Module()

        # One register cannot reset a whole large chip in one cycle, so the reset passes from part
        # to part, through one register each. It lasts until all parts are in reset at the same
        # time.
        m.domains.unreset = ClockDomain(reset_less=True)
        m.d.comb += ClockSignal("unreset").eq(self.clk)
        lasting = Signal(3)
        reset = Signal()
        m.d.comb += reset.eq(self.rst | lasting.any())
        m.d.unreset += lasting.eq(Cat(self.rst, lasting))
        domains = ("sync", "core") if self.config.planner_core else ("sync", "core", "checker")
        for domain in domains:
            setattr(m.domains, domain, ClockDomain(domain))
            m.d.comb += ClockSignal(domain).eq(self.clk)
            m.d.unreset += ResetSignal(domain).eq(reset)
            if self.config.paper_core or self.config.planner_core:
                reset = ResetSignal(domain)

        m.submodules.line = line = Line(self.config.clocks_per_bit, self.config.receive_buffer)
        m.submodules.receiver = receiver = CommandReceiver(self.config)
        m.submodules.transmitter = transmitter = ReplyTransmitter(self.config)
        control = Control(self.config)
        m.submodules.control = DomainRenamer("core")(control)

        if self.config.has_uart:
            m.d.comb += [line.rx.eq(self.rx), self.tx.eq(line.tx)]
        else:
            m.d.comb += [
                line.received.payload.eq(self.rx_data),
                line.received.valid.eq(self.rx_valid),
                self.rx_ready.eq(line.received.ready),
                self.tx_data.eq(line.sent.payload),
                self.tx_valid.eq(line.sent.valid),
                line.sent.ready.eq(self.tx_ready),
            ]
        connect(m, line.requests, receiver.requests)
        if self.config.planner_core:
            # On a large chip, the transmitter may be far from the line.
            m.submodules.replies = replies = StreamRegister(transmitter.replies.payload.shape())
            connect(m, transmitter.replies, replies.words)
            connect(m, replies.passed, line.replies)
        else:
            connect(m, transmitter.replies, line.replies)
        m.d.comb += [
            control.line_busy.eq(line.busy),
            control.line_sending.eq(line.sending),
            control.pending.eq(receiver.pending),
            receiver.on.eq(control.receive_on),
            control.receive_done.eq(receiver.done),
            transmitter.on.eq(control.transmit_on),
            control.transmit_done.eq(transmitter.done),
        ]

        core = None
        if self.config.paper_core:
            core = self._add_core(m, control, receiver, transmitter)
        if self.config.planner_core:
            self._add_planner_core(m, control, receiver, transmitter)
        elif self.config.checker is not CheckerBuild.NONE:
            self._add_checker(m, control, core, receiver, transmitter)
        elif core is not None:
            connect(m, transmitter.reads, core.reads)
            connect(m, core.waypoints, transmitter.waypoints)

        # Registers that appear in replies.
        m.d.comb += [
            receiver.line_errors.eq(line.errors),
            transmitter.answer.eq(receiver.answer),
            transmitter.session.eq(receiver.session),
            transmitter.status.state.eq(control.state),
            transmitter.status.history.eq(control.history),
            transmitter.status.errors.eq(receiver.errors),
            transmitter.counters[Counter.BYTES_RECEIVED].eq(line.bytes_received),
            transmitter.counters[Counter.BYTES_SENT].eq(line.bytes_sent),
        ]
        for counter, _ in control.counters.shape():
            m.d.comb += transmitter.counters[counter].eq(control.counters[counter])

        return m

    def _add_core(self, m, control, receiver, transmitter):
        """Add the paper core, and return it; the reader of its paths is connected later."""
        core = PaperCore(self.config)
        m.submodules.core = DomainRenamer("core")(core)

        connect(m, control.core, core.control)
        connect(m, receiver.start_requests, core.start_requests)
        connect(m, receiver.writes, core.writes)
        connect(m, receiver.ranking, core.ranking)
        m.d.comb += [
            receiver.ranked.eq(core.control.ready),
            control.generate.eq(receiver.generate),
            transmitter.status.generation.eq(control.generation),
        ]
        for unit, _ in control.cycles.shape():
            m.d.comb += transmitter.status[unit].eq(control.cycles[unit])

        recipe = transmitter.recipe
        for i, slot in enumerate(core.parents):
            m.d.comb += recipe[f"parent_{i}"].eq(slot)
        for i, slot in enumerate(core.survivors):
            m.d.comb += [
                recipe[f"survivor_{i}"].eq(slot),
                transmitter.survivors[i].eq(slot),
            ]
        for i, mutation in enumerate(core.mutations):
            m.d.comb += [
                recipe[f"applied_{i}"].eq(mutation.applied),
                recipe[f"child_{i}"].eq(mutation.child),
                recipe[f"index_{i}"].eq(mutation.index),
            ]
        for i, waypoint in enumerate(core.patches):
            m.d.comb += recipe[f"waypoint_{i}"].eq(waypoint)
        return core

    def _add_planner_core(self, m, control, receiver, transmitter):
        """Add the planner core, which also contains the map."""
        core = PlannerCore(self.config)
        m.submodules.core = DomainRenamer("core")(core)

        # On a large chip, the map's `ready` arrives late.
        m.submodules.cells = cells = SkidBuffer(receiver.cells.payload.shape())
        connect(m, receiver.cells, cells.words)
        connect(m, cells.passed, core.cells)
        connect(m, receiver.problems, core.problems)
        connect(m, receiver.runs, core.runs)
        connect(m, receiver.shapes, core.shapes)
        connect(m, receiver.guides, core.guides)
        connect(m, core.records, transmitter.records)
        m.d.comb += [
            core.stop.eq(receiver.stop),
            core.best.eq(transmitter.best),
            receiver.running.eq(core.running),
            receiver.has_problem.eq(core.has_problem),
            receiver.has_population.eq(core.has_population),
            transmitter.has_best.eq(core.has_best),
            control.bred.eq(core.bred),
        ]
        for name in core.status.shape().members:
            m.d.comb += transmitter.status[name].eq(core.status[name])

    def _add_checker(self, m, control, core, receiver, transmitter):
        """Add the checker, between the units that take commands and answer them."""
        checker = Checker(self.config)
        m.submodules.checker = DomainRenamer("checker")(checker)
        m.submodules.check_controller = checks = CheckController(self.config)

        if core is not None:
            self._share_core(m, control, core, checker, checks, transmitter)
            # On a large chip, the checker's `ready` arrives late.
            m.submodules.cells = cells = SkidBuffer(receiver.cells.payload.shape())
            connect(m, receiver.cells, cells.words)
            connect(m, cells.passed, checker.writes)
        else:
            connect(m, receiver.cells, checker.writes)
        connect(m, receiver.points, checks.points)
        connect(m, checks.paths, checker.points)
        connect(m, checker.verdicts, checks.verdicts)
        connect(m, checker.counts, checks.counts)
        connect(m, transmitter.result_reads, checks.result_reads)
        connect(m, checks.records, transmitter.records)
        m.d.comb += [
            control.check.eq(receiver.check),
            checks.on.eq(control.check_on),
            control.check_done.eq(checks.done),
            checks.forget.eq(receiver.forget),
            checks.checks.eq(receiver.checks),
            checker.count.eq(checks.counting),
            receiver.checked.eq(checks.checked),
            transmitter.checked.eq(checks.checked),
            transmitter.totals.eq(checks.totals),
        ]
        for counter, _ in checks.counters.shape():
            m.d.comb += transmitter.counters[counter].eq(checks.counters[counter])

    def _share_core(self, m, control, core, checker, checks, transmitter):
        """Connect the core's look-ups of the ground to the checker, and share its reads."""
        m.d.comb += [
            checker.lookup_valid.eq(core.lookup_valid),
            checker.lookup_x.eq(core.lookup_x),
            checker.lookup_y.eq(core.lookup_y),
            core.lookup_altitude.eq(checker.lookup_altitude),
        ]
        # Only the unit that is on reads paths.
        with m.If(control.check_on):
            self._read_paths(m, core, checks)
        with m.Else():
            self._read_paths(m, core, transmitter)

    def _read_paths(self, m, core, unit):
        m.d.comb += [
            core.reads.valid.eq(unit.reads.valid),
            core.reads.payload.eq(unit.reads.payload),
            unit.reads.ready.eq(core.reads.ready),
            unit.waypoints.valid.eq(core.waypoints.valid),
            unit.waypoints.payload.eq(core.waypoints.payload),
            core.waypoints.ready.eq(unit.waypoints.ready),
        ]
