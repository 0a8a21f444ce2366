"""Commands of the checker in the model of the chip."""

import random
from functools import partial

import pytest

from pathgene.hdl.protocol.codes import CheckFlag, Command, Counter, Status
from pathgene.hdl.protocol.messages import (
    check_reply,
    counters_reply,
    read_request,
    results_request,
    start_request,
    status_reply,
)
from pathgene.hdl.protocol.paths import PathResult, pack_paths, unpack_results
from pathgene.sim.model.checker import check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from pathgene.sim.model.chip import Chip
from tests.support.gateware import refusals
from tests.support.gateware.chips import CHECKING, random_path, random_paths
from tests.unit.model.test_chip import Session, ask


TOTALS = check_reply(CHECKING)


rectangle = partial(refusals.rectangle, CHECKING)
check = partial(refusals.check, CHECKING)
check_paths = partial(refusals.check_paths, CHECKING)


@pytest.fixture
def host():
    """Session with a chip over random ground in the lower half of altitudes and blocked cells."""
    host = Session(CHECKING)
    rng = random.Random(1)
    heights = [rng.choice((rng.randrange(8), rng.randrange(8), 1)) for _ in range(256)]
    for at in rng.sample(range(256), 4):
        heights[at] = 15
    host(Command.MAP, rectangle(0, 0, 16, 16, heights))
    assert host.chip.checking.terrain.heights.reshape(-1).tolist() == heights
    return host


def points_of(path):
    return [(word & 15, word >> 4 & 15, word >> 8 & 15) for word in path]


def results_of(host, paths, counting):
    """Return the results of ``paths`` by the checker's definition, and their totals."""
    results, cells = [], 0
    for path in paths:
        said = check_path(CHECKING, host.chip.checking.terrain, points_of(path), counting)
        cells += said.cells
        results.append(
            PathResult(True, said.segment, (said.x, said.y), said.coarse, said.cells, said.entries)
            if said.collision
            else PathResult()
        )
    spent = batch_cycles(
        CHECKING, host.chip.checking.terrain, [points_of(path) for path in paths], counting
    )
    totals = {
        "cycles": sum(cycles for cycles, _ in spent),
        "reads": sum(reads for _, reads in spent),
        "cells": cells,
    }
    return results, totals


@pytest.mark.parametrize("flags", [CheckFlag(0), CheckFlag.COUNT])
def test_checks_a_path(host, flags):
    rng = random.Random(2)
    collisions = 0
    for length in [2, 3, 7] * 10:
        path = random_path(CHECKING, rng, length)
        reply = host(Command.CHECK, check(flags, path))
        results, totals = results_of(host, [path], bool(flags))
        assert TOTALS.unpack(reply[: TOTALS.size]) == totals
        assert unpack_results(CHECKING, reply[TOTALS.size :]) == results
        collisions += results[0].collision
    assert 5 < collisions < 30


@pytest.mark.parametrize("flags", [CheckFlag(0), CheckFlag.COUNT])
def test_checks_paths_of_the_population(host, flags):
    rng = random.Random(3)
    paths = random_paths(CHECKING, rng)
    host(Command.WRITE, b"\0" + pack_paths(CHECKING, paths))
    for slot, count in ((0, 8), (3, 2), (7, 1)):
        start, goal = random_path(CHECKING, rng, 2)
        reply = host(Command.CHECK_PATHS, check_paths(slot, count, flags, start, goal))
        asked = [[start, *path, goal] for path in paths[slot : slot + count]]
        results, totals = results_of(host, asked, bool(flags))
        assert TOTALS.unpack(reply[: TOTALS.size]) == totals
        assert unpack_results(CHECKING, reply[TOTALS.size :]) == results


def test_returns_the_latest_results_again(host):
    host(Command.WRITE, b"\0" + pack_paths(CHECKING, random_paths(CHECKING, random.Random(4))))
    brief = host(Command.CHECK_PATHS, check_paths(1, 6, CheckFlag.COUNT | CheckFlag.BRIEF))
    assert len(brief) == TOTALS.size

    def results(path, count):
        return host(Command.RESULTS, results_request(CHECKING).pack(path=path, count=count))

    every = unpack_results(CHECKING, results(0, 6))
    assert len(every) == 6
    assert any(result.entries for result in every)
    for path, count in ((0, 1), (2, 3), (5, 1)):
        assert unpack_results(CHECKING, results(path, count)) == every[path : path + count]
    # The reply to the long form of the command, in case the short one was lost.
    host(Command.CHECK_PATHS, check_paths(1, 6, CheckFlag.COUNT | CheckFlag.BRIEF))
    sequence = (host.sequence - 1) % 256
    body = bytes((1, sequence, Command.CHECK_PATHS)) + check_paths(1, 6, CheckFlag.COUNT)
    answer = ask(host.chip, body)
    assert unpack_results(CHECKING, answer[3 + TOTALS.size :]) == every


