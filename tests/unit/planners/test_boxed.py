"""Searches in a box of a large map, compared with searches of the whole map."""

import numpy as np
import pytest

from pathgene.hdl.config import GeneticCore
from pathgene.host.device.boards import open_board, with_core
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import boxed, make
from pathgene.host.planners.base import Options
from pathgene.host.planners.chip.ga_chip import ChipGeneticPlanner
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Polygon, Zone
from pathgene.host.terrain import Terrain


CELL_M = 60.0
START, GOAL = (9_000.0, 11_000.0, 60.0), (13_000.0, 12_500.0, 60.0)


@pytest.fixture(autouse=True)
def small_maps_have_boxes(monkeypatch):
    monkeypatch.setattr(boxed, "_MOST_WHOLE", 10_000)


@pytest.fixture
def searched(monkeypatch):
    """The shapes of the terrains that the planner searches, in order."""
    shapes = []
    own = boxed.Evaluator

    def noting(problem, **options):
        shapes.append(problem.terrain.shape)
        return own(problem, **options)

    monkeypatch.setattr(boxed, "Evaluator", noting)
    return shapes


def land(nodes=400, relief_m=0.0, lowest_m=0.0):
    x, y = np.meshgrid(*2 * (np.arange(nodes) * CELL_M,))
    heights = lowest_m + relief_m * (1 + np.sin(x / 900) * np.cos(y / 1_100))
    return Terrain("land", heights, CELL_M, CELL_M)


def plan(problem, planner="astar", progress=None, **options):
    evaluator = Evaluator(problem, threads=1)
    generations = 400 if planner == "astar" else 20
    result = make(planner).plan(
        evaluator, Options(**{"generations": generations, **options}), progress
    )
    again = evaluator.evaluate(result.path)
    assert result.evaluation.fitness == again.fitness
    assert result.evaluation.feasible == again.feasible
    return result


@pytest.mark.parametrize("as_paper", [False, True])
@pytest.mark.parametrize("relief_m", [0.0, 60.0])
def test_a_box_loses_nothing_on_open_ground(searched, monkeypatch, relief_m, as_paper):
    ends = [(x, y, z + 2 * relief_m) for x, y, z in (START, GOAL)]
    problem = Problem(land(relief_m=relief_m), *ends, as_paper=as_paper)
    found = plan(problem)
    assert len(searched) == 1
    assert np.prod(searched[0]) < 0.5 * problem.terrain.elevation.size
    monkeypatch.setattr(boxed, "_MOST_WHOLE", problem.terrain.elevation.size)
    whole = plan(problem)
    assert len(searched) == 1
    assert found.evaluation.feasible
    assert whole.evaluation.feasible
    assert found.evaluation.fitness >= whole.evaluation.fitness - 1e-3
    if relief_m == 0:
        assert found.evaluation.length_m == pytest.approx(whole.evaluation.length_m, rel=1e-4)


def test_a_way_around_outside_of_the_box_is_found(searched):
    # A wall across the box: the only way is past its northern end.
    wall = Polygon(
        ((11_000.0, -100.0), (11_300.0, -100.0), (11_300.0, 19_500.0), (11_000.0, 19_500.0))
    )
    found = plan(Problem(land(), START, GOAL, agl=True, zones=[wall]))
    assert found.evaluation.feasible
    assert found.path[:, 1].max() > 19_500.0
    assert len(searched) == 1  # The box, and then the map.
    assert searched[0][0] * CELL_M < 19_500.0


def test_a_cheaper_way_outside_of_the_box_is_found(searched):
    # Zones make the way inside the box much longer than the straight line.
    problem = Problem(land(), START, GOAL, agl=True, zones=baffles(START, GOAL))
    found = plan(problem)
    assert found.evaluation.feasible
    (box, *_) = boxed._boxes(problem)
    assert len(searched) == 1
    assert found.evaluations > 0
    inside = box.problem(problem)
    inner = make("astar").plan(Evaluator(inside, threads=1), Options(generations=400))
    assert not inner.evaluation.feasible or inner.evaluation.cost > box.least_cost_outside
    assert not inner.evaluation.feasible or found.evaluation.cost <= inner.evaluation.cost + 1e-9


