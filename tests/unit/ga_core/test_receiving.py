# amaranth: UnusedElaboratable=no
"""The receiving unit: what it makes of every command, whole or broken."""

import pytest

from hdl.commands.layouts import AnswerKind
from hdl.config import CheckerBuild, Config
from hdl.ga_core.receiving import ReceivingUnit
from hdl.protocol import (
    CheckFlag,
    Command,
    LinkMode,
    Status,
    StickyError,
    check_paths_request,
    generate_request,
    map_request,
    pack_cells,
    pack_paths,
    read_request,
    results_request,
    start_request,
)
from tests.streams import collect, put, simulate


CONFIG = Config(
    population=8,
    children=4,
    survivors=2,
    inserts=1,
    deletes=1,
    max_waypoints=4,
    map_size=16,
    coarse_factor=4,
    altitude_bits=4,
    checker=CheckerBuild.NONE,
)
CHECKING = CONFIG.replace(checker=CheckerBuild.PARALLEL)
START = start_request(CONFIG)
LAST = 1 << CONFIG.waypoint_bits
ORDER = [3, 0, 7, 1, 2, 6, 5, 4]
GOOD_START = START.pack(seed=0x0123456789ABCDEF, x=15, y=3, altitude=14, avoid_ground=0)


def start(x, y, altitude, avoid_ground=0):
    return START.pack(seed=0, x=x, y=y, altitude=altitude, avoid_ground=avoid_ground)


def generate(mode, order):
    return bytes((mode, *order))


class Chip:
    """Drives a receiving unit as the control unit does, one body after the other."""

    def __init__(self, pauses=(0,), config=CONFIG):
        self.unit = ReceivingUnit(config)
        self.has_checker = config.checker is not CheckerBuild.NONE
        self.pauses = pauses
        self.starts, self.writes, self.ranking = [], [], []
        self.cells, self.points = [], []
        self.checks = []
        self.forgotten = 0
        self.clocks = 0  # Most of them from a last byte to the end.
        self.outcomes = []

    def run(self, bodies, line_errors=()):
        async def bench(ctx):
            unit = self.unit
            ctx.set(unit.ranked, 1)
            for body, plain in bodies:
                for error in line_errors:
                    ctx.set(unit.line_errors, error)
                    await ctx.tick()
                ctx.set(unit.line_errors, 0)
                await self._body(ctx, body, plain)

        async def collect_starts(ctx):
            await collect(ctx, self.unit.starts, self.starts, self.pauses)

        async def collect_writes(ctx):
            await collect(ctx, self.unit.writes, self.writes, self.pauses)

        async def collect_ranking(ctx):
            await collect(ctx, self.unit.ranking, self.ranking, self.pauses)

        async def collect_cells(ctx):
            await collect(ctx, self.unit.cells, self.cells, self.pauses)

        async def collect_points(ctx):
            await collect(ctx, self.unit.points, self.points, self.pauses)

        async def count_forgotten(ctx):
            ctx.set(self.unit.checked, 5)
            while True:
                _, _, forget = await ctx.tick().sample(self.unit.forget)
                self.forgotten += forget

        collectors = [collect_starts, collect_writes, collect_ranking]
        if self.has_checker:
            collectors += [collect_cells, collect_points, count_forgotten]
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
        clocks = 0
        while not ctx.get(unit.over):
            await ctx.tick()
            clocks += 1
            assert clocks < 100
        self.clocks = max(self.clocks, clocks + 1)
        generates = ctx.get(unit.generate)
        if self.has_checker:
            checks = ctx.get(unit.checks)
            self.checks.append({name: checks[name] for name, _ in checks.shape()})
            self.checks[-1]["check"] = ctx.get(unit.check)
        ctx.set(unit.on, 0)
        await ctx.tick().repeat(2)
        assert not ctx.get(unit.over)
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


def after_open(*commands):
    """Bodies that open session 1, then ``(code, payload)`` numbered from 0."""
    bodies = [(bytes((1, 9, Command.OPEN)), 0)]
    for sequence, (code, payload) in enumerate(commands):
        bodies.append((bytes((1, sequence, code)) + payload, 0))
    return bodies


