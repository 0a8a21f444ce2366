"""Command receiver: every command, intact or broken."""

import pytest

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.protocol.codes import Command, LinkMode, Status, StickyError
from pathgene.hdl.protocol.messages import generate_request, read_request
from pathgene.hdl.protocol.paths import pack_paths
from tests.support.gateware.refusals import refusals
from tests.unit.command.receiver_bench import (
    CHECKING,
    CONFIG,
    GOOD_START,
    ORDER,
    Chip,
    after_open,
    check,
    check_paths,
    generate,
    refuse,
)


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
    (start,) = chip.start_requests
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


def test_cycles():
    """A request is refused or executed at most 6 cycles after its last byte."""
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
    assert chip.cycles == 6


def test_refused():
    assert refuse(CONFIG, refusals(CONFIG, ORDER)).start_requests == []


def test_order_of_commands():
    status = bytes((Command.STATUS,))
    bodies = [
        (b"\5\0" + status, 0),  # No such session.
        (b"\0\0" + status, 0),  # Session 0 is open after reset.
        (bytes((2, 0, Command.OPEN)), 0),  # Not the next session.
        (bytes((1, 0, Command.OPEN)), 0),
        (b"\0\1" + status, 0),  # The previous session.
        (b"\1\0" + status, 0),
        (b"\1\0" + status, 0),  # Repeated.
        (b"\1\1" + status, 0),
        (bytes((1, 0, Command.OPEN)), 0),  # Open already.
        (b"\1\0" + status, 0),  # Two numbers back.
        (b"\1\3" + status, 0),  # One number too far.
        (b"\1\x82" + status, 0),  # The farthest number that counts as ahead.
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
    # A repeated command may ask for another link mode.
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
    assert len(chip.start_requests) == 1
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
    """Each command is executed: the answer alone does not tell it from a repetition."""
    bodies = after_open(*[(Command.START, GOOD_START)] * 256)
    chip = Chip()
    outcomes = chip.run([*bodies, (bytes((1, 0, Command.START)) + GOOD_START, 0)])
    assert [outcome[2] for outcome in outcomes[1:]] == [*range(256), 0]
    assert {outcome[0] for outcome in outcomes} == {Status.OK}
    assert len(chip.start_requests) == 257


def test_sessions_begin_with_the_number_0():
    """After a reset and after each OPEN, the command with this number is no repetition."""
    chip = Chip()
    start = bytes((Command.START,)) + GOOD_START
    bodies = [b"\0\0" + start, b"\0\1" + start, bytes((1, 7, Command.OPEN)), b"\1\0" + start]
    outcomes = chip.run([(body, 0) for body in bodies])
    assert [(status, number) for status, _, number, _ in outcomes] == [
        (Status.OK, 0),
        (Status.OK, 1),
        (Status.OK, 7),
        (Status.OK, 0),
    ]
    assert len(chip.start_requests) == 3


def test_a_request_of_the_ranking_has_nine_bytes():
    assert generate_request(CONFIG, LinkMode.RANK).size == 9
