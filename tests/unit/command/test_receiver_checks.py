"""Command receiver: the commands of the collision checker, intact or broken."""

import pytest

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.protocol.codes import CheckFlag, Command, Status
from pathgene.hdl.protocol.messages import results_request
from tests.support.gateware.refusals import check_refusals
from tests.unit.command.receiver_bench import (
    CHECKING,
    CONFIG,
    START,
    Chip,
    after_open,
    check,
    check_paths,
    rectangle,
    refuse,
    start,
)


@pytest.mark.parametrize("pauses", [(0,), (0, 3, 1)], ids=["steady", "stalled"])
def test_every_command_of_the_checker(pauses):
    chip = Chip(pauses, CHECKING)
    outcomes = chip.run(
        after_open(
            (Command.MAP, rectangle(3, 4, 2, 3, range(6))),
            (Command.CHECK, check(CheckFlag.COUNT, [1, 2, 3])),
            (Command.CHECK, check(CheckFlag.BRIEF, [7] * 6)),
            (Command.CHECK_PATHS, check_paths(2, 6, 0)),
            (Command.CHECK_PATHS, check_paths(0, 1, CheckFlag.COUNT | CheckFlag.BRIEF)),
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
    assert chip.start_requests[0].avoid_ground == 1


def test_repeated_checks_change_nothing():
    chip = Chip(config=CHECKING)
    bodies = [(bytes((1, 0, Command.OPEN)), 0)]
    for sequence, (command, payload) in enumerate(
        (
            (Command.MAP, rectangle(0, 0, 1, 1, [9])),
            (Command.CHECK, check(CheckFlag.COUNT, [1, 2])),
            (Command.CHECK_PATHS, check_paths(0, 8, 0)),
        )
    ):
        bodies += [(bytes((1, sequence, command)) + payload, 0)] * 2
    # A repeated command may ask for the brief answer.
    bodies.append((bytes((1, 2, Command.CHECK_PATHS)) + check_paths(0, 8, CheckFlag.BRIEF), 0))
    outcomes = chip.run(bodies)
    assert {status for status, *_ in outcomes} == {Status.OK}
    assert [checks["check"] for checks in chip.checks] == [0, 0, 0, 1, 0, 1, 0, 0]
    assert outcomes[-1][1] == AnswerKind.TOTALS
    assert (len(chip.cells), len(chip.points)) == (1, 2)


def test_refused_of_the_checker():
    # Cells of the rectangle may have changed.
    rows = [
        (Command.MAP, rectangle(0, 0, 4, 4, range(13)), Status.BAD_LENGTH),
        (Command.MAP, rectangle(0, 0, 4, 1, range(6)), Status.BAD_LENGTH),
    ]
    chip = refuse(CHECKING, [*check_refusals(CONFIG), *rows])
    assert chip.start_requests == []
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