@pytest.mark.parametrize("pauses", [(0,), (0, 3, 1)], ids=["steady", "stalled"])
def test_every_command(pauses):
    chip = Chip(pauses)
    paths = [[1, 2, 3], [4, 5], [6, 7, 8, 9]]
    outcomes = chip.run(
        [
            (bytes((77, 5, Command.INFO)), 1),
            *after_open(
                (Command.START, GOOD_START),
                (Command.WRITE, b"\5" + pack_paths(CONFIG, paths)),
                (Command.GENERATE, generate(LinkMode.RANK, ORDER)),
                (Command.GENERATE, generate(LinkMode.RECIPE, ORDER[::-1])),
                (Command.GENERATE, generate(LinkMode.POPULATION, [])),
                (Command.READ, read_request(CONFIG).pack(slot=3, count=5)),
                (Command.STATUS, b""),
                (Command.COUNTERS, b""),
                (Command.CLEAR, b""),
            ),
        ]
    )
    assert outcomes == [
        (Status.OK, AnswerKind.INFO, 5, 0),
        (Status.OK, AnswerKind.EMPTY, 9, 0),
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.EMPTY, 1, 0),
        (Status.OK, AnswerKind.CHILDREN, 2, 1),
        (Status.OK, AnswerKind.RECIPE, 3, 1),
        (Status.OK, AnswerKind.PATHS, 4, 1),
        (Status.OK, AnswerKind.PATHS, 5, 0),
        (Status.OK, AnswerKind.STATUS, 6, 0),
        (Status.OK, AnswerKind.COUNTERS, 7, 0),
        (Status.OK, AnswerKind.EMPTY, 8, 0),
    ]
    (start,) = chip.starts
    assert (start.seed, start.x, start.y, start.altitude) == (0x0123456789ABCDEF, 15, 3, 14)
    stored = [(w.slot, w.index, w.waypoint, w.last) for w in chip.writes]
    assert stored == [
        (5 + number, index, waypoint, index == len(path) - 1)
        for number, path in enumerate(paths)
        for index, waypoint in enumerate(path)
    ]
    orders = [*ORDER, *ORDER[::-1], *range(8)]
    assert [(r.rank, r.slot) for r in chip.ranking] == [
        (at % 8, slot) for at, slot in enumerate(orders)
    ]
    assert (chip.session, chip.errors) == (1, StickyError(0))


def test_clocks():
    """At most 5 from the last byte on, whether refused or executed."""
    chip = Chip(config=CHECKING)
    chip.run(
        after_open(
            (Command.STATUS, b""),
            (Command.STATUS, b"x"),
            (Command.WRITE, b"\5" + pack_paths(CONFIG, [[1, 2, 3]])),
            (Command.READ, read_request(CONFIG).pack(slot=3, count=5)),
            (Command.READ, read_request(CONFIG).pack(slot=3, count=6)),
            (Command.CHECK, check(0, [1, 2, 3])),
            (Command.CHECK_PATHS, check_paths(2, 6, 0)),
            (Command.GENERATE, generate(LinkMode.RANK, ORDER[:-1])),
        )
    )
    assert chip.clocks == 5


