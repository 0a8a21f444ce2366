"""Bench of the command receiver, which drives it as the control unit does."""

from functools import partial

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.command.receiver import CommandReceiver
from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.messages import map_request, start_request
from tests.support.gateware import refusals
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import collect, put, shared, simulate


CONFIG = TINY
CHECKING = CONFIG.replace(checker=CheckerBuild.PARALLEL)
START = start_request(CONFIG)
MAP = map_request(CONFIG)
LAST = 1 << CONFIG.waypoint_bits
ORDER = [3, 0, 7, 1, 2, 6, 5, 4]
GOOD_START = START.pack(seed=0x0123456789ABCDEF, x=15, y=3, altitude=14, avoid_ground=0)


def start(x, y, altitude, avoid_ground=0):
    return START.pack(seed=0, x=x, y=y, altitude=altitude, avoid_ground=avoid_ground)


def generate(mode, order):
    return bytes((mode, *order))


rectangle = partial(refusals.rectangle, CONFIG)
check = partial(refusals.check, CONFIG)
check_paths = partial(refusals.check_paths, CONFIG)


class Chip:
    """Drives a command receiver as the control unit does, body by body."""

    def __init__(self, pauses=(0,), config=CONFIG):
        self.unit = shared(CommandReceiver, config)
        self.has_map = config.checker is not CheckerBuild.NONE
        self.has_checker = config.checks_paths
        self.has_core = config.paper_core
        self.has_runs = config.planner_core
        self.pauses = pauses
        self.start_requests, self.writes, self.ranking = [], [], []
        self.cells, self.points = [], []
        self.checks = []
        self.problems, self.runs, self.shapes, self.guides = [], [], [], []
        self.running, self.has_problem, self.has_population = 0, 1, 0
        self.stops = 0
        self.forgotten = 0
        self.cycles = 0  # Maximum cycles from a last byte to done.
        self.outcomes, self.recorded = [], []

    def run(self, bodies, line_errors=(), states=None):
        """Take all bodies; ``states`` has ``has_problem`` and ``has_population`` of each."""

        async def bench(ctx):
            unit = self.unit
            if self.has_core:
                ctx.set(unit.ranked, 1)
            if self.has_runs:
                for name in ("running", "has_problem", "has_population"):
                    ctx.set(getattr(unit, name), getattr(self, name))
            for number, (body, plain) in enumerate(bodies):
                for name, value in (states[number] if states else {}).items():
                    ctx.set(getattr(unit, name), value)
                for error in line_errors:
                    ctx.set(unit.line_errors, error)
                    await ctx.tick()
                ctx.set(unit.line_errors, 0)
                await self._body(ctx, body, plain)

        async def count_forgotten(ctx):
            ctx.set(self.unit.checked, 5)
            while True:
                _, _, forget = await ctx.tick().sample(self.unit.forget)
                self.forgotten += forget

        async def count_stops(ctx):
            while True:
                _, _, stop = await ctx.tick().sample(self.unit.stop)
                self.stops += stop

        collectors = []
        if self.has_core:
            collectors += [
                collect(self.unit.start_requests, self.start_requests, self.pauses),
                collect(self.unit.writes, self.writes, self.pauses),
                collect(self.unit.ranking, self.ranking, self.pauses),
            ]
        if self.has_map:
            collectors += [collect(self.unit.cells, self.cells, self.pauses)]
        if self.has_checker:
            collectors += [collect(self.unit.points, self.points, self.pauses), count_forgotten]
        if self.has_runs:
            collectors += [
                collect(self.unit.problems, self.problems, self.pauses),
                collect(self.unit.runs, self.runs, self.pauses),
                collect(self.unit.shapes, self.shapes, self.pauses),
                collect(self.unit.guides, self.guides, self.pauses),
                count_stops,
            ]
        simulate(self.unit, bench, background=collectors)
        return self.outcomes

    async def _body(self, ctx, body, plain):
        unit = self.unit
        assert not ctx.get(unit.pending)
        ctx.set(unit.requests.payload, {"data": body[0], "last": len(body) == 1, "plain": plain})
        ctx.set(unit.requests.valid, 1)
        await ctx.tick()
        assert ctx.get(unit.pending)
        ctx.set(unit.on, 1)
        for at, byte in enumerate(body):
            last = at == len(body) - 1
            await put(ctx, unit.requests, {"data": byte, "last": last, "plain": plain}, limit=100)
        cycles = 0
        while not ctx.get(unit.done):
            await ctx.tick()
            cycles += 1
            assert cycles < 100
        self.cycles = max(self.cycles, cycles + 1)
        generates = ctx.get(unit.generate) if self.has_core else 0
        if self.has_checker:
            checks = ctx.get(unit.checks)
            self.checks.append({name: checks[name] for name, _ in checks.shape()})
            self.checks[-1]["check"] = ctx.get(unit.check)
        ctx.set(unit.on, 0)
        await ctx.tick().repeat(2)
        assert not ctx.get(unit.done)
        answer = ctx.get(unit.answer)
        self.outcomes.append((Status(answer.status), answer.kind, answer.sequence, generates))
        if self.has_checker:
            checks = ctx.get(unit.checks)  # Steady.
            assert {name: checks[name] for name, _ in checks.shape()}.items() <= self.checks[
                -1
            ].items()
        self.answer, self.errors, self.session = (
            answer,
            StickyError(ctx.get(unit.errors)),
            ctx.get(unit.session),
        )
        self.recorded.append(self.errors)


def after_open(*commands):
    """Return bodies that open session 1, then ``(code, payload)`` numbered from 0."""
    bodies = [(bytes((1, 9, Command.OPEN)), 0)]
    for sequence, (code, payload) in enumerate(commands):
        bodies.append((bytes((1, sequence, code)) + payload, 0))
    return bodies


def refuse(config, rows):
    """Send refused requests to one receiver; return its bench.

    A refusal is answered and recorded, and uses no sequence number. STATUS shows this, and CLEAR
    clears the record for the next.
    """
    chip, bodies, expected = Chip(config=config), [(bytes((1, 9, Command.OPEN)), 0)], []
    for number, (code, payload, status) in enumerate(rows):
        first, second = 2 * number, 2 * number + 1
        bodies.append((bytes((1, first, code)) + payload, 0))
        bodies.append((bytes((1, first, Command.STATUS)), 0))
        bodies.append((bytes((1, second, Command.CLEAR)), 0))
        expected += [
            ((status, AnswerKind.EMPTY, first, 0), StickyError.REFUSED),
            ((Status.OK, AnswerKind.STATUS, first, 0), StickyError.REFUSED),
            ((Status.OK, AnswerKind.EMPTY, second, 0), StickyError(0)),
        ]
    chip.run(bodies)
    found = list(zip(chip.outcomes, chip.recorded, strict=True))[1:]
    for number, row in enumerate(rows):
        here = slice(3 * number, 3 * number + 3)
        assert found[here] == expected[here], row
    return chip
