"""The same land in six reference systems and units has the same verdicts, lengths and plans."""

import functools
import warnings

import numpy as np
import pytest

import pathgene
from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.earth import places
from tests.support.host.lands import GEODESICS, Land, write


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def path_of(terrain, land, legs, above):
    """Return the local metres of a path by metres east and north of the land's place.

    Its inner points lie ``above`` the altitude of its ends.
    """
    lon, lat, _ = GEODESICS.fwd(
        np.full(len(legs), land.lon),
        np.full(len(legs), land.lat),
        [np.degrees(np.arctan2(*leg)) for leg in legs],
        [np.hypot(*leg) for leg in legs],
    )
    x, y = terrain.to_local(lat, lon)
    altitude = [700.0, *[700.0 + above] * (len(legs) - 2), 700.0]
    return np.stack((x, y, altitude), axis=1)


SAME = {
    "alps": (46.5, 8.5, ["EPSG:4326", "EPSG:32632", "EPSG:3857", "EPSG:3035", "EPSG:32631",
                         "+proj=utm +zone=32 +datum=WGS84 +units=us-ft"]),
    "arctic": (80.0, 15.0, ["EPSG:4326", "EPSG:32633", "EPSG:3413", "EPSG:3995", "EPSG:3857",
                            "+proj=laea +lat_0=90 +lon_0=-40 +datum=WGS84"]),
    "antimeridian": (-17.0, 180.0, ["EPSG:4326", "EPSG:32760", "EPSG:32701", "EPSG:3832",
                                    "EPSG:3994", "+proj=eqc +lon_0=180 +datum=WGS84"]),
}  # fmt: skip


@pytest.fixture(scope="module")
def same_land(tmp_path_factory):
    """Function that returns a land of SAME, and its terrains in six systems by system."""

    @functools.cache
    def make(name):
        lat, lon, crss = SAME[name]
        land, terrains = Land(lat, lon, wave_m=4000.0), {}
        file = tmp_path_factory.mktemp("same") / "land.tif"
        for crs in crss:
            in_feet = "us-ft" in crs
            unit_m = 1200 / 3937 if in_feet else 1.0
            assert write(file, land, crs, cells=120, cell_m=40.0, unit_m=unit_m)
            terrains[crs] = load(file, stated=Stated("us-ft" if in_feet else None))
        return land, terrains

    return make


def judged(terrain, path):
    """Return the terms of a path over a terrain."""
    problem = Problem(terrain, tuple(path[0]), tuple(path[-1]), wind=(5.0, -3.0))
    return Evaluator(problem, threads=1).evaluate(path)


def assert_equal(terms, *, feasible):
    assert {each.feasible for each in terms} == {feasible}
    for figure in ("length_m", "flight_time_s", "fuel_N"):
        values = np.array([getattr(each, figure) for each in terms])
        assert np.ptp(values) < 1e-3 * values.mean(), (figure, values)


@pytest.mark.parametrize("name", SAME)
def test_the_same_land_in_six_projections(same_land, name):
    """The same path has the same verdict, and length and time within a thousandth."""
    land, terrains = same_land(name)
    legs = [(-1300, -900), (-300, 400), (600, -300), (1200, 1000)]
    for above, feasible in ((0.0, True), (-90.0, False)):
        terms = [judged(each, path_of(each, land, legs, above)) for each in terrains.values()]
        assert_equal(terms, feasible=feasible)


def plan_on(terrain, land, planner, options):
    """Return a plan across the land, from 80 m to 80 m above the ground."""
    ends = path_of(terrain, land, [(-1300, -900), (1200, 1000)], 0.0)
    ends[:, 2] = land.height(*places(terrain, ends[:, :2])) + 80
    problem = Problem(terrain, *map(tuple, ends), wind=(5.0, -3.0))
    return pathgene.plan(problem, planner=planner, seed=1, fallback="none", **options)


CHIP = {"board": "model:"}


@pytest.mark.parametrize(
    ("planner", "name", "options"),
    [
        *(pytest.param("astar", name, {}, marks=pytest.mark.ci) for name in SAME),
        pytest.param("ga-chip", "alps", CHIP, marks=pytest.mark.ci),
        pytest.param("ga-chip", "arctic", CHIP, marks=pytest.mark.long),
        pytest.param("ga-chip", "antimeridian", CHIP, marks=pytest.mark.long),
    ],
)
def test_the_plans_of_six_maps_are_equally_good(same_land, planner, name, options):
    """Each plan is feasible, and its cost is the same.

    The length of a plan is not: routes of nearly the same cost differ in length, and the cells
    decide which one is found.
    """
    land, terrains = same_land(name)
    plans = [plan_on(terrain, land, planner, options).evaluation for terrain in terrains.values()]
    assert all(each.feasible for each in plans)
    # The trials that refine a plan of the chip end in other places on each map.
    cost = 3e-3 if planner == "ga-chip" else 2e-3
    for figure, share in (
        ("fitness", cost / 4), ("cost", cost), ("length_m", 1e-2), ("flight_time_s", 1e-2),
    ):  # fmt: skip
        values = np.array([getattr(each, figure) for each in plans])
        assert np.ptp(values) < share * values.mean(), (figure, values)


@pytest.mark.parametrize(
    ("planner", "name", "options"),
    [
        *(("astar", name, {}) for name in SAME),
        *(pytest.param("ga-chip", name, CHIP, marks=pytest.mark.long) for name in SAME),
    ],
)
def test_plans_over_the_same_land(same_land, planner, name, options):
    """A plan over each map has the same verdict, length, time and fuel over the five other maps."""
    land, terrains = same_land(name)
    for terrain in terrains.values():
        planned = plan_on(terrain, land, planner, options)
        assert planned.evaluation.feasible
        lat, lon = places(terrain, planned.path[:, :2])
        terms = []
        for other in terrains.values():
            x, y = other.to_local(lat, lon)
            terms.append(judged(other, np.stack((x, y, planned.path[:, 2]), axis=1)))
        assert_equal([planned.evaluation, *terms], feasible=True)
