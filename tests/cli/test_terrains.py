"""Every planner on every terrain of the benchmarks: check says the same of its path."""

import json

import pytest

from bench.scenarios import EMBEDDED, SYNTHETIC, TILES, names, problem, source_of
from host.cli import main
from host.planners import PLANNERS


TERMS = (
    "fitness",
    "penalty",
    "cost",
    "length_m",
    "mean_altitude_m",
    "fuel_N",
    "feasible",
    "feasible_at_ds",
    "minimum_clearance_m",
    "impossible_arcs",
    "waypoints",
)
#: Short searches: what they find is evaluated like any other path.
SHORT = {"ga-fpga": 25, "ga-pc": 25, "astar": 2, "fpa": 25, "fpa-2opt": 25, "ga-dp": 3, "ga-auv": 3}


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
            "--json",
        ]
    )
    summary = json.loads(capsys.readouterr().out)
    assert status == (0 if summary["feasible"] else 1)
    # The same problem as the benchmarks'.
    assert summary["waypoints"][0] == pytest.approx(flown.start)
    main(["check", "--path", str(tmp_path / "summary.json"), "--json"])
    report = json.loads(capsys.readouterr().out)
    assert {term: report[term] for term in TERMS} == {term: summary[term] for term in TERMS}
