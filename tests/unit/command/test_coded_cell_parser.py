"""Parser of the cells of a CODED_MAP: any cells in any code, and payloads of wrong length."""

import random

import pytest

from pathgene.hdl.command.coded_cell_parser import CodedCellParser
from pathgene.hdl.config import Config
from pathgene.hdl.layouts import struct
from pathgene.hdl.protocol.codes import Status
from pathgene.hdl.protocol.messages import coded_map_request
from pathgene.sim.model.coded_cells import decode_cells
from tests.support.gateware.coded_cells import encode
from tests.support.gateware.payloads import hand_over
from tests.support.gateware.streams import collect
from tests.unit.command.test_cell_parser import PAUSES, expected


OK, BAD_LENGTH = Status.OK, Status.BAD_LENGTH
#: Bits of an altitude and of a remainder.
CODES = [(4, 0), (4, 3), (8, 0), (8, 2), (12, 3), (12, 11), (13, 1), (16, 4)]


def config_of(bits):
    return Config(map_size=64, coarse_factor=8, altitude_bits=bits, max_waypoints=4, core="planner")


def written(bits, remainder_bits, payloads, x, y, width, height, *, repeated=False, pauses=(0,)):
    """Return the outcomes of ``payloads``, and the cells written as x, y, altitude, last."""
    unit = CodedCellParser(6, bits, struct(coded_map_request(config_of(bits))))
    cells = []
    rectangle = {"x": x, "y": y, "width": width, "height": height}
    outcomes = hand_over(
        unit,
        payloads,
        {"rectangle": rectangle | {"remainder_bits": remainder_bits}},
        repeated=repeated,
        collectors=(collect(unit.writes, cells, pauses),),
    )
    return outcomes, [(cell.x, cell.y, cell.altitude, cell.last) for cell in cells]


def ground(rng, bits, count):
    """Return altitudes: gentle ground with some cliffs, from the lowest to the highest."""
    altitude, altitudes = rng.getrandbits(bits), []
    for _ in range(count):
        altitude = min(max(altitude + rng.randrange(-3, 4), 0), (1 << bits) - 1)
        altitudes.append(altitude)
        if rng.random() < 0.1:
            altitude = rng.choice((0, rng.getrandbits(bits), (1 << bits) - 1))
    return altitudes


@PAUSES
@pytest.mark.parametrize(("bits", "remainder_bits"), CODES)
@pytest.mark.parametrize("rectangle", [(0, 0, 1, 1), (3, 5, 4, 3), (63, 8, 1, 24), (0, 61, 64, 3)])
def test_whole_rectangles(bits, remainder_bits, rectangle, pauses):
    rng = random.Random(bits)
    x, y, width, height = rectangle
    altitudes = [ground(rng, bits, width * height) for _ in range(2)]
    outcomes, cells = written(
        bits,
        remainder_bits,
        [encode(each, width, bits, remainder_bits)[0] for each in altitudes],
        *rectangle,
        pauses=pauses,
    )
    assert [status for status, _ in outcomes] == [OK, OK]
    assert cells == expected(altitudes[0], x, y, width) + expected(altitudes[1], x, y, width)


@PAUSES
@pytest.mark.parametrize(("bits", "remainder_bits"), CODES)
def test_any_bytes_are_decoded_as_by_the_model(bits, remainder_bits, pauses):
    """Cut, whole and surplus payloads; whole cells of a short one are written."""
    rng = random.Random(remainder_bits)
    payloads = [rng.randbytes(rng.randrange(40)) for _ in range(12)]
    payloads += [bytes([255]) * rng.randrange(30), bytes(9)]
    outcomes, cells = written(bits, remainder_bits, payloads, 9, 7, 5, 4, pauses=pauses)
    found, statuses = [], []
    for payload in payloads:
        altitudes, size = decode_cells(config_of(bits), payload, 5, 4, remainder_bits)
        found += expected(altitudes, 9, 7, 5)
        is_whole = len(altitudes) == 20 and size == len(payload)
        statuses.append(OK if is_whole else BAD_LENGTH)
    assert [status for status, _ in outcomes] == statuses
    assert cells == found


@pytest.mark.parametrize(("bits", "remainder_bits"), CODES)
def test_too_short_or_too_long(bits, remainder_bits):
    rng = random.Random(bits)
    altitudes = ground(rng, bits, 12)
    payload, ends = encode(altitudes, 4, bits, remainder_bits)
    cut = [payload[:length] for length in range(len(payload))]
    outcomes, cells = written(
        bits, remainder_bits, [*cut, payload, payload + b"\0", payload + b"\xff"], 8, 4, 4, 3
    )
    assert [status for status, _ in outcomes] == [*[BAD_LENGTH] * len(cut), OK, *[BAD_LENGTH] * 2]
    whole = [sum(end <= 8 * length for end in ends) for length in range(len(payload))]
    assert cells == [
        cell for count in (*whole, 12, 12, 12) for cell in expected(altitudes[:count], 8, 4, 4)
    ]


def test_repeated_writes_nothing():
    payload, _ = encode([5, 6, 7, 9], 2, 12, 2)
    for data, status in ((payload, OK), (payload[:-1], BAD_LENGTH), (payload + b"\0", BAD_LENGTH)):
        outcomes, cells = written(12, 2, [data], 0, 0, 2, 2, repeated=True)
        assert outcomes[0][0] is status
        assert cells == []


def test_cycles_of_a_cell():
    """A cell takes a cycle for each of its bits and three more."""
    cycles = []
    for height in (2, 6):
        payload, ends = encode([7] * 8 * height, 8, 12, 0)
        [(status, spent)], _ = written(12, 0, [payload], 0, 0, 8, height)
        assert status is OK
        cycles.append((spent, ends[-1]))
    (few, few_bits), (many, many_bits) = cycles
    assert many - few == many_bits - few_bits + 3 * 8 * 4
