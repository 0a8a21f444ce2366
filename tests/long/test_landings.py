"""Landings on real land in several directions, flown by both simulated autopilots."""

import re

import numpy as np
import pytest

from bench.scenarios import EMBEDDED, TILES, names_of, source_of
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import load
from pathgene.sim.autopilot.pilot import Kind, Mode
from tests.support.autopilot.landings import fly, plan_of


# Landings that are flown on each map, and maximum number of attempts to find them.
_FLOWN, _TRIED = 4, 300


def landings(name):
    """Yield problems and flight plans of landings with room, by a seed."""
    terrain = load(source_of(name))
    rng = np.random.default_rng(7)
    for _ in range(_TRIED):
        x, y = rng.uniform(0.2, 0.8, 2) * (terrain.width_m, terrain.height_m)
        away, angle = rng.uniform(1500, 3500), rng.uniform(0, 2 * np.pi)
        heading = rng.uniform(0, 360)
        steps = away + np.linspace(-200, 1700, 40)
        along = np.column_stack((x + steps * np.cos(angle), y + steps * np.sin(angle)))
        if (along < 300).any() or (along > (terrain.width_m - 300, terrain.height_m - 300)).any():
            continue
        ground = np.array([terrain.ground(*place) for place in along])
        if not np.isfinite(ground).all():
            continue
        z = float(ground.max()) + 90.0
        problem = Problem(terrain, (*along[-4], z), (*along[4], z))
        try:
            yield problem, plan_of(problem, (x, y, heading))
        except NoRoomError:
            continue


@pytest.mark.long
@pytest.mark.parametrize("name", [EMBEDDED, *TILES])
def test_the_autopilots_land_and_go_around(name):
    if not names_of([name]):
        pytest.skip(f"the elevation tile of {name} is not next to the project")
    flown = 0
    for problem, plan in landings(name):
        flown += 1
        flights = {kind: fly(problem, plan, kind) for kind in Kind}
        for kind, flight in flights.items():
            assert flight.autopilot.pilot.mode is Mode.LANDED
            assert np.nanmin(flight.share) >= 0.5, (kind, problem.goal, plan.end.way[-1])
            assert abs(flight.touch_down_m[1]) < 1.0
        # It flares from 3 m on, and its glide leads to 75 m before the place.
        assert abs(flights[Kind.ARDUPLANE].touch_down_m[0]) < 40.0
        assert flights[Kind.PX4].over_m < 10.0
        around = fly(problem, plan, Kind.ARDUPLANE, go_around_m=20.0)
        assert np.nanmin(around.share) >= 0.5
        room = re.search(r"MIS_LND_ABRT_ALT to (\d+) m", plan.notes[-1])
        if room and float(room[1]) + 3.0 < plan.end.circle.z_m - plan.end.way[-1][2]:
            values = {"MIS_LND_ABRT_ALT": float(room[1])}
            low_m = float(room[1]) + 3.0
            around = fly(problem, plan, Kind.PX4, go_around_m=low_m, parameters=values)
            assert np.nanmin(around.share) >= 0.5
        if flown == _FLOWN:
            return
    assert flown
