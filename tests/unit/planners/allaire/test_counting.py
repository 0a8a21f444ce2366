"""Collisions counted by the board's checker for the fitness, on the software model."""

from contextlib import nullcontext

import numpy as np
import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.boards import open_board
from pathgene.host.device.paths import pack_waypoints
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.allaire.counting import CAUSES, BoardCollisionCounter, refutation
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.base import Options, Run
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.zones import Circle
from pathgene.sim.model.checker import TerrainModel, check_path
from tools.chips import board_url


OPTIONS = Options(generations=25, seed=5)
BUILDS = [build for build in CheckerBuild if build is not CheckerBuild.NONE]


def chip_config(build):
    """Return a chip with the smallest sufficient map."""
    return Config(
        checker=build,
        lanes=1 if build is CheckerBuild.TWO_TIER else 4,
        map_size=64,
        coarse_factor=8,
    )


@pytest.fixture
def counts_on(evaluator):
    """Function that opens the model of a checker build with the evaluator's terrain."""
    opened = []

    def make(build, evaluator=evaluator):
        config = chip_config(build)
        opened.append(chip := open_board(board_url("model", config)))
        grid = ChipMap(chip.config, evaluator.problem)
        return BoardCollisionCounter(chip, grid, Run(evaluator, OPTIONS)), chip, grid

    yield make
    for chip in opened:
        chip.close()


def random_paths(evaluator, grid, rng, count, waypoints=None):
    """Return paths in metres whose waypoints lie on the chip's cells and steps."""
    problem, limits = evaluator.problem, grid.limits
    paths = []
    for _ in range(count):
        cells = rng.integers(0, np.add(limits, 1), (waypoints or rng.integers(2, 9), 3))
        paths.append(np.array([problem.start, *grid.to_metres(cells), problem.goal]))
    return paths


