"""Parser of the cells of a MAP: places of the cells, and payloads of wrong length."""

import random

import pytest

from pathgene.hdl.command.cell_parser import CellParser
from pathgene.hdl.config import Config
from pathgene.hdl.layouts import struct
from pathgene.hdl.protocol.codes import Status
from pathgene.hdl.protocol.messages import map_request
from pathgene.hdl.protocol.paths import pack_cells
from tests.support.gateware.payloads import hand_over
from tests.support.gateware.streams import collect


PAUSES = pytest.mark.parametrize("pauses", [(0,), (0, 3, 1, 0, 7)], ids=["steady", "stalled"])
OK, BAD_LENGTH = Status.OK, Status.BAD_LENGTH


def config_of(bits):
    return Config(map_size=32, coarse_factor=4, altitude_bits=bits, max_waypoints=4)


def parser_of(bits):
    return CellParser(5, bits, struct(map_request(config_of(bits))))


def written(bits, payloads, x, y, width, height, *, repeated=False, pauses=(0,)):
    """Return the outcomes of ``payloads``, and the cells written as x, y, altitude, last."""
    unit = parser_of(bits)
    cells = []

    outcomes = hand_over(
        unit,
        payloads,
        {"rectangle": {"x": x, "y": y, "width": width, "height": height}},
        repeated=repeated,
        collectors=(collect(unit.writes, cells, pauses),),
    )
    return outcomes, [(cell.x, cell.y, cell.altitude, cell.last) for cell in cells]


def expected(altitudes, x, y, width):
    last = len(altitudes) - 1
    return [
        (x + number % width, y + number // width, altitude, number == last)
        for number, altitude in enumerate(altitudes)
    ]


@PAUSES
@pytest.mark.parametrize("bits", [4, 8, 12, 13])
@pytest.mark.parametrize("rectangle", [(0, 0, 1, 1), (3, 5, 4, 3), (31, 8, 1, 24), (0, 31, 32, 1)])
def test_whole_rectangles(bits, rectangle, pauses):
    rng = random.Random(bits)
    x, y, width, height = rectangle
    altitudes = [[rng.getrandbits(bits) for _ in range(width * height)] for _ in range(2)]
    outcomes, cells = written(
        bits, [pack_cells(config_of(bits), each) for each in altitudes], *rectangle, pauses=pauses
    )
    assert [status for status, _ in outcomes] == [OK, OK]
    assert cells == expected(altitudes[0], x, y, width) + expected(altitudes[1], x, y, width)


@pytest.mark.parametrize(("bits", "cycles_per_cell"), [(4, 2), (8, 2), (12, 4), (16, 3)])
def test_cycles_per_cell(bits, cycles_per_cell):
    """The difference between two sizes gives the cycles of a cell."""
    cycles = []
    for height in (2, 6):
        altitudes = range(8 * height)
        payload = pack_cells(config_of(bits), [value % 16 for value in altitudes])
        [(status, spent)], _ = written(bits, [payload], 0, 0, 8, height)
        assert status is OK
        cycles.append(spent)
    assert cycles[1] - cycles[0] == cycles_per_cell * 8 * 4


@PAUSES
@pytest.mark.parametrize("bits", [4, 8, 12, 13])
def test_too_short(bits, pauses):
    """Whole cells are written, and the last of them ends the rectangle for the checker."""
    rng = random.Random(bits)
    config = config_of(bits)
    altitudes = [rng.getrandbits(bits) for _ in range(12)]
    payload = pack_cells(config, altitudes)
    shorter = [payload[:length] for length in range(len(payload))]
    outcomes, cells = written(bits, shorter, 8, 4, 4, 3, pauses=pauses)
    assert {status for status, _ in outcomes} == {BAD_LENGTH}
    whole = [8 * length // bits for length in range(len(payload))]
    assert cells == [cell for count in whole for cell in expected(altitudes[:count], 8, 4, 4)]


@PAUSES
@pytest.mark.parametrize("bits", [4, 8, 12, 13, 16])
def test_too_long(bits, pauses):
    altitudes = list(range(10)) if bits < 8 else [3 * number for number in range(9)]
    width = len(altitudes)
    payload = pack_cells(config_of(bits), altitudes)
    longer = [payload + surplus for surplus in (b"\0", b"\xff\xff", bytes(20))]
    outcomes, cells = written(bits, longer, 5, 6, width, 1, pauses=pauses)
    assert [status for status, _ in outcomes] == [BAD_LENGTH] * 3
    assert cells == expected(altitudes, 5, 6, width) * 3


def test_repeated_writes_nothing():
    payload = pack_cells(config_of(12), range(6))
    for data, status in ((payload, OK), (payload[:-2], BAD_LENGTH), (payload + b"\0", BAD_LENGTH)):
        outcomes, cells = written(12, [data], 0, 0, 3, 2, repeated=True)
        assert outcomes[0][0] is status
        assert cells == []


def test_it_waits_for_the_map():
    """After the last cell, the checker accepts no cell until it has applied the rectangle."""
    unit = parser_of(8)
    busy_cycles = 57
    done_at = []

    async def checker(ctx):
        ctx.set(unit.writes.ready, 1)
        while True:
            _, _, last = await ctx.tick().sample(unit.writes.valid & unit.writes.p.last)
            if last:
                ctx.set(unit.writes.ready, 0)
                for _ in range(busy_cycles):
                    _, _, done = await ctx.tick().sample(unit.done)
                    done_at.append(done)
                ctx.set(unit.writes.ready, 1)

    outcomes = hand_over(
        unit, [bytes(6)], {"rectangle": {"width": 3, "height": 2}}, collectors=(checker,)
    )
    assert outcomes[0][0] is OK
    assert done_at == [0] * busy_cycles
    # A cell is a byte here: each takes 2 cycles, and the last is held for one.
    assert outcomes[0][1] == 2 * 6 + busy_cycles + 4
