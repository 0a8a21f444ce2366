"""A problem refuses every bad input with a message."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


FOX = aircraft.load("silver-fox")
START, GOAL = (100.0, 100.0, 200.0), (900.0, 1400.0, 250.0)


def terrain(elevation=None, dx_m=50.0, dy_m=75.0):
    elevation = np.full((21, 31), 100.0) if elevation is None else elevation
    return Terrain(
        name="world", elevation=elevation, dx_m=dx_m, dy_m=dy_m, crs=None, origin=(0.0, 0.0)
    )


def problem(start=START, goal=GOAL, where=None, **options):
    return Problem(terrain() if where is None else where, start, goal, FOX, **options)


def test_defaults():
    made = problem()
    assert (made.ds_m, made.wind, made.zones) == (25.0, (0.0, 0.0), ())
    assert made.nofly_raster.shape == (21, 31)
    assert not made.nofly_raster.any()
    assert made.rules == Rules()
    assert not made.as_paper


def test_values_become_tuples_of_floats():
    made = problem(
        start=[100, 100, 200],
        goal=np.array([900, 1400, 250]),
        wind=[1, 2],
        zones=[Circle(1000, 0, 100)],
        ds_m=10,
    )
    assert (made.start, made.goal, made.wind) == (START, GOAL, (1.0, 2.0))
    assert type(made.goal[0]) is float
    assert made.zones == (Circle(1000, 0, 100),)
    assert made.ds_m == 10.0


def test_rasters_are_made_once_and_cannot_be_written():
    zones = (Circle(1000, 0, 100), Circle(500, 500, 100, lower_m=400.0))
    made = problem(zones=zones, rules=Rules())
    assert made.nofly_raster is made.nofly_raster
    assert made.roof is not None
    assert made.roof is made.roof
    assert made.nofly_raster[0, 20]
    with pytest.raises(ValueError, match="read-only"):
        made.nofly_raster[0, 0] = True


def test_heights_above_ground():
    elevation = np.full((21, 31), 100.0)
    elevation[1, 2] = 130.0
    made = Problem(terrain(elevation), (100, 75, 20), (900, 1400, 0), FOX, ds_m=5.0, agl=True)
    assert (made.start, made.goal) == ((100, 75, 150), (900, 1400, 100))
    assert made.ds_m == 5.0


def test_geographic_ends():
    placed = dataclasses.replace(terrain(), crs="EPSG:32616", origin=(740_000.0, 4_010_000.0))
    ends = [(*placed.to_geographic(x, y), z) for x, y, z in (START, GOAL)]
    made = Problem(placed, *ends, geo=True)
    assert made.start == pytest.approx(START, abs=1e-6)
    assert made.goal == pytest.approx(GOAL, abs=1e-6)
    raised = Problem(placed, *[(*end[:2], 40) for end in ends], geo=True, agl=True)
    assert (raised.start[2], raised.goal[2]) == (140, 140)
    with pytest.raises(InputError, match=r"^The terrain 'world' has no coordinate reference "):
        Problem(terrain(), *ends, geo=True)


def test_aircraft_by_name():
    assert Problem(terrain(), START, GOAL).aircraft == FOX
    assert Problem(terrain(), START, GOAL, "heron").aircraft == aircraft.load("heron")


@pytest.mark.parametrize("point", [(0, 0, 200), (1500, 1500, 200)])
def test_the_edge_of_the_map_is_on_it(point):
    assert problem(start=point).start == point


def test_a_point_on_the_ground_is_not_inside_it():
    assert problem(start=(100, 100, 100)).start[2] == 100


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start": (0, 0, math.nan)}, r"^The start must be 3 finite numbers, not \(0, 0, nan\)\.$"),
        ({"goal": (0, 0)}, r"^The goal must be 3 finite numbers, not \(0, 0\)\.$"),
        ({"goal": "abc"}, r"^The goal must be 3 finite numbers, not 'abc'\.$"),
        ({"goal": None}, r"^The goal must be 3 finite numbers, not None\.$"),
        ({"wind": (math.inf, 0)}, r"^The wind must be 2 finite numbers, not \(inf, 0\)\.$"),
        ({"zones": [3]}, r"^The zones must be a list of no-fly zones, not \[3\]\.$"),
        (
            {"zones": Circle(1000, 0, 100)},
            (
                r"^The zones must be a list of no-fly zones, not "
                r"Circle\(x_m=1000\.0, y_m=0\.0, radius_m=100\.0\)\.$"
            ),
        ),
        ({"ds_m": "x"}, r"^The sampling step must be a number, not 'x'\.$"),
        ({"ds_m": 0}, r"^The sampling step must be a positive number of metres, not 0\.$"),
        ({"ds_m": -3.0}, r"^The sampling step must be a positive number of metres, not -3\.$"),
        ({"ds_m": math.nan}, r"^The sampling step must be a positive number of metres, not nan\.$"),
        (
            {"ds_m": 1e4},
            r"^The sampling step of 10000 m is longer than the way from start to goal, "
            r"[\d.]+ m; reduce it\.$",
        ),
        ({"ds_m": 1e-4}, r"^The sampling step must be at least 0\.001 m, not 0\.0001 m\.$"),
        (
            {"start": (-0.1, 0, 200)},
            (
                r"^The start at \(-0\.1, 0\) is outside the map, which reaches "
                r"from \(0, 0\) to \(1500, 1500\) m\.$"
            ),
        ),
        (
            {"goal": (0, 1500.1, 200)},
            (
                r"^The goal at \(0, 1500\.1\) is outside the map, which reaches "
                r"from \(0, 0\) to \(1500, 1500\) m\.$"
            ),
        ),
        (
            {"start": (100, 100, 99.9)},
            (
                r"^The start at an altitude of 99\.9 m is inside the ground, "
                r"which is at 100 m there; raise it, or give --agl if 99\.9 m is its height "
                r"above the ground\.$"
            ),
        ),
        (
            {"goal": (1000, 0, 200), "zones": (Circle(1000, 0, 100),)},
            r"^The goal at \(1000, 0\) is inside a no-fly zone; move it or the zone\.$",
        ),
        ({"goal": START}, r"^Start and goal are the same point; move one of them\.$"),
        (
            {"wind": (0, -23)},
            (
                r"^A wind of 23 m/s is not below the airspeed of Silver Fox-like, "
                r"23 m/s; reduce it or choose a faster UAV\.$"
            ),
        ),
    ],
)
def test_refuses_bad_problems(options, message):
    with pytest.raises(InputError, match=message):
        problem(**options)


@pytest.mark.parametrize(("terrain", "kind"), [(None, "NoneType"), ("canyon", "str")])
def test_refuses_what_is_no_terrain(terrain, kind):
    with pytest.raises(InputError) as caught:
        Problem(terrain, START, GOAL)
    assert str(caught.value) == (
        f"The terrain must be a Terrain, not of the type {kind}; make one with Terrain.load."
    )


@pytest.mark.parametrize("agl", [False, True])
def test_refuses_ends_over_a_void(agl):
    elevation = np.full((21, 31), 100.0)
    elevation[1, 2] = np.nan
    with pytest.raises(
        InputError,
        match=r"^The start at \(100, 100\) is over a void of the "
        r"terrain; move it, or fill the voids "
        r"\(--fill-voids\)\.$",
    ):
        Problem(terrain(elevation), START, GOAL, FOX, agl=agl)


def test_refuses_heights_above_ground_outside_the_map():
    with pytest.raises(
        InputError,
        match=r"^The goal at \(9000, 0\) is outside the map, which "
        r"reaches from \(0, 0\) to \(1500, 1500\) m\.$",
    ):
        Problem(terrain(), START, (9000, 0, 10), FOX, agl=True)
