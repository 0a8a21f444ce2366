"""The table of replans for a few scenarios, and the scenarios themselves."""

import dataclasses
import math

import numpy as np
import pytest

from bench import campaign, chip_replans
from bench.chip_replans import ROWS, scenario
from bench.report import Options
from bench.scenarios import problem
from pathgene.host.errors import InputError
from tests.support.host.pool import Pool


def test_replans_are_beside_astar(monkeypatch):
    monkeypatch.setattr(chip_replans, "terrains", lambda: ["canyon"])
    monkeypatch.setattr(campaign, "ProcessPoolExecutor", Pool)
    report = chip_replans.run(Options(seeds=2, only="paper mode"))
    names = [name for name in ROWS if "paper mode" in name]
    assert [row[0] for row in report.rows] == names
    two, repaired, retried, of_board, *cold = report.rows
    assert of_board[1].split(" of ")[1].startswith("4")
    assert two[1].split(" of ")[1].startswith("4")
    # Repair and retry do not change the findings of the first run.
    for name in names[1:3]:
        assert [each["cycles"] for each in report.data[names[0]] if each["feasible"]] == [
            own["cycles"]
            for own, first in zip(report.data[name], report.data[names[0]], strict=True)
            if first["feasible"]
        ]
    # A repair takes no cycles.
    assert repaired[3:] == two[3:]
    assert float(two[3]) <= float(two[4]) < 157
    assert float(retried[3]) >= float(two[3])
    assert [float(row[3]) for row in cold] == pytest.approx([200, 500], abs=2)
    assert [row[5:] for row in cold] == [("-",) * 4] * 2
    for each in report.data[names[0]]:
        line_ms = each["whole_ms"] - (each["cycles"] + each["drawing"]) / 1e5
        # 200 to 700 bytes, so no map is sent. A poll may miss the end by the time of a poll.
        assert 0.7 < line_ms < 2.4


@pytest.mark.parametrize("number", range(8))
def test_a_disc_is_on_the_path_ahead_and_clear_of_both_ends(number):
    flown = problem("canyon")
    (x0, y0, z0), (x1, y1, _) = flown.start, flown.goal
    path = np.array([(x0, y0, z0), (x0, 0.5 * (y0 + y1), z0 + 300), (x1, y1, z0 + 300)])
    drawn = scenario(flown, path, (number,))
    straight_m = math.hypot(x1 - x0, y1 - y0)
    assert 0.02 * straight_m <= drawn.disc.radius_m <= 0.08 * straight_m
    centre = drawn.disc.x_m, drawn.disc.y_m
    clear_m = drawn.disc.radius_m + 2 * flown.limits.turn_radius_m
    assert math.dist(centre, drawn.start[:2]) >= clear_m
    assert math.dist(centre, flown.goal[:2]) >= clear_m
    assert centre[1] > drawn.start[1]
    assert drawn.start[2] >= z0
    if drawn.start[1] < path[1, 1]:
        assert drawn.heading_deg == pytest.approx(0)
        assert drawn.start[0] == pytest.approx(x0)
    assert drawn == scenario(flown, path, (number,))
    assert drawn != scenario(flown, path, (number + 1,))


@pytest.mark.ci
def test_a_path_without_room_is_refused():
    flown = problem("canyon")
    near = dataclasses.replace(flown, goal=(flown.start[0] + 30, *flown.start[1:]))
    path = np.array([near.start, near.goal])
    with pytest.raises(InputError, match=r"^The path leaves no room for a disc\.$"):
        scenario(near, path, (0,))
