"""Parser of the points of a CHECK: the allowed numbers of points."""

import random

import pytest

from pathgene.hdl.command.waypoint_parsers import PointParser
from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import Status
from pathgene.hdl.protocol.paths import pack_paths
from tests.support.gateware.payloads import hand_over
from tests.support.gateware.streams import collect, shared


CONFIG = Config(max_waypoints=5)
MOST = CONFIG.max_waypoints + 2
PAUSES = pytest.mark.parametrize("pauses", [(0,), (0, 6, 1)], ids=["steady", "stalled"])


def taken(payloads, *, repeated=False, pauses=(0,)):
    unit = shared(PointParser, CONFIG.coordinate_bits, CONFIG.altitude_bits, CONFIG.max_waypoints)
    points = []

    outcomes = hand_over(
        unit, payloads, repeated=repeated, collectors=(collect(unit.points, points, pauses),)
    )
    return outcomes, [(point.x, point.y, point.altitude, point.last) for point in points]


def path_of(length, seed=0):
    rng = random.Random(seed)
    return [rng.getrandbits(CONFIG.waypoint_bits) for _ in range(length)]


def points_of(path):
    last = len(path) - 1
    return [(word & 511, word >> 9 & 511, word >> 18, at == last) for at, word in enumerate(path)]


@PAUSES
def test_every_length(pauses):
    paths = [path_of(length) for length in range(2, MOST + 1)]
    outcomes, points = taken([pack_paths(CONFIG, [path]) for path in paths], pauses=pauses)
    assert {status for status, _ in outcomes} == {Status.OK}
    assert points == [point for path in paths for point in points_of(path)]


def test_cycles():
    """4 bytes and two cycles per point, and one more cycle until it is done."""
    outcomes, _ = taken([pack_paths(CONFIG, [path_of(6)])])
    assert outcomes == [(Status.OK, 6 * 6 + 1)]


@pytest.mark.parametrize(
    ("payload", "status"),
    [
        (b"", Status.BAD_LENGTH),
        (b"\0\0\0", Status.BAD_LENGTH),
        (bytes(9), Status.BAD_LENGTH),
        (pack_paths(CONFIG, [path_of(3)]) + b"\0", Status.BAD_LENGTH),
        (pack_paths(CONFIG, [path_of(1)]), Status.BAD_VALUE),
        (pack_paths(CONFIG, [path_of(MOST + 1)]), Status.BAD_VALUE),
        (pack_paths(CONFIG, [path_of(40)]), Status.BAD_VALUE),
        (bytes(4 * 3), Status.BAD_VALUE),  # No last point.
        (pack_paths(CONFIG, [path_of(2), path_of(2)]), Status.BAD_VALUE),
    ],
)
def test_refused(payload, status):
    """A wrong payload never yields too many points; a correct one is accepted after it."""
    good = pack_paths(CONFIG, [path_of(4, seed=5)])
    outcomes, points = taken([payload, good])
    assert [outcome for outcome, _ in outcomes] == [status, Status.OK]
    assert len(points) <= MOST + 4
    assert points[-4:] == points_of(path_of(4, seed=5))
    assert sum(last for *_, last in points[:-4]) <= 1


def test_repeated_hands_nothing_on():
    outcomes, points = taken([pack_paths(CONFIG, [path_of(4)])], repeated=True)
    assert outcomes[0][0] is Status.OK
    assert points == []
