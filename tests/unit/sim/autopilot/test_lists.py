"""The protocol of lists: ArduPlane's and PX4's rules, message by message."""

import dataclasses
import math

import pytest

from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.fence import storage_bytes
from pathgene.sim.autopilot.link import Faults
from pathgene.sim.autopilot.pilot import Kind
from tests.support.autopilot.station import (
    ACCEPTED,
    DENIED,
    ERROR,
    HOME,
    INVALID_SEQUENCE,
    NO_SPACE,
    at,
    connected,
)


MISSION = [at(0, 0), *(at(0, 400 * n) for n in range(1, 6)), at(0, 2000, command=17)]
UNSUPPORTED_FRAME, UNSUPPORTED, INVALID_PARAM1, CANCELLED = 2, 3, 6, 15


def station_at(kind=Kind.ARDUPLANE, **options):
    start = Start(HOME, armed=options.pop("armed", True))
    return connected(Autopilot(kind, start), **options)


def polygon(corners, radius_m=300.0, east_m=9000.0, command=5002):
    """Return the items of a polygon far from home."""
    count = float(corners)
    return [
        at(
            east_m + radius_m * math.cos(2 * math.pi * n / corners),
            radius_m * math.sin(2 * math.pi * n / corners),
            command=command,
            params=(count, 0.0, 0.0, 0.0),
        )
        for n in range(corners)
    ]


@pytest.fixture(params=list(Kind), ids=lambda kind: kind.name.lower())
def station(request):
    return station_at(request.param)


def test_a_mission_is_taken_and_given_back(station):
    assert station.upload(MISSION) == ACCEPTED
    held = station.download()
    assert [(item.command, item.x, item.y) for item in held[1:]] == [
        (item.command, item.x, item.y) for item in MISSION[1:]
    ]
    assert [item.param2 for item in held[1:6]] == [10.0] * 5


def test_ardupilot_keeps_whole_centimetres_and_no_heading():
    station = station_at()
    fine = at(0, 400, z=612.3499, params=(0.0, 10.7, 0.0, math.nan))
    assert station.upload([MISSION[0], fine]) == ACCEPTED
    held = station.download()[1]
    assert held.z == pytest.approx(612.34, abs=1e-4)
    assert (held.param2, held.param4) == (10.0, 0.0)


def test_item_0_of_ardupilot_is_home_whatever_is_written_there():
    station = station_at()
    station.upload([at(9000, 9000), *MISSION[1:]])
    home = station.download()[0]
    assert (home.x, home.y, home.z) == (round(HOME[0] * 1e7), round(HOME[1] * 1e7), HOME[2])


@pytest.mark.parametrize(
    ("change", "result"),
    [
        ({"params": (math.nan, 10.0, 0.0, 0.0)}, INVALID_PARAM1),
        ({"params": (0.0, math.inf, 0.0, 0.0)}, INVALID_PARAM1 + 1),
        ({"params": (0.0, 0.0, 0.0, -math.inf)}, INVALID_PARAM1 + 3),
        ({"params": (0.0, 0.0, 0.0, math.nan)}, ACCEPTED),
        ({"command": 17, "params": (0.0, 0.0, 50.0, math.nan)}, INVALID_PARAM1 + 3),
        ({"command": 21, "params": (0.0, 0.0, 0.0, math.nan)}, ACCEPTED),
        ({"command": 31, "params": (0.0, math.nan, 0.0, 0.0)}, INVALID_PARAM1 + 1),
        ({"frame": 1}, UNSUPPORTED_FRAME),
        ({"command": 9999}, UNSUPPORTED),
        ({"x": 950_000_000}, 10),
        ({"z": math.nan}, 12),
    ],
)
def test_ardupilot_judges_each_item(change, result):
    station = station_at()
    assert station.upload([MISSION[0], dataclasses.replace(MISSION[1], **change)]) == result


def test_px4_takes_any_open_parameter_but_no_height_over_terrain():
    station = station_at(Kind.PX4)
    loose = dataclasses.replace(MISSION[6], params=(math.nan, math.nan, 50.0, math.nan))
    assert station.upload([MISSION[1], loose]) == ACCEPTED
    terrain = dataclasses.replace(MISSION[1], frame=10)
    assert station.upload([terrain]) == UNSUPPORTED_FRAME


@pytest.mark.parametrize(("kind", "held"), [(Kind.ARDUPLANE, 3), (Kind.PX4, 7)])
def test_a_count_shortens_the_mission_of_ardupilot_alone(kind, held):
    station = station_at(kind)
    station.upload(MISSION)
    station.connection.mav.mission_count_send(1, 1, 3, 0)
    station.wait(0.3)
    assert len(station.connection.autopilot.lists.items[0]) == held


@pytest.mark.parametrize(("kind", "first"), [(Kind.ARDUPLANE, 1400), (Kind.PX4, 400)])
def test_items_replace_earlier_ones_at_once_or_at_the_end(kind, first):
    station = station_at(kind)
    station.upload(MISSION)
    station.connection.mav.mission_count_send(1, 1, len(MISSION), 0)
    station.send_item(MISSION[0], 0)
    station.send_item(at(0, 1400), 1)
    station.wait(0.3)
    assert station.connection.autopilot.lists.items[0][1].x == at(0, first).x