def counted_m(config, grid, path):
    """Return d_ut + d_nf of eq. (1) by the checker's definition, segment by segment."""
    terrain = TerrainModel(config)
    terrain.write(0, 0, grid.heights)
    cells = grid.to_cells(path)
    total = 0.0
    verdict = check_path(config, terrain, [tuple(cell) for cell in cells.tolist()], count=True)
    for segment, under, inside in verdict.entries:
        (x0, y0, _), (x1, y1, _) = cells[segment], cells[segment + 1]
        if config.checker is CheckerBuild.TWO_TIER and segment >= 2:
            x0, y0, x1, y1 = (value // config.coarse_factor for value in (x0, y0, x1, y1))
        walked = max(abs(x1 - x0), abs(y1 - y0)) + 1
        length = np.hypot(*(path[segment + 1] - path[segment])[:2])
        assert under + inside <= walked
        total += (under + inside) * length / walked
    return total


@pytest.mark.parametrize("build", BUILDS)
def test_fitness_has_the_counts_of_the_definition(evaluator, counts_on, build):
    counts, chip, grid = counts_on(build)
    paths = random_paths(evaluator, grid, np.random.default_rng(1), 20)
    slot = 7
    chip.load([pack_waypoints(chip.config, grid.to_cells(path[1:-1])) for path in paths], slot)
    expected_m = np.array([counted_m(chip.config, grid, path) for path in paths])
    assert np.count_nonzero(expected_m) > 10
    lengths = np.array([len(path) for path in paths])
    padded = np.zeros((len(paths), lengths.max(), 3))
    for row, path in zip(padded, paths, strict=True):
        row[: len(path)] = path
    told = counts.fitness(paths, slot)
    expected = evaluator.fitness_counted(padded, lengths, expected_m)
    np.testing.assert_allclose(told, expected, rtol=1e-12)


def test_counts_and_samples_agree_roughly(evaluator, counts_on):
    # A straight wall, crossed at right angles: at most half a cell of error on each side.
    _, chip, grid = counts_on(CheckerBuild.PARALLEL)
    start, goal = evaluator.problem.start, evaluator.problem.goal
    path = np.array([start, (1500, 600, 300), (4500, 600, 300), goal])
    sampled = evaluator.evaluate(path)
    assert sampled.distance_in_nofly_m == 0 < sampled.distance_under_terrain_m
    assert counted_m(chip.config, grid, path) == pytest.approx(
        sampled.distance_under_terrain_m, abs=100
    )


@pytest.mark.parametrize("build", BUILDS)
def test_champion_is_evaluated_in_full(evaluator, build):
    config = chip_config(build)
    planner = FpgaGeneticPlanner(board=board_url("model", config), feasibility="board")
    result = planner.plan(evaluator, OPTIONS)
    assert result.evaluation == evaluator.evaluate(result.path)
    assert result.history[-1][1] == pytest.approx(result.evaluation.fitness, rel=1e-9)
    assert result.archive
    for fitness, path in result.archive:
        assert fitness == pytest.approx(evaluator.evaluate(path).fitness, rel=1e-9)
    counted = result.hardware["feasibility"]
    assert counted["counted_on_board"] == counted["paths"] == 128 + 25 * 22
    assert counted["evaluated_in_full"] + counted["counted_on_board"] == result.evaluations
    assert 0 < counted["evaluated_in_full"] < 200
    assert counted["host_samples_saved"] > 1000 < counted["cells"]
    assert result.hardware["cycles"]["feasibility"] > counted["reads"] / config.lanes


def test_evaluates_until_the_best_is_certain(evaluator, counts_on):
    counts, _, grid = counts_on(CheckerBuild.PARALLEL)
    paths = random_paths(evaluator, grid, np.random.default_rng(3), 12)
    full = np.array([evaluator.evaluate(path).fitness for path in paths])
    fitness, settled = full.copy(), np.zeros(12, bool)
    fitness[[2, 5, 9]] = 1.9, 1.8, 0.0  # Two are counted as feasible, and one is far too low.
    assert (full <= 1)[[2, 5]].all()
    counts.settle(fitness, settled, lambda slot: paths[slot])
    assert settled[np.argmax(fitness)]
    assert np.array_equal(fitness[settled], full[settled])
    assert {2, 5} <= set(np.flatnonzero(settled))
    assert not settled[9]
    report = counts.report()
    assert (report["evaluated_in_full"], report["claimed_feasible"]) == (settled.sum(), 2)
    assert sum(report["refuted_by"].values()) == 2


@pytest.mark.parametrize(
    ("first", "corner", "cause"),
    [
        ((1000, 1218, 650), (2000, 2950, 650), "turn_arcs"),  # The arc cuts the zone.
        ((1000, 2800, 650), (3000, 2800, 650), "between_cells"),
    ],
)
def test_names_the_cause_of_a_refuted_count(make_evaluator, counts_on, first, corner, cause):
    evaluator = make_evaluator(zones=(Circle(2000, 2800, 1),))
    counts, _, _ = counts_on(CheckerBuild.PARALLEL, evaluator)
    problem = evaluator.problem
    path = np.array([problem.start, first, corner, (3000, 1218, 650), problem.goal])
    assert evaluator.evaluate(path).distance_in_nofly_m > 0
    counts.settle(np.array([1.5]), np.zeros(1, bool), lambda slot: path)
    expected = dict.fromkeys(CAUSES, 0) | {cause: 1}
    assert counts.report()["refuted_by"] == expected


def test_names_the_strict_rule_as_a_cause(make_evaluator):
    ends = {"start": (500, 2800, 650), "goal": (2700, 2800, 650)}
    evaluator = make_evaluator(zones=(Circle(2000, 2800, 1),), **ends)
    # Three samples step over a zone of one node.
    coarse = Evaluator(evaluator.problem, threads=1, ds_m=900.0)
    path = np.array([ends["start"], ends["goal"]], dtype=float)
    assert refutation(coarse, path) == "between_samples"
    assert refutation(evaluator, path) == "between_cells"
    assert refutation(make_evaluator(zones=(), **ends), path) is None


def test_new_waypoints_avoid_the_ground(evaluator):
    refused = {}
    for feasibility in ("board", "host"):
        board = board_url("model", chip_config(CheckerBuild.PARALLEL))
        planner = FpgaGeneticPlanner(board=board, feasibility=feasibility)
        hardware = planner.plan(evaluator, OPTIONS).hardware
        refused[feasibility] = hardware.get("feasibility", {"redrawn": 0})["redrawn"]
    assert refused["host"] == 0 < refused["board"]


def test_next_run_on_the_chip_sends_only_changed_cells(make_evaluator):
    """After a new zone only its rectangle is sent, and the result is the same."""
    before, after = make_evaluator(), make_evaluator(zones=(Circle(4000, 3000, 300),))
    config = chip_config(CheckerBuild.PARALLEL)
    board = board_url("model", config)
    alone = FpgaGeneticPlanner(board=board, feasibility="board").plan(after, OPTIONS)
    with open_board(board) as chip:
        planner = FpgaGeneticPlanner(feasibility="board", open_board=lambda _: nullcontext(chip))
        first, again, then = (
            planner.plan(evaluator, OPTIONS) for evaluator in (before, before, after)
        )
    sent = [run.hardware["bytes"]["to_board"] for run in (first, again, then)]
    map_bytes = config.map_size**2 * config.altitude_bits // 8
    assert sent[0] - sent[1] > map_bytes
    assert sent[1] < sent[2] < sent[1] + map_bytes / 10
    assert again.history == first.history
    assert then.history == alone.history
    assert np.array_equal(then.path, alone.path)
    assert {key: then.hardware[key] for key in ("feasibility", "frames", "generations")} == {
        key: alone.hardware[key] for key in ("feasibility", "frames", "generations")
    }


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            {"feasibility": "board", "board": "model:?checker=none"},
            (
                r"^This board has no collision checker; count on the host \(--feasibility host\), "
                r"or use one that was built with a checker\.$"
            ),
        ),
        ({"feasibility": "chip"}, r"^The feasibility must be host or board, not 'chip'\.$"),
    ],
)
def test_refuses_bad_options(evaluator, options, sentence):
    with pytest.raises(InputError, match=sentence):
        FpgaGeneticPlanner(**options).plan(evaluator, OPTIONS)
