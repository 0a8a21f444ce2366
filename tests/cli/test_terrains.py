"""Every planner on every terrain of the benchmarks: ``check`` repeats the terms of its path."""

import json

import pytest

from bench.scenarios import EMBEDDED, SYNTHETIC, TILES, names, problem, source_of
from pathgene.host.cli import main
from pathgene.host.planners import PLANNERS

from .conftest import assert_check_agrees


#: Generations of short searches, whose paths are evaluated like any other.
SHORT = {
    "ga-fpga": 25,
    "ga-chip": 25,
    "ga-pc": 25,
    "astar": 2,
    "fpa": 25,
    "fpa-2opt": 25,
    "ga-dp": 3,
    "ga-auv": 3,
}


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize(
    "name",
    [
        "canyon",
        *(
            pytest.param(name, marks=pytest.mark.long)
            for name in (*SYNTHETIC, EMBEDDED, *TILES)
            if name != "canyon"
        ),
    ],
)
def test_check_agrees(name, planner, tmp_path, capsys):
    if name in TILES and name not in names():
        pytest.skip(f"The elevation tile of {name} is not beside the repository.")
    flown = problem(name)
    start, goal = (",".join(map(str, point)) for point in (flown.start, flown.goal))
    zones = [
        part
        for zone in flown.zones
        for part in ("--nofly-circle", f"{zone.x_m},{zone.y_m},{zone.radius_m}")
    ]
    status = main(
        [
            "plan",
            "--terrain",
            source_of(name),
            "--fill-voids",
            "--start",
            start,
            "--goal",
            goal,
            *zones,
            "--planner",
            planner,
            "--generations",
            str(SHORT[planner]),
            "--seed",
            "3",
            "--out",
            str(tmp_path),
            "--no-picture",
            "--json",
        ]
    )
    summary = json.loads(capsys.readouterr().out)
    assert status == (0 if summary["feasible"] else 1)
    # The problem of the benchmarks.
    assert summary["waypoints"][0] == pytest.approx(flown.start)
    assert_check_agrees(tmp_path, summary, capsys)