@pytest.mark.parametrize(
    ("code", "payload", "status"),
    [
        (0, b"", Status.UNKNOWN_COMMAND),
        (200, b"abc", Status.UNKNOWN_COMMAND),
        (Command.INFO, b"", Status.UNKNOWN_COMMAND),
        (Command.STATUS, b"\0", Status.BAD_LENGTH),
        (Command.COUNTERS, b"\0", Status.BAD_LENGTH),
        (Command.CLEAR, b"abc", Status.BAD_LENGTH),
        (Command.START, b"", Status.BAD_LENGTH),
        (Command.START, GOOD_START[:-1], Status.BAD_LENGTH),
        (Command.START, GOOD_START + b"\0", Status.BAD_LENGTH),
        (Command.START, GOOD_START * 9, Status.BAD_LENGTH),
        (
            Command.START,
            start(16, 0, 0),
            Status.BAD_VALUE,
        ),
        (
            Command.START,
            start(0, 16, 0),
            Status.BAD_VALUE,
        ),
        (
            Command.START,
            start(0, 0, 15),
            Status.BAD_VALUE,
        ),
        (Command.READ, b"\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\1\0", Status.BAD_LENGTH),
        (Command.READ, b"\0\0", Status.BAD_VALUE),
        (Command.READ, b"\7\2", Status.BAD_VALUE),
        (Command.READ, b"\xff\xff", Status.BAD_VALUE),
        (Command.WRITE, b"", Status.BAD_LENGTH),
        (Command.WRITE, b"\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0\0", Status.BAD_LENGTH),
        (Command.WRITE, b"\0\1\0", Status.BAD_VALUE),  # No last waypoint.
        (Command.WRITE, b"\0" + pack_paths(CONFIG, [[1]]), Status.BAD_VALUE),
        (Command.WRITE, b"\0" + pack_paths(CONFIG, [[1] * 5]), Status.BAD_VALUE),
        (Command.WRITE, b"\7" + pack_paths(CONFIG, [[1, 2], [1, 2]]), Status.BAD_VALUE),
        (Command.WRITE, b"\x08" + pack_paths(CONFIG, [[1, 2]]), Status.BAD_VALUE),
        (Command.GENERATE, b"", Status.BAD_LENGTH),
        (Command.GENERATE, b"\3", Status.BAD_VALUE),
        (Command.GENERATE, b"\0\0", Status.BAD_LENGTH),
        (Command.GENERATE, generate(LinkMode.RANK, ORDER[:-1]), Status.BAD_LENGTH),
        (Command.GENERATE, generate(LinkMode.RANK, [*ORDER, 0, 1]), Status.BAD_LENGTH),
        (Command.GENERATE, generate(LinkMode.RECIPE, [*ORDER[:-1], 8]), Status.BAD_VALUE),
        (Command.GENERATE, generate(LinkMode.RECIPE, [*ORDER[:-1], 3]), Status.BAD_VALUE),
    ],
)
def test_refused(code, payload, status):
    """A refusal is told, remembered, and uses up no sequence number."""
    chip = Chip()
    bodies = after_open((code, payload))
    bodies.append((bytes((1, 0, Command.STATUS)), 0))
    _, refused, status_read = chip.run(bodies)
    assert refused == (status, AnswerKind.EMPTY, 0, 0)
    assert status_read == (Status.OK, AnswerKind.STATUS, 0, 0)
    assert chip.errors == StickyError.REFUSED
    assert chip.starts == []


MAP = map_request(CONFIG)
FLAGS = CheckFlag


def rectangle(x, y, width, height, cells):
    header = MAP.pack(x=x, y=y, width=width, height=height)
    return header + pack_cells(CONFIG, cells)


def check(flags, path):
    return bytes((flags,)) + pack_paths(CONFIG, [path])


def check_paths(slot, count, flags, start=0x123, goal=0xABC):
    return check_paths_request(CONFIG).pack(
        slot=slot, count=count, flags=flags, start=start, goal=goal
    )


