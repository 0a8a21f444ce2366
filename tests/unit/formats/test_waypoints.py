"""QGC WPL 110, read by MAVProxy's loader."""

import numpy as np
from pymavlink import mavwp

from pathgene.host.formats.waypoints import waypoints_text
from tests.support.host.earth import agree
from tests.support.host.missions import flight_of


def test_mavwp_reads_the_same_mission(missions, tmp_path):
    file = tmp_path / "path.waypoints"
    for problem, path in missions:
        plan = flight_of(problem, path)
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
        first, last = items[0], items[-1]
        lat, lon = np.array([(first.x, first.y), (last.x, last.y)]).T
        assert agree(problem.terrain, path[[0, -1]], lat, lon)
        assert [first.z, last.z] == path[[0, -1], 2].tolist()


def test_rows_have_twelve_columns_and_no_exponents(missions):
    for mission in missions[:20]:
        header, *rows = waypoints_text(flight_of(*mission)).splitlines()
        assert header == "QGC WPL 110"
        for row in rows:
            assert row.count("\t") == 11
            assert "e" not in row