def baffles(start, goal):
    """Return walls from alternating sides of the box between two ends."""
    (x0, y0, _), (x1, y1, _) = start, goal
    walls = []
    for number, share in enumerate((0.25, 0.5, 0.75)):
        x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
        low, high = (y - 9_000, y + 3_000) if number % 2 else (y - 3_000, y + 9_000)
        walls.append(Zone.polygon([(x - 60, low), (x + 60, low), (x + 60, high), (x - 60, high)]))
    return walls


def test_no_path_outside_costs_less_than_the_bound():
    rng = np.random.default_rng(6)
    outside = 0
    for _ in range(60):
        terrain = land(relief_m=rng.uniform(0, 40), lowest_m=rng.uniform(-50, 300))
        ends = [
            (*place, float(terrain.ground(*place)) + rng.uniform(40, 400))
            for place in rng.uniform(8_000, 15_000, (2, 2)).tolist()
        ]
        wind = rng.uniform(-8, 8, 2).tolist() if rng.random() < 0.5 else (0.0, 0.0)
        problem = Problem(terrain, *ends, wind=wind)
        boxes = list(boxed._boxes(problem))
        if not boxes:
            continue
        box, evaluator = boxes[0], Evaluator(problem, threads=1)
        # Just past each side, as low as the ground and the climb limits allow.
        x0, y0 = ends[0][:2]
        x1, y1 = ends[1][:2]
        middle_x, middle_y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
        for place in (
            (box.west_m - rng.uniform(0, 500), middle_y),
            (box.east_m + rng.uniform(0, 500), middle_y),
            (middle_x, box.south_m - rng.uniform(0, 500)),
            (middle_x, box.north_m + rng.uniform(0, 500)),
        ):
            low = terrain.lowest + 1.0
            points = np.array([ends[0], (*place, low), ends[1]])
            # The turn cuts the corner.
            track = evaluator.track(points).sample(20.0)
            beyond_x = (track.x < box.west_m) | (track.x > box.east_m)
            beyond_y = (track.y < box.south_m) | (track.y > box.north_m)
            if not (beyond_x | beyond_y).any():
                continue
            assert evaluator.evaluate(points).cost >= box.least_cost_outside
            outside += 1
    assert outside > 40


def test_zones_of_the_box_are_in_the_frame_of_the_box():
    zones = [
        Zone.circle(11_000.0, 11_500.0, 300.0, name="inside"),
        Zone.circle(500.0, 500.0, 300.0, name="far"),
    ]
    problem = Problem(land(), START, GOAL, agl=True, zones=zones)
    box = next(boxed._boxes(problem))
    inner = box.problem(problem)
    assert [zone.name for zone in inner.zones] == ["inside"]
    (zone,) = inner.zones
    assert (zone.x_m + box.west_m, zone.y_m + box.south_m) == (11_000.0, 11_500.0)
    assert inner.terrain.elevation.flags.writeable is False
    assert inner.cost_base_m == problem.cost_base_m


def test_the_observer_gets_paths_in_the_frame_of_the_map(searched):
    class Seen:
        def __init__(self):
            self.paths, self.generations = [], []

        def __call__(self, generation, best, mean):
            self.generations.append(generation)

        def improved(self, path):
            self.paths.append(path)

    seen = Seen()
    plan(Problem(land(), START, GOAL, agl=True), progress=seen)
    assert searched
    assert seen.generations
    for path in seen.paths:
        np.testing.assert_allclose(path[0, :2], START[:2], atol=1e-6)
        np.testing.assert_allclose(path[-1, :2], GOAL[:2], atol=1e-6)