def test_repeated_commands_change_nothing(host):
    def again(command, payload):
        return ask(host.chip, bytes((1, (host.sequence - 1) % 256, command)) + payload)[2:]

    before = host.chip.checking.terrain.heights.tolist()
    host(Command.MAP, rectangle(3, 3, 1, 1, [before[3][3]]))
    assert again(Command.MAP, rectangle(0, 0, 2, 1, [15, 15])) == bytes((Status.OK,))
    assert host.chip.checking.terrain.heights.tolist() == before

    host(Command.CHECK, check(CheckFlag.COUNT, [0x400, 0x4FF]))
    counters = counters_reply(CHECKING).unpack(host(Command.COUNTERS))
    assert counters[Counter.PATHS] == 1
    first = host(Command.CHECK, check(CheckFlag.COUNT, [0x400, 0x4FF]))
    assert again(Command.CHECK, check(CheckFlag.COUNT, [0x300, 0x311])) == b"\0" + first
    host(Command.STATUS)
    # A repeated check with another command code returns the results of the latest check.
    assert again(Command.CHECK, check(CheckFlag.COUNT, [0x300, 0x311])) == b"\0" + first
    counters = counters_reply(CHECKING).unpack(host(Command.COUNTERS))
    assert counters[Counter.PATHS] == 2


def test_counters_and_states(host):
    paths = random_paths(CHECKING, random.Random(5))
    host(Command.WRITE, b"\0" + pack_paths(CHECKING, paths))
    spent = {"cycles": 0, "reads": 0, "cells": 0}
    for _ in range(2):
        reply = host(Command.CHECK_PATHS, check_paths(0, 8, 0))
        for name, value in TOTALS.unpack(reply[: TOTALS.size]).items():
            spent[name] += value
    told = status_reply(CHECKING).unpack(host(Command.STATUS))
    # From the latest: transmit, receive, listen, transmit, check, receive, listen, transmit.
    assert told["history"] == 0x50165015
    counters = counters_reply(CHECKING).unpack(host(Command.COUNTERS))
    assert counters[Counter.FEASIBILITY] == spent["cycles"] > 0
    assert counters[Counter.READS] == spent["reads"] > 0
    assert counters[Counter.CELLS] == spent["cells"] > 0
    assert counters[Counter.PATHS] == 16


@pytest.mark.parametrize(
    ("payload", "written"),
    [
        (rectangle(2, 3, 4, 3, range(7)), 7),
        (rectangle(2, 3, 4, 3, range(4)), 4),
        (rectangle(2, 3, 4, 3, [1]), 1 + 1),  # A cell takes half a byte.
        (rectangle(2, 3, 4, 3, []), 0),
        (rectangle(2, 3, 4, 3, range(12)) + b"\7", 12),
    ],
)
def test_writes_the_cells_of_a_map_of_wrong_length(host, payload, written):
    expected = host.chip.checking.terrain.heights.tolist()
    cells = [*range(12)] if written > 2 else [1, 0]
    for number in range(written):
        expected[3 + number // 4][2 + number % 4] = cells[number]
    if written == 7:
        expected[4][5] = 0  # The padding forms a cell.
    answer = ask(host.chip, bytes((1, host.sequence, Command.MAP)) + payload)
    assert answer[2] == Status.BAD_LENGTH
    assert host.chip.checking.terrain.heights.tolist() == expected


@pytest.mark.parametrize(
    ("code", "payload", "status"),
    # Nothing has been checked, so there are no results.
    [*refusals.check_refusals(CHECKING), (Command.RESULTS, b"\0\1", Status.BAD_VALUE)],
)
def test_refuses_bad_requests(host, code, payload, status):
    before = host.chip.checking.terrain.heights.tolist()
    answer = ask(host.chip, bytes((1, host.sequence, code)) + payload)
    assert answer == bytes((1, host.sequence, status))
    assert host.chip.checking.terrain.heights.tolist() == before
    host(Command.READ, read_request(CHECKING).pack(slot=0, count=8))


@pytest.mark.parametrize("code", [Command.MAP, Command.CHECK, Command.CHECK_PATHS, Command.RESULTS])
def test_commands_are_unknown_without_a_checker(code):
    chip = Chip(CHECKING.replace(checker="none"))
    assert ask(chip, bytes((0, 0, code)) + bytes(11))[2] == Status.UNKNOWN_COMMAND


def test_only_a_chip_with_a_checker_avoids_the_ground(host):
    layout = start_request(CHECKING)
    payload = layout.pack(seed=0, x=1, y=1, altitude=1, avoid_ground=1)
    host(Command.START, payload)
    assert host.chip.core.avoid_ground
    chip = Chip(CHECKING.replace(checker="none"))
    assert ask(chip, bytes((0, 0, Command.START)) + payload)[2] == Status.BAD_VALUE