@pytest.mark.parametrize("pauses", [(0,), (0, 3, 1)], ids=["steady", "stalled"])
def test_every_command_of_the_checker(pauses):
    chip = Chip(pauses, CHECKING)
    outcomes = chip.run(
        after_open(
            (Command.MAP, rectangle(3, 4, 2, 3, range(6))),
            (Command.CHECK, check(FLAGS.COUNT, [1, 2, 3])),
            (Command.CHECK, check(FLAGS.BRIEF, [7] * 6)),
            (Command.CHECK_PATHS, check_paths(2, 6, 0)),
            (Command.CHECK_PATHS, check_paths(0, 1, FLAGS.COUNT | FLAGS.BRIEF)),
            (Command.RESULTS, results_request(CONFIG).pack(path=3, count=2)),
            (Command.START, START.pack(seed=1, x=15, y=3, altitude=14, avoid_ground=1)),
        )
    )
    assert [outcome[:2] for outcome in outcomes[1:]] == [
        (Status.OK, AnswerKind.EMPTY),
        (Status.OK, AnswerKind.CHECKED),
        (Status.OK, AnswerKind.TOTALS),
        (Status.OK, AnswerKind.CHECKED),
        (Status.OK, AnswerKind.TOTALS),
        (Status.OK, AnswerKind.RESULTS),
        (Status.OK, AnswerKind.EMPTY),
    ]
    assert [(cell.x, cell.y, cell.altitude, cell.last) for cell in chip.cells] == [
        (3, 4, 0, 0), (4, 4, 1, 0), (3, 5, 2, 0), (4, 5, 3, 0), (3, 6, 4, 0), (4, 6, 5, 1),
    ]  # fmt: skip
    assert [(p.x, p.y, p.altitude, p.last) for p in chip.points] == [
        *((number, 0, 0, number == 3) for number in (1, 2, 3)),
        *((7, 0, 0, number == 5) for number in range(6)),
    ]
    done = [checks for checks in chip.checks if checks["check"]]
    assert [(each["batch"], each["counting"]) for each in done] == [(0, 1), (0, 0), (1, 0), (1, 1)]
    assert [done[2][name] for name in ("slot", "count", "start", "goal")] == [2, 6, 0x123, 0xABC]
    assert chip.forgotten == 4
    assert chip.starts[0].avoid_ground == 1


def test_repeated_checks_change_nothing():
    chip = Chip(config=CHECKING)
    bodies = [(bytes((1, 0, Command.OPEN)), 0)]
    for sequence, (command, payload) in enumerate(
        (
            (Command.MAP, rectangle(0, 0, 1, 1, [9])),
            (Command.CHECK, check(FLAGS.COUNT, [1, 2])),
            (Command.CHECK_PATHS, check_paths(0, 8, 0)),
        )
    ):
        bodies += [(bytes((1, sequence, command)) + payload, 0)] * 2
    # The answer may be asked for in short.
    bodies.append((bytes((1, 2, Command.CHECK_PATHS)) + check_paths(0, 8, FLAGS.BRIEF), 0))
    outcomes = chip.run(bodies)
    assert {status for status, *_ in outcomes} == {Status.OK}
    assert [checks["check"] for checks in chip.checks] == [0, 0, 0, 1, 0, 1, 0, 0]
    assert outcomes[-1][1] == AnswerKind.TOTALS
    assert (len(chip.cells), len(chip.points)) == (1, 2)


