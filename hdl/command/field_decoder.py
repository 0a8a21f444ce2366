"""Decoder of a request's fixed fields."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.layouts import check_layout, struct
from pathgene.hdl.primitives.unit import Count, Given, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.codes import CheckFlag, Command, LinkMode, Status
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import (
    CODED_COLUMNS,
    check_paths_request,
    check_request,
    coded_map_request,
    map_request,
    read_request,
    results_request,
    start_request,
    write_request,
)
from pathgene.hdl.protocol.planner import (
    BLOCKS,
    COARSE_BLOCKS,
    SCALE_FRACTION,
    no_fly_request,
    problem_request,
)
from pathgene.hdl.protocol.runs import ISLANDS, LIFTS, RETURNED, guide_request, run_request


__all__ = ["FieldDecoder", "payload_commands", "request_fields"]


#: Commands with a payload after the fixed fields; all other commands end with the fixed fields.
FOLLOWED = (
    Command.WRITE,
    Command.GENERATE,
    Command.MAP,
    Command.CHECK,
    Command.CODED_MAP,
)
#: Commands that are refused during a run, except for a repeated RUN.
_WAITING = (
    Command.MAP,
    Command.PROBLEM,
    Command.RUN,
    Command.BEST,
    Command.BLOCK,
    Command.GUIDE,
    Command.CODED_MAP,
)
#: Maximum share of time with two islands in a RUN, in sixteenths.
_MOST_SHARE = 16


def request_fields(config: Config) -> dict[Command, Layout]:
    """Return the fixed fields of every numbered request of the chip, by command."""
    fields = {
        Command.STATUS: Layout(()),
        Command.COUNTERS: Layout(()),
        Command.CLEAR: Layout(()),
    }
    if config.paper_core:
        fields |= {
            Command.START: start_request(config),
            Command.WRITE: write_request(config),
            # The fields of a GENERATE that all modes have.
            Command.GENERATE: Layout((("mode", 8),)),
            Command.READ: read_request(config),
        }
    if config.checker is not CheckerBuild.NONE:
        fields[Command.MAP] = map_request(config)
    if config.checks_paths:
        fields |= {
            Command.CHECK: check_request(config),
            Command.RESULTS: results_request(config),
        }
    if config.paper_core and config.checks_paths:
        fields[Command.CHECK_PATHS] = check_paths_request(config)
    if config.planner_core:
        fields |= {
            Command.PROBLEM: problem_request(config),
            Command.RUN: run_request(config),
            Command.STOP: Layout(()),
            Command.BEST: Layout(()),
            Command.BLOCK: no_fly_request(config),
            Command.GUIDE: guide_request(config),
            Command.CODED_MAP: coded_map_request(config),
        }
    return fields


def payload_commands(config: Config) -> list[Command]:
    """Return the commands of the chip that have a payload after the fixed fields."""
    return [command for command in FOLLOWED if command in request_fields(config)]


class FieldDecoder(Unit):
    """Decodes and checks the fixed fields of a request.

    ``status`` follows its inputs 2 cycles later, ``checks`` 1 cycle later; all other outputs are
    combinational.

    Members
    -------
    code : In(8)
        One of the commands in ``fields``.
    byte, take : In(8), In(1)
        A byte of the fields, taken in cycles in which ``take`` is high.
    ended : In(1)
        The last byte of the request has been taken.
    status : Out(8)
        :class:`pathgene.hdl.protocol.codes.Status`: OK, or the error of the fields.
    kind, slot, count : Out(AnswerKind), Out(8), Out(9)
        Answer to the request if its payload is valid: see
        :data:`pathgene.hdl.command.layouts.answer_layout`.

    Only with a START among ``fields``:

    start : Out(struct of start_request)
        Fields of a START.
    write_slot : Out(8)
        Slot of a WRITE.
    identity : Out(1)
        A GENERATE does not carry an order of the slots.

    Only with a MAP among ``fields``:

    rectangle : Out(struct of map_request)
        Fields of a MAP.

    Only with a CHECK among ``fields``:

    checks : Out(check_layout)
        Check requested by a CHECK or CHECK_PATHS.
    checked : In(9)
        Paths of the latest check, whose results may be requested.

    Only with a RUN among ``fields``:

    problem : Out(struct of problem_request)
    run : Out(struct of run_request)
    shape : Out(struct of no_fly_request)
    guide : Out(struct of guide_request)
    coded : Out(struct of coded_map_request)
        Fields of a PROBLEM, a RUN, a BLOCK, a GUIDE and a CODED_MAP.
    repeated : In(1)
        The command has been executed before: the next three members do not affect a RUN.
    running : In(1)
        A run is in progress, whose end the commands of the planner core except STOP must await.
    has_problem, has_population : In(1)
        There is a problem; there is a population for a warm run.
    """

    fields: Given(
        "dict of Command to Layout",
        "Fixed fields of each numbered request of the chip: see :func:`request_fields`.",
    )
    population: Count(2, 256, "Slots.")
    children: Count(1, "population - 1", "Paths made each generation, in the last slots.")
    map_size: PowerOfTwo(2, 1 << 16, "Cells along each edge of the map.")
    altitude_bits: Width(1, 16, "A new waypoint is always below the top altitude.")
    max_waypoints: Count(2, 255, "Waypoints of the longest path.")

    def interface(self):
        self.size = max(layout.size for layout in self.fields.values())
        # The bytes of the fields, with the last byte highest.
        self._packed = Signal(8 * self.size)
        members = {
            "code": In(8),
            "byte": In(8),
            "take": In(1),
            "ended": In(1),
            "status": Out(8),
            "kind": Out(AnswerKind),
            "slot": Out(8),
            "count": Out(9),
        }
        if Command.START in self.fields:
            members |= {
                "start": Out(struct(self.fields[Command.START])),
                "write_slot": Out(8),
                "identity": Out(1),
            }
        if Command.MAP in self.fields:
            members["rectangle"] = Out(struct(self.fields[Command.MAP]))
        if Command.CHECK in self.fields:
            waypoint_bits = 2 * exact_log2(self.map_size) + self.altitude_bits
            members |= {"checks": Out(check_layout(waypoint_bits)), "checked": In(9)}
        if Command.RUN in self.fields:
            members |= {
                "problem": Out(struct(self.fields[Command.PROBLEM])),
                "run": Out(struct(self.fields[Command.RUN])),
                "shape": Out(struct(self.fields[Command.BLOCK])),
                "guide": Out(struct(self.fields[Command.GUIDE])),
                "coded": Out(struct(self.fields[Command.CODED_MAP])),
                "repeated": In(1),
                "running": In(1),
                "has_problem": In(1),
                "has_population": In(1),
            }
        return members

    def elaborate(self, platform):
        m = Module()

        with m.If(self.take):
            m.d.sync += self._packed.eq(Cat(self._packed[8:], self.byte))

        m.d.comb += self.kind.eq(AnswerKind.EMPTY)
        if Command.START in self.fields:
            m.d.comb += [
                self.start.eq(self._of(Command.START)),
                self.write_slot.eq(self._of(Command.WRITE).slot),
                self.identity.eq(self._of(Command.GENERATE).mode == LinkMode.POPULATION),
            ]
        if Command.MAP in self.fields:
            m.d.comb += self.rectangle.eq(self._of(Command.MAP))
        if Command.CHECK in self.fields:
            m.d.sync += [
                self.checks.batch.eq(0),
                self.checks.counting.eq(self._of(Command.CHECK).flags & CheckFlag.COUNT.value),
            ]
        if Command.CHECK_PATHS in self.fields:
            batch = self._of(Command.CHECK_PATHS)
            with m.If(self.code == Command.CHECK_PATHS):
                m.d.sync += [
                    self.checks.batch.eq(1),
                    self.checks.counting.eq(batch.flags & CheckFlag.COUNT.value),
                ]
            m.d.sync += [
                self.checks[name].eq(batch[name]) for name in ("slot", "count", "start", "goal")
            ]
        if Command.RUN in self.fields:
            m.d.comb += [
                self.problem.eq(self._of(Command.PROBLEM)),
                self.run.eq(self._of(Command.RUN)),
                self.shape.eq(self._of(Command.BLOCK)),
                self.guide.eq(self._of(Command.GUIDE)),
                self.coded.eq(self._of(Command.CODED_MAP)),
            ]

        judges = {
            Command.STATUS: self._judge_status,
            Command.START: self._judge_start,
            Command.GENERATE: self._judge_generate,
            Command.READ: self._judge_read,
            Command.COUNTERS: self._judge_counters,
            Command.MAP: self._judge_map,
            Command.CHECK: self._judge_check,
            Command.CHECK_PATHS: self._judge_check_paths,
            Command.RESULTS: self._judge_results,
            Command.PROBLEM: self._judge_problem,
            Command.RUN: self._judge_run,
            Command.BEST: self._judge_best,
            Command.BLOCK: self._judge_block,
            Command.GUIDE: lambda m: self.guide.index >= self.max_waypoints,
            Command.CODED_MAP: self._judge_coded_map,
        }
        # The fields are checked for every command; the code selects the verdict in the next cycle.
        wrong = {command: Signal(name=f"{command.name.lower()}_wrong") for command in judges}
        followed = Signal()
        m.d.sync += [self.status.eq(Status.OK), followed.eq(0)]
        with m.Switch(self.code):
            with m.Case(*FOLLOWED):
                m.d.sync += followed.eq(1)
        with m.Switch(self.code):
            for command in self.fields:
                with m.Case(command):
                    if command in judges:
                        m.d.sync += wrong[command].eq(judges[command](m))
                        with m.If(wrong[command]):
                            m.d.sync += self.status.eq(Status.BAD_VALUE)
        if Command.RUN in self.fields:
            self._refuse_in_a_run(m)
        with m.If(~self.ended & ~followed):
            m.d.sync += self.status.eq(Status.BAD_LENGTH)

        return m

    def _of(self, command):
        layout = self.fields[command]
        start = 8 * (self.size - layout.size)
        return data.View(struct(layout), self._packed[start : start + layout.bits])

    def _refuse_in_a_run(self, m):
        busy = Signal()
        m.d.sync += busy.eq(0)
        with m.Switch(self.code):
            with m.Case(*_WAITING):
                m.d.sync += busy.eq(self.running & ~((self.code == Command.RUN) & self.repeated))
        with m.If(busy):
            m.d.sync += self.status.eq(Status.BUSY)

    # Each method sets the answer and returns the condition that a value is out of range.

    def _judge_status(self, m):
        m.d.comb += self.kind.eq(AnswerKind.STATUS)
        return 0

    def _judge_counters(self, m):
        m.d.comb += self.kind.eq(AnswerKind.COUNTERS)
        return 0

    def _judge_start(self, m):
        return (
            (self.start.x >= self.map_size)
            | (self.start.y >= self.map_size)
            | (self.start.altitude >= (1 << self.altitude_bits) - 1)
            | (self.start.avoid_ground & (Command.MAP not in self.fields))
        )

    def _judge_read(self, m):
        asked = self._of(Command.READ)
        m.d.comb += [
            self.kind.eq(AnswerKind.PATHS),
            self.slot.eq(asked.slot),
            self.count.eq(asked.count),
        ]
        return self._no_slots(asked)

    def _no_slots(self, asked):
        return (asked.count == 0) | (asked.slot + asked.count > self.population)

    def _judge_generate(self, m):
        wrong = Signal(name="bad_mode")
        with m.Switch(self._of(Command.GENERATE).mode):
            with m.Case(LinkMode.POPULATION):
                m.d.comb += [
                    self.kind.eq(AnswerKind.PATHS),
                    self.count.eq(self.population),
                ]
            with m.Case(LinkMode.RANK):
                m.d.comb += [
                    self.kind.eq(AnswerKind.CHILDREN),
                    self.slot.eq(self.population - self.children),
                    self.count.eq(self.children),
                ]
            with m.Case(LinkMode.RECIPE):
                m.d.comb += self.kind.eq(AnswerKind.RECIPE)
            with m.Default():
                m.d.comb += wrong.eq(1)
        return wrong

    def _judge_coded_map(self, m):
        return (
            self._is_off_map(self.coded)
            | (self.coded.width > CODED_COLUMNS)
            | (self.coded.remainder_bits >= self.altitude_bits)
        )

    def _judge_map(self, m):
        return self._is_off_map(self.rectangle)

    def _is_off_map(self, rectangle):
        edge = self.map_size
        return (
            (rectangle.width == 0)
            | (rectangle.height == 0)
            | (rectangle.x + rectangle.width > edge)
            | (rectangle.y + rectangle.height > edge)
        )

    def _judge_check(self, m):
        return self._judge_flags(m, self._of(Command.CHECK).flags)

    def _judge_check_paths(self, m):
        asked = self._of(Command.CHECK_PATHS)
        return self._judge_flags(m, asked.flags) | self._no_slots(asked)

    def _judge_flags(self, m, flags):
        brief = flags & CheckFlag.BRIEF.value
        m.d.comb += self.kind.eq(Mux(brief, AnswerKind.TOTALS, AnswerKind.CHECKED))
        return flags >= 1 << len(CheckFlag)

    def _judge_results(self, m):
        asked = self._of(Command.RESULTS)
        m.d.comb += [
            self.kind.eq(AnswerKind.RESULTS),
            self.slot.eq(asked.path),
            self.count.eq(asked.count),
        ]
        return (asked.count == 0) | (asked.path + asked.count > self.checked)

    def _judge_problem(self, m):
        problem = self.problem
        # Maximum block size, with which 32 blocks along an edge cover the map.
        most_shift = max(exact_log2(self.map_size) - exact_log2(COARSE_BLOCKS), 0)
        shift = problem.block_shift[: most_shift.bit_length()]
        last_block = (problem.x_limit | problem.y_limit) >> shift
        return (
            (problem.altitude_limit == (1 << self.altitude_bits) - 1)
            | (problem.x_scale > 1 << SCALE_FRACTION)
            | (problem.y_scale > 1 << SCALE_FRACTION)
            | (problem.block_shift > most_shift)
            | (last_block >= BLOCKS)
        )

    def _judge_run(self, m):
        run = self.run
        return (
            (~self.repeated & (~self.has_problem | (run.warm & ~self.has_population)))
            | (run.give_up_rank >= self.population)
            | (run.seeds < self.population)
            | (run.lifts > LIFTS)
            | (run.paths == 0)
            | (run.paths > RETURNED)
            | (run.share > _MOST_SHARE)
            | (run.islands + run.warm == 0)
            | (run.islands + run.warm > ISLANDS)
            | (run.guided > self.max_waypoints)
            | (run.guided == Config.MIN_WAYPOINTS - 1)
            | (run.guided.any() & (run.islands == 0))
        )

    def _judge_best(self, m):
        m.d.comb += self.kind.eq(AnswerKind.BEST)
        return 0

    def _judge_block(self, m):
        shape = self.shape
        return (shape.first_x > shape.last_x) | (shape.first_y > shape.last_y)
