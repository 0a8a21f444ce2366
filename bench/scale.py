"""Plans over large maps, among many zones and through via points: seconds, memory and F.

Each row is a process of its own, ``python -m bench.scale TERRAIN PLANNER ZONES VIA``, which prints
its figures as JSON.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.report import Options, Report
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.plan import plan
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import load


__all__ = ["CASES", "PLANNERS", "land", "mission", "run"]

Floats = NDArray[np.float64]

PLANNERS = ("astar", "fpa-2opt", "ga-chip")
#: Nodes of a side, zones and via points of each case.
CASES = (
    (512, 0, 0),
    (512, 20, 0),
    (512, 1_000, 0),
    (512, 0, 5),
    (2_000, 0, 0),
    (2_000, 1_000, 0),
    (5_000, 0, 0),
    (5_000, 1_000, 0),
    (5_000, 20, 5),
)
_CELL_M, _RELIEF_M = 30.0, 900.0
# Longest waves of the ground, in nodes.
_LONGEST = 128
# From start to goal, metres east and north, and the height of both over the ground.
_EAST_M, _NORTH_M, _END_M = 9_000.0, 6_000.0, 60.0
# Circles: radii, distance from the points of the way, and the square that they lie in, metres.
_RADII_M, _ROOM_M, _SQUARE_M = (40.0, 280.0), 900.0, 14_000.0
_MOST_S = 150
# Seconds of a first plan after which no second one follows.
_LONG_S = 20.0


def land(nodes: int, seed: int = 0) -> Floats:
    """Return fractal heights, (nodes, nodes) metres: waves from 128 nodes down to 2."""
    rng = np.random.default_rng(seed)
    heights = np.zeros((nodes, nodes))
    wave, amplitude = _LONGEST, 1.0
    while wave >= 2:
        values = rng.standard_normal((nodes // wave + 2,) * 2)
        at = np.arange(nodes) / wave
        first = at.astype(np.int64)
        share = at - first
        share = share * share * (3 - 2 * share)
        rows = values[first] + share[:, None] * (values[first + 1] - values[first])
        heights += amplitude * (rows[:, first] + share * (rows[:, first + 1] - rows[:, first]))
        wave, amplitude = wave // 2, 0.5 * amplitude
    raised: Floats = _RELIEF_M * (heights - heights.min()) / np.ptp(heights)
    return raised


def mission(terrain: Any, zones: int, via: int) -> MissionProblem:
    """Return a flight of 11 km across the middle of a map, through ``via`` points in a zigzag."""
    middle = np.array((0.5 * terrain.width_m, 0.5 * terrain.height_m))
    half = 0.5 * np.array((_EAST_M, _NORTH_M))
    shares = np.linspace(-1, 1, via + 2)
    aside = np.where(np.arange(via + 2) % 2 == 1, 0.25, 0.0) * np.append(np.ones(via + 1), 0.0)
    places = middle + shares[:, None] * half + aside[:, None] * np.array((-half[1], half[0]))
    rng = np.random.default_rng(1)
    circles: list[Zone] = []
    while len(circles) < zones:
        x, y = (middle + rng.uniform(-0.5, 0.5, 2) * _SQUARE_M).tolist()
        radius = float(rng.uniform(*_RADII_M))
        if np.hypot(*(places - (x, y)).T).min() > radius + _ROOM_M:
            circles.append(Zone.circle(x, y, radius))
    points = [(x, y, float(terrain.ground(x, y)) + _END_M) for x, y in places.tolist()]
    problem = Problem(terrain, points[0], points[-1], zones=circles)
    return MissionProblem(problem, tuple(points[1:-1]))


def measure(file: str, planner: str, zones: int, via: int) -> dict[str, Any]:
    """Plan twice over a terrain that is loaded once; return processor seconds, MB and F.

    A plan of more than 20 s is not repeated.
    """
    options: dict[str, Any] = {"board": "model:"} if planner == "ga-chip" else {}
    began = 0.0  # The processor time of a process begins with it.
    terrain = load(file)
    seconds: list[float] = []
    fitness = None
    while not seconds or (len(seconds) < 2 and seconds[0] < _LONG_S):
        found = plan(mission(terrain, zones, via), planner, fallback="none", **options)
        evaluation = found.evaluation
        fitness = evaluation.fitness if evaluation.feasible else None
        now = time.process_time()
        seconds.append(now - began)
        began = now
    first_s, second_s = (*seconds, None)[:2]
    return {"first_s": first_s, "second_s": second_s, "peak_MB": _peak_mb(), "fitness": fitness}


def _peak_mb() -> float:
    """Return the largest resident memory of this process.

    The figure of ``getrusage`` also has the memory of the process that has started it.
    """
    status = Path("/proc/self/status").read_text()
    (kilobytes,) = re.findall(r"^VmHWM:\s+(\d+) kB$", status, re.MULTILINE)
    return int(kilobytes) / 1024


def run(options: Options) -> Report:
    """Measure every case with every planner, each in a process of its own."""
    report = Report(
        "Plans over large maps, among many zones, through via points",
        ("nodes", "zones", "via", "planner", "first, s", "second, s", "peak, MB", "F"),
        notes=[
            "Processor seconds: of a first plan in a process, with its imports and the loading of "
            "the terrain, and of a second one over the same terrain, after a first one of up to "
            f"{_LONG_S:.0f} s. Peak: the resident memory of the process. A process of more than "
            f"{_MOST_S} s of wall time is ended, and its row is empty. Fractal ground with cells "
            "of 30 m in an uncompressed .npz of single precision, a flight of 11 km across its "
            "middle by the rules, and circles of 40 to 280 m in a square of 14 km. No fallback; a "
            "mission plans its legs one after another, and F is of the whole. Code was compiled "
            "before.",
        ],
    )
    with tempfile.TemporaryDirectory() as folder:
        for nodes in sorted({case[0] for case in CASES}):
            file = Path(folder) / f"{nodes}.npz"
            heights = land(nodes).astype(np.float32)
            np.savez(file, elevation=heights, dx_m=_CELL_M, dy_m=_CELL_M)
            cases = [case for case in CASES if case[0] == nodes and options.only in str(case)]
            for _, zones, via in cases:
                for planner in PLANNERS:
                    if len(report.rows) < len(PLANNERS):
                        _alone(file, planner, zones, via)  # Compiles.
                    cells = _cells(_alone(file, planner, zones, via))
                    report.rows.append((nodes, zones, via, planner, *cells))
            file.unlink()
    return report


def _cells(row: dict[str, Any] | None) -> tuple[object, ...]:
    """Return seconds, memory and F of a row; dashes for a process that was ended."""
    if row is None:
        return ("-",) * 4
    second = "-" if row["second_s"] is None else round(row["second_s"], 2)
    found = "no path" if row["fitness"] is None else row["fitness"]
    return round(row["first_s"], 2), second, round(row["peak_MB"]), found


def _alone(file: Path, planner: str, zones: int, via: int) -> dict[str, Any] | None:
    try:
        done = subprocess.run(
            [sys.executable, "-m", "bench.scale", str(file), planner, str(zones), str(via)],
            stdout=subprocess.PIPE,
            check=True,
            timeout=_MOST_S,
        )
    except subprocess.TimeoutExpired:
        return None
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return row


if __name__ == "__main__":
    file, planner, zones, via = sys.argv[1:]
    print(json.dumps(measure(file, planner, int(zones), int(via))))