@pytest.mark.parametrize(
    ("code", "payload", "status"),
    [
        (Command.MAP, b"", Status.BAD_LENGTH),
        (Command.MAP, MAP.pack(x=0, y=0, width=1, height=1)[:-1], Status.BAD_LENGTH),
        (Command.MAP, MAP.pack(x=0, y=0, width=1, height=1), Status.BAD_LENGTH),
        (Command.MAP, rectangle(0, 0, 4, 4, range(13)), Status.BAD_LENGTH),
        (Command.MAP, rectangle(0, 0, 4, 1, range(6)), Status.BAD_LENGTH),
        (Command.MAP, rectangle(0, 0, 0, 1, [1]), Status.BAD_VALUE),
        (Command.MAP, rectangle(0, 0, 1, 0, [1]), Status.BAD_VALUE),
        (Command.MAP, rectangle(15, 0, 2, 1, [1, 2]), Status.BAD_VALUE),
        (Command.MAP, rectangle(0, 15, 1, 2, [1, 2]), Status.BAD_VALUE),
        (Command.MAP, rectangle(0xFFFF, 0, 1, 1, [1]), Status.BAD_VALUE),
        (Command.MAP, rectangle(1, 0, 0xFFFF, 1, [1]), Status.BAD_VALUE),
        (Command.MAP, rectangle(0, 2, 1, 0xFFFF, [1]), Status.BAD_VALUE),
        (Command.CHECK, b"", Status.BAD_LENGTH),
        (Command.CHECK, b"\0", Status.BAD_LENGTH),
        (Command.CHECK, b"\0" + bytes(3), Status.BAD_LENGTH),
        (Command.CHECK, check(4, [1, 2]), Status.BAD_VALUE),
        (Command.CHECK, check(0x81, [1, 2]), Status.BAD_VALUE),
        (Command.CHECK, check(0, [1]), Status.BAD_VALUE),
        (Command.CHECK, check(0, [1] * 7), Status.BAD_VALUE),
        (Command.CHECK, check(0, [1, 2]) + pack_paths(CONFIG, [[1, 2]]), Status.BAD_VALUE),
        (Command.CHECK_PATHS, b"", Status.BAD_LENGTH),
        (Command.CHECK_PATHS, check_paths(0, 1, 0)[:-1], Status.BAD_LENGTH),
        (Command.CHECK_PATHS, check_paths(0, 1, 0) + b"\0", Status.BAD_LENGTH),
        (Command.CHECK_PATHS, check_paths(0, 0, 0), Status.BAD_VALUE),
        (Command.CHECK_PATHS, check_paths(7, 2, 0), Status.BAD_VALUE),
        (Command.CHECK_PATHS, check_paths(255, 255, 0), Status.BAD_VALUE),
        (Command.CHECK_PATHS, check_paths(0, 1, 4), Status.BAD_VALUE),
        (Command.RESULTS, b"\0", Status.BAD_LENGTH),
        (Command.RESULTS, b"\0\1\0", Status.BAD_LENGTH),
        (Command.RESULTS, b"\0\0", Status.BAD_VALUE),
        (Command.RESULTS, b"\3\3", Status.BAD_VALUE),
        (Command.RESULTS, b"\xff\xff", Status.BAD_VALUE),
        (
            Command.START,
            start(16, 0, 0, 1),
            Status.BAD_VALUE,
        ),
    ],
)
def test_refused_of_the_checker(code, payload, status):
    chip = Chip(config=CHECKING)
    bodies = after_open((code, payload))
    bodies.append((bytes((1, 0, Command.STATUS)), 0))
    _, refused, status_read = chip.run(bodies)
    assert refused == (status, AnswerKind.EMPTY, 0, 0)
    assert status_read == (Status.OK, AnswerKind.STATUS, 0, 0)
    assert chip.errors == StickyError.REFUSED
    assert chip.starts == []
    assert not any(checks["check"] for checks in chip.checks)


@pytest.mark.parametrize("code", [Command.MAP, Command.CHECK, Command.CHECK_PATHS, Command.RESULTS])
def test_without_a_checker_its_commands_are_unknown(code):
    chip = Chip()
    [_, refused] = chip.run(after_open((code, bytes(11))))
    assert refused == (Status.UNKNOWN_COMMAND, AnswerKind.EMPTY, 0, 0)


def test_without_a_checker_the_ground_cannot_be_avoided():
    chip = Chip()
    payload = start(0, 0, 0, 1)
    [_, refused] = chip.run(after_open((Command.START, payload)))
    assert refused == (Status.BAD_VALUE, AnswerKind.EMPTY, 0, 0)


