"""The planner whose loop runs on the chip, on the software model."""

import re

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.host.device.boards import open_board, with_core
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError
from pathgene.host.device.runs import BestPaths, Runs, RunStatus
from pathgene.host.errors import InputError
from pathgene.host.planners.base import Options, Stop
from pathgene.host.planners.chip.ga_chip import ChipGeneticPlanner
from pathgene.host.planners.chip.problem_record import problem_record
from pathgene.host.planners.chip.schedule import ChipSchedule
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.rules import Rules
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from pathgene.sim.model.planner.run import plan


GENERATIONS = Options(generations=1_000_000, seed=3)
CHIP = Config(core="planner", clocks_per_bit=4)


def ends_of(evaluator):
    return evaluator.problem.start, evaluator.problem.goal


@pytest.fixture
def planned(evaluator):
    return ChipGeneticPlanner(chip_ms=4).plan(evaluator, GENERATIONS)


def test_finds_a_feasible_path_and_keeps_the_books(evaluator, planned):
    assert planned.evaluation.feasible
    assert evaluator.evaluate(planned.path) == planned.evaluation
    [run] = planned.hardware["runs"]
    assert run["seed"] == 3
    assert 400_000 <= run["cycles"] < 410_000
    assert run["classes"][0] == "feasible"
    cycles = planned.hardware["cycles"]
    assert list(cycles) == ["breed", "score", "walk", "sort", "wavefront", "total"]
    assert all(cycles.values())
    assert cycles["total"] == run["cycles"] == planned.hardware["plan_us"] * 100
    assert run["bytes"]["from_board"] > 8
    assert planned.replanner is None
    assert planned.seconds["board"] == run["cycles"] / CHIP.clock_hz
    assert planned.generations == planned.hardware["generations"] == run["generations"]
    assert [generation for generation, _, _ in planned.history] == [0, run["generations"]]
    assert planned.hardware["bytes"]["from_board"] > 0
    assert planned.hardware["map"]["limits"] == [59, 39, 4094]


def test_the_paths_are_those_of_the_model(evaluator):
    result = ChipGeneticPlanner(chip_ms=4, polish="off").plan(evaluator, GENERATIONS)
    grid = CornerMap(CHIP, evaluator.problem)
    record = problem_record(CHIP, evaluator.problem, grid)
    schedule = ChipSchedule(config=CHIP, seed=3, chip_ms=4, generations=9**9)
    outcome = plan(CHIP, grid.corners(), record, schedule.first()[0])
    problem = evaluator.problem
    paths = [
        np.vstack((problem.start, grid.corners_to_metres(np.array(path)), problem.goal)).tolist()
        for path in outcome.paths
    ]
    assert result.path.tolist() in paths
    assert result.evaluations == 1 + len(paths)


def test_the_polish_lowers_a_path(evaluator):
    planned = ChipGeneticPlanner(chip_ms=4, polish="chip").plan(evaluator, GENERATIONS)
    plain = ChipGeneticPlanner(chip_ms=4, polish="off").plan(evaluator, GENERATIONS)
    assert planned.evaluation.fitness > plain.evaluation.fitness
    assert planned.hardware["runs"] == plain.hardware["runs"]
    # On its straight pieces there is room for more waypoints than the chip's paths have.
    assert len(plain.path) - 2 <= CHIP.max_waypoints < len(planned.path) - 2 <= 32


def test_a_long_plan_goes_on_from_its_first_run(evaluator):
    """The parts are equal, by time and by generations; only the last is polished."""
    evaluations = {}
    for polish in ("chip", "off"):
        planner = ChipGeneticPlanner(chip_ms=24, polish=polish)
        result = planner.plan(evaluator, GENERATIONS)
        first, second = result.hardware["runs"]
        assert [first["warm"], second["warm"]] == [False, True]
        assert [first["seed"], second["seed"]] == [3, (1 << 32) + 3]
        for run in (first, second):
            assert 1_200_000 <= run["cycles"] < 1_210_000
        assert result.hardware["cycles"]["total"] == first["cycles"] + second["cycles"]
        ends = [first["generations"], first["generations"] + second["generations"]]
        assert [generation for generation, _, _ in result.history] == [0, *ends]
        evaluations[polish] = result.evaluations
    read = len(first["classes"]) + len(second["classes"])
    assert evaluations["off"] == 1 + read
    assert evaluations["chip"] <= 1 + read + len(second["classes"])

    result = ChipGeneticPlanner(polish="off").plan(evaluator, Options(generations=3_201, seed=3))
    assert [run["generations"] for run in result.hardware["runs"]] == [1_600, 1_601]
    assert result.stopped_by == "generations"