def test_a_duplicate_is_an_invalid_sequence_for_ardupilot_and_nothing_for_px4(station):
    is_ardupilot = station.connection.autopilot.kind is Kind.ARDUPLANE
    station.connection.mav.mission_count_send(1, 1, 2, 0)
    station.send_item(MISSION[0], 0)
    station.send_item(MISSION[0], 0)
    station.wait(0.1)
    assert station.acks == ([INVALID_SEQUENCE] if is_ardupilot else [])
    station.send_item(MISSION[1], 1)
    station.wait(0.1)
    assert station.acks[-1] == ACCEPTED


@pytest.mark.parametrize(("kind", "asked"), [(Kind.ARDUPLANE, 1 + 3), (Kind.PX4, 1 + 12)])
def test_an_item_is_asked_for_again_and_the_upload_given_up(kind, asked):
    station = station_at(kind)
    connection = station.connection
    connection.mav.mission_count_send(1, 1, 2, 0)
    kinds = [message.get_type() for message in connection.wait(3.4)]
    assert sum(name.startswith("MISSION_REQUEST") for name in kinds) == pytest.approx(asked, abs=2)
    station.wait(6.0)
    assert station.acks == [CANCELLED]
    assert station.texts == ["Mission upload timeout"]
    assert station.download() == []


def test_reading_is_denied_during_an_upload():
    station = station_at()
    station.connection.mav.mission_count_send(1, 1, 2, 0)
    station.connection.mav.mission_request_list_send(1, 1, 0)
    station.wait(0.2)
    assert station.acks == [DENIED]


def test_another_station_cannot_break_into_an_upload():
    station = station_at()
    second = connected(station.connection.autopilot, system=254)
    station.connection.mav.mission_count_send(1, 1, 2, 0)
    station.wait(0.1)
    assert second.upload([MISSION[0]]) == DENIED


def test_an_item_without_an_upload_is_an_error():
    station = station_at()
    station.send_item(MISSION[0], 0)
    station.wait(0.1)
    assert station.acks == [ERROR]


@pytest.mark.parametrize(("kind", "result"), [(Kind.ARDUPLANE, ERROR), (Kind.PX4, ACCEPTED)])
def test_ardupilot_clears_no_mission_that_runs(kind, result):
    station = station_at(kind)
    items = [*MISSION, at(0, 3000, z=500, command=21)]
    station.upload(items)
    assert station.command(300) == 0
    station.connection.mav.mission_clear_all_send(1, 1, 0)
    station.wait(0.2)
    assert station.acks[-1] == result
    assert bool(station.connection.autopilot.lists.items[0]) == (result == ERROR)


def test_84_corners_in_all_and_672_bytes():
    """A polygon of 84 corners has room by its count, and none by its bytes."""
    station = station_at()
    for corners, result in ((85, NO_SPACE), (84, ERROR), (83, ACCEPTED)):
        assert station.upload(polygon(corners), kind=1) == result
    station.wait(0.2)
    assert station.texts == ["Only 84 items are supported", "Fence exceeds storage size"]
    assert storage_bytes(polygon(83)) == 4 + 2 + 83 * 8
    assert storage_bytes(polygon(84)) > 672


def test_px4_takes_64_corners():
    station = station_at(Kind.PX4)
    assert station.upload(polygon(64), kind=1) == ACCEPTED
    assert station.upload(polygon(65), kind=1) == NO_SPACE


@pytest.mark.parametrize(
    ("items", "text"),
    [
        (polygon(2), "Invalid vertex count (2)"),
        (polygon(5)[:4], "Incorrect item count"),
        ([*polygon(4)[:3], *polygon(4, command=5001)[3:]], "Received incorrect vertex type"),
        ([at(0, 0, command=5004, params=(0.0,) * 4)], "Non-positive circle radius"),
    ],
)
def test_a_fence_that_is_none_is_refused_as_a_whole(items, text):
    station = station_at()
    station.upload(polygon(5), kind=1)
    assert station.upload(items, kind=1) == ERROR
    station.wait(0.2)
    assert station.texts == [text, "Fence validation failed"]
    assert len(station.download(kind=1)) == 5


@pytest.mark.parametrize("seed", range(5))
def test_an_upload_survives_loss_and_delay(station, seed):
    slow = Faults(delay_s=0.3, jitter_s=0.3, loss=0.05)
    lossy = connected(station.connection.autopilot, up=slow, down=slow, seed=seed)
    result = lossy.upload(MISSION, quiet_s=9.0)
    # The last acknowledgement can be lost, and a late duplicate is then an error.
    assert result in (ACCEPTED, ERROR, None)
    assert len(station.connection.autopilot.lists.items[0]) == len(MISSION)


def test_a_dead_link_ends_the_upload_on_both_sides(station):
    dead = connected(station.connection.autopilot, up=Faults(delay_s=0.1, dies_s=0.5))
    assert dead.upload(MISSION, quiet_s=10.0) in (None, CANCELLED)
    assert not station.connection.autopilot.lists.is_receiving(0)


def test_the_same_seed_loses_the_same_messages():
    def session(seed):
        station = station_at(up=Faults(0.1, 0.4, 0.3), down=Faults(0.1, 0.4, 0.3), seed=seed)
        station.upload(MISSION, quiet_s=9.0)
        return station.connection.now_s, station.acks

    assert session(4) == session(4)
    assert session(4) != session(5)