def test_order_of_commands():
    status = bytes((Command.STATUS,))
    bodies = [
        (b"\5\0" + status, 0),  # No such session.
        (b"\0\0" + status, 0),  # Session 0 is open after reset.
        (bytes((2, 0, Command.OPEN)), 0),  # Not the next.
        (bytes((1, 0, Command.OPEN)), 0),
        (b"\0\1" + status, 0),  # The session before.
        (b"\1\0" + status, 0),
        (b"\1\0" + status, 0),  # Asked again.
        (b"\1\1" + status, 0),
        (bytes((1, 0, Command.OPEN)), 0),  # Open already.
        (b"\1\0" + status, 0),  # Two back.
        (b"\1\3" + status, 0),  # One too far.
        (b"\1\x82" + status, 0),  # As far ahead as can be told from behind.
        (b"\1\x83" + status, 0),
        (b"\1\2" + status, 0),
    ]
    assert Chip().run(bodies) == [
        (Status.NO_SESSION, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.STATUS, 0, 0),
        (Status.NO_SESSION, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.NO_SESSION, AnswerKind.EMPTY, 1, 0),
        (Status.OK, AnswerKind.STATUS, 0, 0),
        (Status.OK, AnswerKind.STATUS, 0, 0),
        (Status.OK, AnswerKind.STATUS, 1, 0),
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.DUPLICATE, AnswerKind.EMPTY, 0, 0),
        (Status.OUT_OF_ORDER, AnswerKind.EMPTY, 2, 0),
        (Status.OUT_OF_ORDER, AnswerKind.EMPTY, 2, 0),
        (Status.DUPLICATE, AnswerKind.EMPTY, 0x83, 0),
        (Status.OK, AnswerKind.STATUS, 2, 0),
    ]


def test_repeated_commands_change_nothing():
    chip = Chip()
    again = [
        (bytes((1, 0, Command.START)) + GOOD_START, 0),
        (bytes((1, 1, Command.WRITE)) + b"\0" + pack_paths(CONFIG, [[1, 2]]), 0),
        (bytes((1, 2, Command.GENERATE)) + generate(LinkMode.RANK, ORDER), 0),
    ]
    # The answer may be asked for in another mode.
    shorter = (bytes((1, 2, Command.GENERATE)) + generate(LinkMode.RECIPE, ORDER), 0)
    whole = (bytes((1, 2, Command.GENERATE)) + generate(LinkMode.POPULATION, []), 0)
    bodies = [(bytes((1, 0, Command.OPEN)), 0)]
    for body in again:
        bodies += [body, body]
    outcomes = chip.run([*bodies, shorter, whole])
    assert outcomes[1:] == [
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.EMPTY, 1, 0),
        (Status.OK, AnswerKind.EMPTY, 1, 0),
        (Status.OK, AnswerKind.CHILDREN, 2, 1),
        (Status.OK, AnswerKind.CHILDREN, 2, 0),
        (Status.OK, AnswerKind.RECIPE, 2, 0),
        (Status.OK, AnswerKind.PATHS, 2, 0),
    ]
    assert len(chip.starts) == 1
    assert len(chip.writes) == 2
    assert len(chip.ranking) == 8


def test_plain_frames_only_ask_for_information():
    chip = Chip()
    plain = [(bytes((0, 0, code)), 1) for code in Command if code is not Command.INFO]
    outcomes = chip.run([*plain, (bytes((0, 3, Command.INFO)), 1)])
    assert [kind for _, kind, _, _ in outcomes] == [
        *[AnswerKind.SILENCE] * len(plain),
        AnswerKind.INFO,
    ]
    assert chip.session == 0


def test_line_errors_stick_until_cleared():
    chip = Chip()
    chip.run([(bytes((0, 0, Command.STATUS)), 0)], line_errors=(1, 0, 8))
    assert chip.errors == StickyError.FRAMING | StickyError.MALFORMED
    chip = Chip()
    chip.run([(bytes((0, 0, Command.CLEAR)), 0)], line_errors=(1, 2, 4, 8))
    assert chip.errors == StickyError(0)


def test_sequence_numbers_wrap():
    bodies = after_open(*[(Command.STATUS, b"")] * 256)
    outcomes = Chip().run([*bodies, (bytes((1, 0, Command.STATUS)), 0)])
    assert [outcome[2] for outcome in outcomes[1:]] == [*range(256), 0]
    assert {outcome[0] for outcome in outcomes} == {Status.OK}


def test_configuration_is_checked():
    with pytest.raises(TypeError, match=r"^Configuration must be a Config, not 16$"):
        ReceivingUnit(16)
    assert generate_request(CONFIG, LinkMode.RANK).size == 9