def test_a_target_ends_a_long_plan_after_its_first_run(evaluator):
    options = Options(generations=3_200, seed=3, target_fitness=1.01)
    result = ChipGeneticPlanner().plan(evaluator, options)
    assert len(result.hardware["runs"]) == 1
    assert result.stopped_by == "target-fitness"


def test_generations_end_a_run(evaluator):
    result = ChipGeneticPlanner().plan(evaluator, Options(generations=200, seed=1))
    assert [run["generations"] for run in result.hardware["runs"]] == [200]
    assert result.generations == 200
    assert result.stopped_by == "generations"


def test_every_run_has_all_generations(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[:, 30] = np.nan
    result = ChipGeneticPlanner().plan(make_evaluator(elevation), Options(generations=5, seed=3))
    assert [run["generations"] for run in result.hardware["runs"]] == [5] * 8


def test_where_no_path_is_feasible_other_seeds_follow(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[:, 30] = np.nan
    result = ChipGeneticPlanner(chip_ms=1).plan(make_evaluator(elevation), GENERATIONS)
    assert not result.evaluation.feasible
    assert [run["seed"] for run in result.hardware["runs"]] == list(range(3, 11))
    # The chip finds no route, so the map is lowered more and more around the ends.
    assert [run["ease"] for run in result.hardware["runs"]] == [0, 1, *[2] * 6]
    assert result.generations == sum(run["generations"] for run in result.hardware["runs"])


def void_across(gate):
    """Return ground wider than the map, with a void from north to south that has a gate."""
    elevation = np.zeros((600, 40))
    elevation[:, 18:21] = np.nan
    elevation[gate, 18:21] = 0.0
    return elevation


def test_a_leg_on_large_ground_has_its_own_cells(make_evaluator):
    evaluator = make_evaluator(
        void_across(slice(420, 440)), (), start=(500, 40_000, 150), goal=(3400, 40_500, 150)
    )
    result = ChipGeneticPlanner(chip_ms=4, polish="off").plan(evaluator, GENERATIONS)
    assert result.evaluation.feasible
    # 512 of 600 nodes around the leg, each a cell; corners lie half a cell beyond.
    area = result.hardware["map"]
    assert area["scale_m"][:2] == [100.0, 100.0]
    assert area["offset_m"][:2] == [50.0, 8_850.0]
    assert area["limits"][:2] == [38, 510]
    assert ((result.path[1:-1, :2] - 50.0) % 100.0 == 0).all()
    # The gate, more than 20 cells away from the leg.
    assert (np.abs(result.path[:, 1] - 43_000) < 1_000).any()


def test_where_the_box_has_no_path_the_whole_map_follows(make_evaluator):
    evaluator = make_evaluator(
        void_across(slice(40, 80)), (), start=(500, 57_000, 150), goal=(3400, 30_000, 150)
    )
    result = ChipGeneticPlanner(chip_ms=5, polish="off").plan(evaluator, GENERATIONS)
    assert result.evaluation.feasible
    # All runs from new seeds, then the whole terrain, whose rows are compressed.
    runs = result.hardware["runs"]
    assert len(runs) > 8
    assert runs[8]["seed"] == runs[0]["seed"]
    assert "feasible" not in [run["classes"][0] for run in runs[:8]]
    area = result.hardware["map"]
    assert area["scale_m"][0] == 100.0
    assert area["scale_m"][1] == pytest.approx(100 * 599 / 511)
    assert area["offset_m"][:2] == [50.0, pytest.approx(50 * 599 / 511)]
    assert result.hardware["cycles"]["total"] == sum(run["cycles"] for run in runs)


def test_where_only_the_chip_believes_a_path_the_map_is_raised(make_evaluator, monkeypatch):
    elevation = np.full((41, 61), 100.0)
    elevation[:, 30] = np.nan
    real, maps = Runs._best, []
    monkeypatch.setattr(
        Runs, "_best", lambda runs, payload: BestPaths(real(runs, payload).paths[:1], [1])
    )
    model = ChipModel(CHIP)
    send = Runs.set_problem

    def set_problem(runs, record):
        maps.append(model.checking.terrain.heights.copy())
        send(runs, record)

    def opened(url):
        return Chip(Link(ModelPort(model), timeout_s=0.01, attempts=3))

    monkeypatch.setattr(Runs, "set_problem", set_problem)
    evaluator = make_evaluator(elevation)
    result = ChipGeneticPlanner(chip_ms=1, open_board=opened).plan(evaluator, GENERATIONS)
    assert [run["ease"] for run in result.hardware["runs"]] == [0, *[-1] * 7]
    grid = CornerMap(CHIP, evaluator.problem)
    for heights, ease in zip(maps, (0, -1, -1, -1), strict=False):
        assert np.array_equal(heights, grid.corners(ends_of(evaluator), ease))


def test_a_time_limit_ends_the_search_after_a_run(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[:, 30] = np.nan
    options = Options(generations=1_000_000, time_limit_s=1e-6)
    result = ChipGeneticPlanner(chip_ms=1).plan(make_evaluator(elevation), options)
    assert len(result.hardware["runs"]) == 1
    assert result.stopped_by == "time-limit"


def test_a_time_limit_ends_a_run(evaluator):
    options = Options(generations=1_000_000, time_limit_s=0.004)
    result = ChipGeneticPlanner(polish="off").plan(evaluator, options)
    assert 400_000 <= result.hardware["cycles"]["total"] < 410_000
    longer = Options(generations=1_000_000, time_limit_s=1000)
    result = ChipGeneticPlanner(chip_ms=1).plan(evaluator, longer)
    assert 100_000 <= result.hardware["runs"][0]["cycles"] < 110_000


def test_progress_and_limits_are_looked_at_during_a_run(evaluator, monkeypatch):
    """The model's runs end immediately, so the answers imitate a run in progress."""
    said, seen = [], []
    real, poll = Runs.status, Runs.poll
    # Kernels are loaded before the time limit counts.
    ChipGeneticPlanner(chip_ms=1).plan(evaluator, Options(generations=1))

    def status(runs):
        if not runs.started:
            return real(runs)
        said.append("status")
        return real(runs) if "stop" in said else RunStatus(True, 10 * len(said), 0, 0)

    monkeypatch.setattr(Runs, "status", status)
    monkeypatch.setattr(Runs, "poll", lambda runs: poll(runs) if "stop" in said else None)
    monkeypatch.setattr(Runs, "stop", lambda runs: said.append("stop"))
    options = Options(generations=1_000_000, time_limit_s=2.0)
    ChipGeneticPlanner(chip_ms=1).plan(evaluator, options, lambda *row: seen.append(row))
    assert said.count("stop") == 1
    assert [generation for generation, _, _ in seen[:3]] == [0, 10, 20]


def test_a_long_run_of_the_model_is_looked_at_and_stopped(evaluator):
    seen = []
    stop = Stop(lambda: any(generation > 0 for generation, _, _ in seen))
    options = Options(generations=400_000)
    result = ChipGeneticPlanner(chip_ms=4000).plan(
        evaluator, options, lambda *row: seen.append(row), stop
    )
    assert result.interrupted
    (run,) = result.hardware["runs"]
    assert run["looks"] > 0
    # A part has 100,000.
    assert 4_000 <= run["generations"] < 90_000


def test_an_interrupt_stops_the_run(evaluator, monkeypatch):
    """The model's runs end immediately, so the answers imitate a run in progress."""
    said = []
    stop = Stop(lambda: bool(said))
    real, poll = Runs.status, Runs.poll

    def status(runs):
        if not runs.started:
            return real(runs)
        said.append("status")
        return real(runs) if "stop" in said else RunStatus(True, 0, 0, 0)

    monkeypatch.setattr(Runs, "status", status)
    monkeypatch.setattr(Runs, "poll", lambda runs: poll(runs) if "stop" in said else None)
    monkeypatch.setattr(Runs, "stop", lambda runs: said.append("stop"))
    result = ChipGeneticPlanner(chip_ms=1).plan(evaluator, GENERATIONS, None, stop)
    assert said.count("stop") == 1
    assert result.interrupted
    assert result.hardware["runs"]


def test_a_lost_board_costs_no_path(evaluator, monkeypatch):
    def lost(runs):
        raise LinkError("The board was lost: unplugged.")

    monkeypatch.setattr(Runs, "poll", lost)
    result = ChipGeneticPlanner(chip_ms=1).plan(evaluator, GENERATIONS)
    assert result.failure == "The board was lost: unplugged."
    assert result.stopped_by == "failure"
    assert len(result.path) == 2


@pytest.mark.parametrize("clearance_m", [0.0, 30.0, 60.0])
def test_clearance_is_kept_by_the_strict_rule(make_evaluator, clearance_m):
    evaluator = make_evaluator(rules=Rules(clearance_m=clearance_m))
    result = ChipGeneticPlanner(chip_ms=4).plan(evaluator, GENERATIONS)
    assert result.evaluation.feasible
    assert result.evaluation.minimum_clearance_m >= clearance_m


@pytest.mark.parametrize("heading_deg", [0.0, 135.0, 270.0])
def test_headings_at_both_ends_are_kept_by_the_strict_rule(make_evaluator, heading_deg):
    headings = {"start_heading_deg": heading_deg, "goal_heading_deg": 180.0}
    evaluator = make_evaluator(rules=Rules(), **headings, start=(900, 900, 200))
    result = ChipGeneticPlanner(chip_ms=4).plan(evaluator, GENERATIONS)
    assert result.evaluation.feasible
    # The first point lies straight ahead.
    ahead = (result.path[1] - result.path[0])[:2]
    way = np.array([np.sin(np.radians(heading_deg)), np.cos(np.radians(heading_deg))])
    assert ahead @ way == pytest.approx(np.hypot(*ahead))


def test_simulated_boards_get_the_core_unless_they_name_one():
    assert with_core("model:", "planner") == "model:?core=planner"
    assert with_core("sim:?sim=icarus", "planner") == "sim:?sim=icarus&core=planner"
    assert with_core("model:?core=paper", "planner") == "model:?core=paper"
    assert with_core("/dev/ttyUSB1", "planner") == "/dev/ttyUSB1"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"chip_ms": 0}, "The time on the chip must be from 1 to 20000 ms, not 0."),
        ({"chip_ms": 20_001}, "The time on the chip must be from 1 to 20000 ms, not 20001."),
        ({"polish": "yes"}, "The polish must be on, chip or off, not 'yes'."),
    ],
)
def test_wrong_arguments(arguments, sentence):
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        ChipGeneticPlanner(**arguments)


def test_refuses_a_board_without_the_core(evaluator):
    sentence = r"^This board has no planner core, so it does not plan by itself; "
    with pytest.raises(InputError, match=sentence):
        ChipGeneticPlanner(board="model:?core=paper").plan(evaluator, GENERATIONS)
    planner = ChipGeneticPlanner(open_board=lambda url: open_board("model:"))
    with pytest.raises(InputError, match=sentence):
        planner.plan(evaluator, GENERATIONS)


def test_refuses_another_population(evaluator):
    with pytest.raises(InputError, match=r"^The population of this board is 32, not 64; "):
        ChipGeneticPlanner().plan(evaluator, Options(population=64))
