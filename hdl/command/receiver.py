"""Command receiver: takes one request at a time and feeds the core or the checker."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.field_decoder import (
    FieldDecoder,
    payload_commands,
    request_fields,
)
from pathgene.hdl.command.header_comparator import HeaderComparator
from pathgene.hdl.command.layouts import AnswerKind, Request, answer_layout
from pathgene.hdl.command.payload_dispatcher import PayloadDispatcher
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.layouts import (
    cell_layout,
    check_layout,
    point_layout,
    ranking_layout,
    start_layout,
    struct,
    write_layout,
)
from pathgene.hdl.link.frame import body_layout
from pathgene.hdl.planner.layouts import problem_layout, shape_layout
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.runs import guide_request, run_request


__all__ = ["CommandReceiver"]


class CommandReceiver(Unit):
    """Takes requests and checks them by the rules of :mod:`pathgene.hdl.protocol`.

    The receiver reads the header, compares it with the open session and the expected sequence
    number, collects and decodes the fixed fields, and passes the payload to the command's parser.
    It is turned on while a request is pending and takes one byte per cycle; the docstrings of the
    parsers say where ranks, waypoints and cells take longer. It is done at most 6 cycles after the
    last byte, or, after a GENERATE, a MAP or a BLOCK, when the core or the checker is ready again.
    The receiver consumes any request in full and is then done, whatever its contents. ``valid`` of
    every output stream is a register.

    A refused WRITE may have changed the slots that it names, but their lengths stay within the
    limits; a refused MAP of wrong length may have changed cells of its rectangle.

    Source: *allaire-2008*, section 4.3. Differences: sequence numbers, and the order of the slots
    instead of the population itself.

    Members
    -------
    on, done : In(1), Out(1)
        Handshake with the control unit. ``done`` stays high until the receiver is turned off.
    pending : Out(1)
        A request is waiting.
    requests : In(stream of body_layout)
        Bodies of undamaged frames, without CRC.
    answer : Out(answer_layout)
        Answer to the request; steady from ``done`` to the next ``on``.
    session : Out(8)
        The open session.
    line_errors : In(4)
        Pulses from the line: FRAMING, OVERRUN, CRC, MALFORMED of
        :class:`pathgene.hdl.protocol.codes.StickyError`.
    errors : Out(8)
        All sticky errors.

    Only if ``config`` has the paper core:

    generate : Out(1)
        Valid with ``done``: a generation must run before the answer.
    start_requests : Out(stream of seed, x, y, altitude, avoid_ground)
        Seed of the random source, limits of new waypoints.
    writes : Out(stream of slot, index, waypoint, last)
        Waypoints for the current population.
    ranking : Out(stream of rank, slot)
        The slots from the best path to the worst.
    ranked : In(1)
        The core has applied the ranking.

    Only if ``config`` has a checker:

    cells : Out(stream of x, y, altitude, last)
        Cells of the map; see :class:`pathgene.hdl.command.cell_parser.CellParser`.

    Only if it also checks the paths of commands:

    forget : Out(1)
        A check has arrived: points that were passed on before and are not yet checked must be
        discarded.
    points : Out(stream of x, y, altitude, last)
        Points of one path.
    check : Out(1)
        Valid with ``done``: ``checks`` must be executed before the answer.
    checks : Out(check_layout)
        Steady from ``done`` to the next ``on``.
    checked : In(9)
        Paths of the latest check, whose results may be requested.

    Only if ``config`` has the planner core:

    problems : Out(stream of problem_layout)
    runs : Out(stream of run_request)
    shapes : Out(stream of shape_layout)
    guides : Out(stream of guide_request)
        Fields of a PROBLEM, a RUN, a BLOCK and a GUIDE. Ready once the problem or the waypoint is
        taken, the run has begun, or the shape is drawn. The payloads are steady.
    stop : Out(1)
        Pulse: the run must end.
    running : In(1)
        A run is in progress; high from the cycle after its transfer on.
    has_problem, has_population : In(1)
        There is a problem; there is a population for a warm run.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.has_checker = config.checker is not CheckerBuild.NONE
        members = {
            "on": In(1),
            "done": Out(1),
            "pending": Out(1),
            "requests": In(stream.Signature(body_layout)),
            "answer": Out(answer_layout),
            "session": Out(8),
            "line_errors": In(4),
            "errors": Out(8),
        }
        if config.paper_core:
            self.start_layout = start_layout(config)
            self.write_layout = write_layout(
                config.slot_bits, config.index_bits, config.waypoint_bits
            )
            self.ranking_layout = ranking_layout(config.slot_bits)
            members |= {
                "generate": Out(1),
                "start_requests": Out(stream.Signature(self.start_layout)),
                "writes": Out(stream.Signature(self.write_layout)),
                "ranking": Out(stream.Signature(self.ranking_layout)),
                "ranked": In(1),
            }
        if self.has_checker:
            self.cell_layout = cell_layout(config.coordinate_bits, config.altitude_bits)
            members["cells"] = Out(stream.Signature(self.cell_layout))
        if config.checks_paths:
            self.point_layout = point_layout(config.coordinate_bits, config.altitude_bits)
            self.check_layout = check_layout(config.waypoint_bits)
            members |= {
                "forget": Out(1),
                "points": Out(stream.Signature(self.point_layout)),
                "check": Out(1),
                "checks": Out(self.check_layout),
                "checked": In(9),
            }
        if config.planner_core:
            members |= {
                "problems": Out(stream.Signature(problem_layout(config))),
                "runs": Out(stream.Signature(struct(run_request(config)))),
                "shapes": Out(stream.Signature(shape_layout(config.coordinate_bits))),
                "guides": Out(stream.Signature(struct(guide_request(config)))),
                "stop": Out(1),
                "running": In(1),
                "has_problem": In(1),
                "has_population": In(1),
            }
        return members

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.fields = fields = FieldDecoder(
            request_fields(config),
            config.population,
            config.children,
            config.map_size,
            config.altitude_bits,
            config.max_waypoints,
        )
        m.submodules.payload = payload = PayloadDispatcher(config)
        m.submodules.header = header = HeaderComparator()
        request = Request(fields.size)
        expected = Signal(8)  # Number of the next command.
        self._connect(m, request, fields, payload)
        m.d.comb += [
            self.pending.eq(self.requests.valid),
            header.session.eq(self.answer.session),
            header.sequence.eq(self.answer.sequence),
            header.open_session.eq(self.session),
            header.expected.eq(expected),
        ]

        m.d.comb += request.taken.eq(self.requests.valid & self.requests.ready)
        with m.If(request.taken):
            m.d.sync += request.ended.eq(self.requests.p.last)
        with m.If(fields.take):
            m.d.sync += request.left.eq(request.left - 1)

        m.d.sync += [request.refused.eq(0), request.cleared.eq(0)]
        m.d.sync += self.errors.eq(
            Mux(request.cleared, 0, self.errors)
            | self.line_errors
            | Mux(request.refused, StickyError.REFUSED.value, 0)
        )

        if config.checks_paths:
            m.d.sync += self.forget.eq(0)
        if config.planner_core:
            m.d.sync += self.stop.eq(0)

        with m.FSM():
            with m.State("Off"):
                m.d.sync += [request.ended.eq(0), request.repeated.eq(0)]
                if config.paper_core:
                    m.d.sync += self.generate.eq(0)
                if config.checks_paths:
                    m.d.sync += self.check.eq(0)
                with m.If(self.on):
                    m.next = "Session"

            self._take_header(m, request)

            with m.State("Judge header"):
                self._judge_header(m, request, header, expected)

            with m.State("Drain"):
                m.d.comb += self.requests.ready.eq(~request.ended)
                with m.If(request.ended):
                    m.d.sync += self.done.eq(1)
                    m.next = "Done"

            with m.State("Fields"):
                m.d.comb += self.requests.ready.eq(~request.ended)
                with m.If(request.ended):
                    m.d.sync += request.collecting.eq(0)
                    self._refuse(m, request, Status.BAD_LENGTH)
                with m.Elif(fields.take & (request.left == 1)):
                    m.d.sync += request.collecting.eq(0)
                    m.next = "Decode fields"

            # The decoder needs two cycles.
            with m.State("Decode fields"):
                m.next = "Fields decoded"

            with m.State("Fields decoded"):
                m.next = "Judge fields"

            with m.State("Judge fields"):
                self._judge_fields(m, request, fields)
                m.d.comb += payload.launch.eq(fields.status == Status.OK)

            for command, orders in self._orders().items():
                with m.State(command.name.capitalize()):
                    with m.If(orders.ready):
                        m.d.sync += orders.valid.eq(0)
                        m.next = "Executed"

            with m.State("Payload"):
                m.d.comb += self.requests.ready.eq(payload.bytes.ready & ~request.ended)
                m.d.sync += request.verdict.eq(payload.status)
                with m.If(payload.done):
                    m.next = "Judge payload"

            with m.State("Judge payload"):
                with m.If(request.verdict != Status.OK):
                    self._refuse(m, request, request.verdict)
                with m.Else():
                    if config.paper_core:
                        m.d.sync += self.generate.eq(
                            (request.code == Command.GENERATE) & ~request.repeated
                        )
                    if config.checks_paths:
                        with m.If(request.code == Command.CHECK):
                            m.d.sync += self.check.eq(~request.repeated)
                    m.next = "Executed"

            with m.State("Executed"):
                with m.If(~request.repeated):
                    m.d.sync += expected.eq(expected + 1)
                m.d.sync += self.done.eq(1)
                m.next = "Done"

            with m.State("Done"):
                with m.If(~self.on):
                    m.d.sync += self.done.eq(0)
                    m.next = "Off"

        return m

    def _connect(self, m, request, fields, payload):
        """Connect the decoder and the parsers to the request and to the units that they feed."""
        byte = self.requests.p.data
        m.d.comb += [
            fields.byte.eq(byte),
            fields.take.eq(request.collecting & self.requests.valid & ~request.ended),
            fields.code.eq(request.code),
            fields.ended.eq(request.ended),
            payload.bytes.valid.eq(self.requests.valid),
            payload.bytes.payload.eq(byte),
            payload.code.eq(request.code),
            payload.repeated.eq(request.repeated),
            payload.ended.eq(request.ended),
        ]
        if self.config.paper_core:
            connect(m, payload.writes, flipped(self.writes))
            connect(m, payload.ranking, flipped(self.ranking))
            m.d.comb += [
                self.start_requests.p.eq(fields.start),
                payload.write_slot.eq(fields.write_slot),
                payload.identity.eq(fields.identity),
                payload.ranked.eq(self.ranked),
            ]
        if self.has_checker:
            connect(m, payload.cells, flipped(self.cells))
            if self.config.checks_paths:
                connect(m, payload.points, flipped(self.points))
            m.d.comb += payload.rectangle.eq(fields.rectangle)
        if self.config.checks_paths:
            m.d.comb += [self.checks.eq(fields.checks), fields.checked.eq(self.checked)]
        if self.config.planner_core:
            m.d.comb += [
                self.problems.p.eq(fields.problem),
                self.runs.p.eq(fields.run),
                self.shapes.p.eq(fields.shape),
                self.guides.p.eq(fields.guide),
                payload.coded.eq(fields.coded),
                fields.repeated.eq(request.repeated),
                fields.running.eq(self.running),
                fields.has_problem.eq(self.has_problem),
                fields.has_population.eq(self.has_population),
            ]

    def _orders(self):
        """Return the streams that take the fixed fields of a command, by command."""
        if self.config.paper_core:
            return {Command.START: self.start_requests}
        if self.config.planner_core:
            return {
                Command.PROBLEM: self.problems,
                Command.RUN: self.runs,
                Command.BLOCK: self.shapes,
                Command.GUIDE: self.guides,
            }
        return {}

    def _answer_with(self, m, status):
        """Answer only with ``status``."""
        m.d.sync += [self.answer.status.eq(status), self.answer.kind.eq(AnswerKind.EMPTY)]

    def _refuse(self, m, request, status):
        """Refuse the request with ``status`` as the reason."""
        self._answer_with(m, status)
        m.d.sync += request.refused.eq(1)
        m.next = "Drain"

    def _take_header(self, m, request):
        """Add the states that receive the three bytes of the header."""
        byte = self.requests.p.data

        with m.State("Session"):
            m.d.comb += self.requests.ready.eq(1)
            m.d.sync += [
                self.answer.session.eq(byte),
                self.answer.plain.eq(self.requests.p.plain),
                self.answer.kind.eq(AnswerKind.EMPTY),
                self.answer.status.eq(Status.OK),
            ]
            with m.If(request.taken):
                m.next = "Sequence"

        with m.State("Sequence"):
            m.d.comb += self.requests.ready.eq(1)
            m.d.sync += self.answer.sequence.eq(byte)
            with m.If(request.taken):
                m.next = "Code"

        with m.State("Code"):
            m.d.comb += self.requests.ready.eq(1)
            m.d.sync += request.code.eq(byte)
            with m.If(request.taken):
                m.next = "Judge header"

    def _judge_header(self, m, request, header, expected):
        """Answer immediately, or continue with the fixed fields of a command to be executed."""
        code = request.code
        m.next = "Drain"
        with m.If(self.answer.plain):
            m.d.sync += self.answer.kind.eq(
                Mux(code == Command.INFO, AnswerKind.INFO, AnswerKind.SILENCE)
            )
        with m.Elif(code == Command.OPEN):
            with m.If(header.next_session):
                m.d.sync += [self.session.eq(self.answer.session), expected.eq(0)]
            with m.Elif(~header.same_session):
                self._answer_with(m, Status.NO_SESSION)
        with m.Elif(~header.same_session):
            self._answer_with(m, Status.NO_SESSION)
        with m.Elif(header.future):
            self._answer_with(m, Status.OUT_OF_ORDER)
            m.d.sync += self.answer.sequence.eq(expected)
        with m.Elif(~header.present & ~header.previous):
            self._answer_with(m, Status.DUPLICATE)
        with m.Else():
            m.d.sync += request.repeated.eq(header.previous)
            with m.Switch(code):
                for command, layout in request_fields(self.config).items():
                    with m.Case(command):
                        m.d.sync += [
                            request.left.eq(layout.size),
                            request.collecting.eq(layout.size != 0),
                        ]
                        m.next = "Fields" if layout.size else "Decode fields"
                with m.Default():
                    self._refuse(m, request, Status.UNKNOWN_COMMAND)

    def _judge_fields(self, m, request, fields):
        """Refuse the request, execute it, or continue with its payload."""
        config, code, repeated = self.config, request.code, request.repeated
        m.d.sync += [
            self.answer[name].eq(getattr(fields, name)) for name in ("kind", "slot", "count")
        ]
        m.next = "Executed"
        with m.Switch(code):
            with m.Case(*payload_commands(config)):
                m.next = "Payload"
            for command in self._orders():
                with m.Case(command):
                    with m.If(~repeated):
                        m.next = command.name.capitalize()
        if config.checks_paths:
            m.d.sync += self.forget.eq((code == Command.CHECK) | (code == Command.CHECK_PATHS))
            m.d.sync += self.check.eq(
                (code == Command.CHECK_PATHS) & ~repeated & (fields.status == Status.OK)
            )
        with m.If(fields.status != Status.OK):
            self._refuse(m, request, fields.status)
        with m.Elif(code == Command.CLEAR):
            m.d.sync += request.cleared.eq(~repeated)
        for command, orders in self._orders().items():
            with m.Elif(code == command):
                m.d.sync += orders.valid.eq(~repeated)
        if config.planner_core:
            with m.Elif(code == Command.STOP):
                m.d.sync += self.stop.eq(~repeated)
