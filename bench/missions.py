"""Checks of missions of other programs, by their number of items: processor seconds."""

from __future__ import annotations

import time
from statistics import median

import numpy as np

from bench.report import Options, Report
from pathgene.host.formats.registry import mission_in
from pathgene.host.mission.foreign.check import check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


__all__ = ["run"]

#: Items of the missions, and checks of each that are measured after a first one.
ITEMS, _CHECKS = (10, 100, 600), 7
# Nodes of a side, their distance, and the south-west corner of the land in Austria.
_NODES, _CELL_M = 201, 60.0
_CRS, _CORNER = "EPSG:32633", (400_000.0, 5_200_000.0)
_NOWHERE = (0.0, 0.0, 0.0)
# Lines that are flown, and the height above the highest ground.
_LINES, _ABOVE_M = 20, 60.0


def land() -> Terrain:
    """Return hills of 12 by 12 km."""
    y, x = np.mgrid[:_NODES, :_NODES]
    heights = 400 + 100 * np.sin(x / 15) * np.cos(y / 12)
    return Terrain("hills", heights, _CELL_M, _CELL_M, _CRS, _CORNER)


def mission(terrain: Terrain, items: int, height_m: float) -> bytes:
    """Return a list of waypoints along parallel lines, as MAVProxy writes it."""
    lines = min(_LINES, max(items // 5, 1))
    side = -(-items // lines)
    east = np.linspace(1000.0, terrain.width_m - 1000.0, side)
    rows = ["QGC WPL 110"]
    for number in range(items + 1):
        line, at = divmod(max(number - 1, 0), side)
        x = east[at if line % 2 == 0 else side - 1 - at]
        y = 1000.0 + line * (terrain.height_m - 2000.0) / max(lines - 1, 1)
        lat, lon = (float(value) for value in terrain.to_geographic(x, y))
        z = height_m if number else float(terrain.ground(x, y))
        rows.append(f"{number}\t{not number:d}\t0\t16\t0\t0\t0\t0\t{lat!r}\t{lon!r}\t{z!r}\t1")
    return ("\n".join(rows) + "\n").encode()


def run(options: Options) -> Report:
    """Measure the checks of missions with and without faults."""
    report = Report(
        "Checks of missions",
        ("items", "mission", "faults", "least, s", "median, s"),
        notes=[
            f"Processor seconds of reading a list of waypoints and judging it, {_CHECKS} times "
            "after a first one, over hills of 12 by 12 km with one zone. The missions with faults "
            "fly through the tops of the hills."
        ],
    )
    terrain = land()
    zone = Circle(0.5 * terrain.width_m, 600.0, 200.0)
    problem = FlightProblem(terrain, _NOWHERE, _NOWHERE, zones=(zone,))
    top_m = float(np.max(terrain.elevation))
    for items in ITEMS:
        for name, above_m in (("without faults", _ABOVE_M), ("with faults", -_ABOVE_M)):
            content = mission(terrain, items, top_m + above_m)
            seconds, faults = [], 0
            for _ in range(1 + _CHECKS):
                began = time.process_time()
                read = mission_in(content, "m.waypoints")
                assert read is not None
                faults = len(check_mission(read, problem).report["faults"])
                seconds.append(time.process_time() - began)
            report.rows.append((items, name, faults, min(seconds[1:]), median(seconds[1:])))
    return report