def test_fpa_searches_the_box_and_keeps_its_candidates_in_the_frame_of_the_map(searched):
    found = plan(Problem(land(), START, GOAL, agl=True), "fpa-2opt", seed=3)
    assert len(searched) == 1
    assert found.evaluation.feasible
    for _, path in found.archive[:5]:
        np.testing.assert_allclose(path[0, :2], START[:2], atol=1e-6)


def on_chip(problem, board="model:"):
    evaluator = Evaluator(problem, threads=1)
    planner = ChipGeneticPlanner(board=board, polish="off", chip_ms=2)
    result = planner.plan(evaluator, Options(generations=400))
    assert result.evaluation.feasible
    assert result.evaluation.fitness == evaluator.evaluate(result.path).fitness
    return result


def test_the_chip_has_a_map_in_the_box(searched):
    problem = Problem(land(), START, GOAL, agl=True)
    result = on_chip(problem)
    assert len(searched) == 1
    (box, *_) = boxed._boxes(problem)
    area = result.hardware["map"]
    # Corners lie half a cell beyond the nodes.
    assert area["offset_m"][:2] == [box.west_m + CELL_M / 2, box.south_m + CELL_M / 2]
    assert area["scale_m"][:2] == [CELL_M, CELL_M]
    assert ((result.path[1:-1, :2] - area["offset_m"][:2]) % CELL_M == 0).all()


def test_the_chip_searches_the_map_if_the_box_has_no_path(searched):
    wall = Zone.polygon(
        [(11_000.0, -100.0), (11_300.0, -100.0), (11_300.0, 19_500.0), (11_000.0, 19_500.0)]
    )
    result = on_chip(Problem(land(), START, GOAL, agl=True, zones=[wall]))
    assert len(searched) == 1
    assert result.path[:, 1].max() > 19_500.0
    assert result.hardware["map"]["offset_m"][:2] == [CELL_M / 2, CELL_M / 2]


def test_a_board_that_stays_open_has_a_map_of_the_terrain(searched):
    with open_board(with_core("model:", GeneticCore.PLANNER)) as chip:
        result = on_chip(Problem(land(), START, GOAL, agl=True), chip)
    assert not searched
    assert result.replanner is not None


def test_a_time_limit_ends_the_search_in_the_box(searched):
    wall = Polygon(
        ((11_000.0, -100.0), (11_300.0, -100.0), (11_300.0, 30_000.0), (11_000.0, 30_000.0))
    )
    found = plan(Problem(land(), START, GOAL, agl=True, zones=[wall]), time_limit_s=1e-6)
    assert len(searched) == 1
    assert found.stopped_by == "time-limit"
    assert not found.evaluation.feasible


def test_small_maps_and_long_legs_have_no_box(monkeypatch):
    long = Problem(land(), (500.0, 500.0, 60.0), (23_000.0, 23_000.0, 60.0), agl=True)
    assert list(boxed._boxes(long)) == []
    monkeypatch.setattr(boxed, "_MOST_WHOLE", 160_000)
    assert list(boxed._boxes(Problem(land(), START, GOAL, agl=True))) == []


def test_a_part_of_a_terrain_keeps_its_place_and_its_north():
    heights = np.arange(100.0 * 120).reshape(100, 120) % 700
    terrain = Terrain(
        "land", heights, 30.0, 30.0, crs="EPSG:32616", origin=(700_000.0, 4_000_000.0)
    )
    part = terrain.part(slice(20, 60), slice(30, 100))
    assert part.shape == (40, 70)
    assert part.ground(90.0, 60.0) == terrain.ground(30 * 30.0 + 90.0, 20 * 30.0 + 60.0)
    assert part.north_deg == terrain.north_deg
    here, there = part.to_geographic(0.0, 0.0), terrain.to_geographic(900.0, 600.0)
    np.testing.assert_allclose(here, there, atol=1e-9)
