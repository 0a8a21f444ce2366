"""QGC WPL 110, read by MAVProxy's loader."""

import numpy as np
import pytest
from pymavlink import mavwp

from pathgene.host.errors import InputError
from pathgene.host.formats import waypoints
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut
from pathgene.host.formats.flight_plan import WAYPOINT
from pathgene.host.formats.waypoints import waypoints_text
from tests.support.host.earth import agree
from tests.support.host.missions import SEEDS, flight, make_mission


def test_mavwp_reads_the_same_mission(tmp_path):
    file = tmp_path / "path.waypoints"
    for seed in SEEDS:
        problem, path = make_mission(seed)
        plan = flight(seed)
        file.write_text(waypoints_text(plan))
        loader = mavwp.MAVWPLoader()
        assert loader.load(str(file)) == len(plan.items) + 1
        home, *items = (loader.wp(number) for number in range(loader.count()))

        assert (home.x, home.y, home.z) == plan.home
        assert (home.x, home.y) == (items[0].x, items[0].y)
        assert home.z == problem.terrain.ground(*path[0, :2])
        assert (home.seq, home.current, home.frame, home.command) == (0, 1, 0, 16)
        assert [item.seq for item in items] == list(range(1, len(items) + 1))
        for item, wanted in zip(items, plan.items, strict=True):
            assert (item.frame, item.current, item.autocontinue) == (0, 0, 1)
            assert item.command == wanted.command
            params = [item.param1, item.param2, item.param3, item.param4]
            assert params == [param or 0 for param in wanted.params]
            assert (item.x, item.y, item.z) == (wanted.lat, wanted.lon, wanted.alt_m)
        for place in path[[0, -1]]:
            assert any(
                item.z == place[2]
                and agree(problem.terrain, place[None], np.array([item.x]), np.array([item.y]))
                for item in items
                if item.command == WAYPOINT
            )


def test_rows_have_twelve_columns_and_no_exponents():
    for seed in SEEDS:
        header, *rows = waypoints_text(flight(seed)).splitlines()
        assert header == "QGC WPL 110"
        for row in rows:
            assert row.count("\t") == 11
            assert "e" not in row


HOME = "0\t1\t0\t16\t0\t0\t0\t0\t60.0\t10.05\t100\t1"
CORNERS = ((60.0, 10.04), (60.0, 10.06), (60.01, 10.05))


def row(command, size, place):
    return f"5\t0\t3\t{command}\t{size}\t0\t0\t0\t{place[0]}\t{place[1]}\t0\t1"


def fence(*rows):
    content = Content("\r\n".join(("QGC WPL 110", HOME, *rows, "")).encode())
    assert waypoints.recognises(content)
    return list(waypoints.features(content))


def test_reads_polygons_and_circles_of_a_fence():
    polygons = [row(command, 3, place) for command in (5001, 5002, 5002) for place in CORNERS]
    circles = [row(5003, 250.5, CORNERS[0]), row(5004, 80, CORNERS[1])]
    found = fence(row(5000, 0, CORNERS[0]), *circles, *polygons)
    assert [each.keeps_in for each in found] == [True, False, True, False, False]
    assert [each.radius_m for each in found] == [250.5, 80, None, None, None]
    assert found[0].rings == (((10.04, 60.0),),)
    assert found[2].rings == (tuple((lon, lat) for lat, lon in CORNERS),)
    assert found[4].label == "fence 5"
    assert found[0].name == "outside of fence 1"


def test_waypoints_among_fences_are_left_out():
    *_, left_out = fence(row(16, 0, CORNERS[0]), *(row(5001, 3, place) for place in CORNERS))
    assert left_out == LeftOut("1 waypoints", "a waypoint is not an area")


def test_a_mission_has_no_fence():
    reason = (
        "there is no fence in it, only waypoints; save the fence of the ground station instead."
    )
    with pytest.raises(InputError) as caught:
        fence(row(16, 0, CORNERS[0]))
    assert str(caught.value) == reason


@pytest.mark.parametrize(
    ("rows", "bad"),
    [
        (
            [row(5001, 3, place) for place in CORNERS[:2]],
            Bad("fence 2", "line 4: its polygon must have 3 corners of the same kind."),
        ),
        (
            [row(5001, 2, place) for place in CORNERS[:2]],
            Bad("fence 2", "line 4: a polygon must have three corners or more."),
        ),
        (
            [row(5001, 3, CORNERS[0]), row(5002, 3, CORNERS[1]), row(5001, 3, CORNERS[2])],
            Bad("fence 2", "line 4: its polygon must have 3 corners of the same kind."),
        ),
        (
            [row(5003, 0, CORNERS[0])],
            Bad("fence 2", "line 4: the radius of a circle must be above 0 m, not 0."),
        ),
        ([row(5003, 5, ("north", 10))], Bad("line 4", "it is no row of 12 numbers.")),
        (["5\t0\t3\t5003"], Bad("line 4", "it is no row of 12 numbers.")),
    ],
)
def test_names_a_bad_fence_and_reads_the_others(rows, bad):
    found = fence(row(5004, 80, CORNERS[1]), *rows)
    assert bad in found
    assert sum(isinstance(part, Feature) for part in found) == 1
