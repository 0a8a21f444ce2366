"""The genetic algorithm on the chip, run on the software model."""

import re

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device import boards
from pathgene.host.device.boards import open_board
from pathgene.host.device.paths import unpack_waypoints
from pathgene.host.errors import InputError, JobError
from pathgene.host.planners.allaire import ga_fpga
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner, draw_paths, ranking
from pathgene.host.planners.base import Options, Stop
from pathgene.host.problem.chip_map import ChipMap
from pathgene.sim.model.core import PaperCore
from pathgene.sim.model.mutation import Limits


OPTIONS = Options(generations=40, seed=5)


@pytest.fixture(scope="module")
def plan():
    """Function that returns the results of a link mode, each run once."""
    results = {}

    def run(evaluator, mode, options=OPTIONS):
        if (mode, options) not in results:
            planner = FpgaGeneticPlanner(link_mode=mode)
            results[mode, options] = planner.plan(evaluator, options)
        return results[mode, options]

    return run


def test_finds_a_feasible_path(evaluator, plan):
    result = plan(evaluator, "rank", Options(generations=120, seed=1))
    assert result.evaluation.feasible
    assert evaluator.evaluate(result.path) == result.evaluation
    assert result.stopped_by == "generations"
    best = [best for _, best, _ in result.history]
    assert best == sorted(best)
    assert [generation for generation, _, _ in result.history] == list(range(121))


def test_matches_the_model_of_the_core(evaluator, plan):
    # The loop of section 4.2 in ten lines around the model.
    config = Config()
    problem = evaluator.problem
    grid = ChipMap(config, problem)
    core = PaperCore(config)
    core.start(OPTIONS.seed, Limits(*grid.limits))

    def worth(path):
        cells = grid.to_metres(unpack_waypoints(config, path))
        return evaluator.evaluate(np.array([problem.start, *cells, problem.goal])).fitness

    drawn = draw_paths(grid, config, np.random.default_rng(OPTIONS.seed), 4 * 32)
    core.paths = sorted(drawn, key=lambda path: -worth(path))[:32]
    history = []
    for generation in range(OPTIONS.generations + 1):
        fitness = np.array([worth(path) for path in core.paths])
        history.append([generation, fitness.max(), fitness.mean()])
        core.run(sorted(range(32), key=lambda slot, f=fitness: (-f[slot], slot)))
    assert np.array(plan(evaluator, "rank").history) == pytest.approx(np.array(history), rel=1e-12)


@pytest.mark.parametrize("mode", ["population", "recipe"])
def test_link_modes_agree(evaluator, plan, mode):
    expected, result = plan(evaluator, "rank"), plan(evaluator, mode)
    assert np.array_equal(result.path, expected.path)
    assert result.history == expected.history
    assert [fitness for fitness, _ in result.archive] == [
        fitness for fitness, _ in expected.archive
    ]


def test_evaluates_only_new_paths(evaluator, plan):
    assert plan(evaluator, "rank").evaluations == 128 + 40 * 22
    assert plan(evaluator, "recipe").evaluations == 128 + 40 * 22
    assert plan(evaluator, "population").evaluations == 128 + 40 * 32


def test_bytes_fall_from_mode_to_mode(evaluator, plan):
    total = {
        mode: sum(plan(evaluator, mode).hardware["bytes"].values())
        for mode in ("population", "rank", "recipe")
    }
    assert total["population"] > total["rank"] > total["recipe"]


def test_hardware_has_the_chips_counters(evaluator):
    chips = []

    def opened(url):
        chips.append(open_board(url))
        chips[0].start(9, (3, 3, 3))
        chips[0].load([[0, 0]] * 32)
        chips[0].step(list(range(32)), LinkMode.RANK)  # It does not belong to the run's figures.
        before.update(chips[0].counters())
        close = chips[0].close
        chips[0].close = lambda: (after.update(chips[0].counters()), close())
        return chips[0]

    before, after = {}, {}
    result = FpgaGeneticPlanner(open_board=opened).plan(evaluator, Options(generations=7))
    hardware = result.hardware
    assert hardware["generations"] == 7
    units = {
        "selection_crossover": "crossover",
        "mutation": "mutation",
        "population_update": "update",
    }
    for name, counter in units.items():
        assert hardware["cycles"][name] == after[counter] - before[counter] > 0
    assert 0 < hardware["cycles"]["receive"] <= after["receive"] - before["receive"]
    assert 0 < hardware["cycles"]["transmit"] <= after["transmit"] - before["transmit"]
    assert hardware["cycles"]["feasibility"] == 0
    cycles = sum(hardware["cycles"][name] for name in units)
    assert result.seconds["board"] == cycles / hardware["clock_hz"]
    assert hardware["longest_generation_cycles"] <= Config().max_waypoints + 8
    assert hardware["map"]["limits"] == [60, 40, 4094]


def test_archive_lies_on_the_chip_map(evaluator, plan):
    grid = ChipMap(Config(), evaluator.problem)
    archive = plan(evaluator, "rank").archive
    assert archive
    for _, path in archive:
        assert 2 <= len(path) - 2 <= 16
        assert np.array_equal(path[[0, -1]], [evaluator.problem.start, evaluator.problem.goal])
        assert np.array_equal(grid.to_metres(grid.to_cells(path[1:-1])), path[1:-1])


def test_first_population_is_free_and_spread_out(evaluator):
    config = Config()
    grid = ChipMap(config, evaluator.problem)
    rng = np.random.default_rng(0)
    paths = draw_paths(grid, config, rng, 6400)
    assert {len(path) for path in paths} == {2}
    cells = np.concatenate([unpack_waypoints(config, path) for path in paths])
    x, y, altitude = cells.T
    assert (altitude > grid.heights[y, x]).all()
    assert altitude.max() == grid.limits[2]
    free = grid.heights < grid.limits[2]
    drawn = np.zeros_like(free)
    drawn[y, x] = True
    assert not drawn[~free].any()
    assert drawn[free].mean() > 0.98  # 12,800 draws for 2,400 cells.


def test_refuses_a_map_without_a_free_cell(make_evaluator):
    evaluator = make_evaluator(zones=())
    grid = ChipMap(Config(), evaluator.problem)
    grid.heights[:] = Config().blocked_altitude
    with pytest.raises(
        InputError,
        match=r"^No flyable cell: reduce the no-fly zones or fill the voids \(--fill-voids\)\.$",
    ):
        draw_paths(grid, Config(), np.random.default_rng(0), 32)


def test_equal_fitnesses_are_ranked_by_slot():
    assert ranking(np.array([0.5, 1.5, 0.5, 1.5, 2.0])) == [4, 1, 3, 0, 2]


def test_refuses_another_population(evaluator):
    with pytest.raises(InputError) as caught:
        FpgaGeneticPlanner().plan(evaluator, Options(population=40))
    assert str(caught.value) == (
        "The population of this board is 32, not 40; leave the population out "
        "(--population) or use another board."
    )


def test_refuses_unknown_link_mode():
    with pytest.raises(InputError) as caught:
        FpgaGeneticPlanner(link_mode="fast")
    assert str(caught.value) == (
        "The link mode must be one of population, rank, recipe, not 'fast'."
    )


def test_refuses_an_altitude_above_the_map(make_evaluator):
    evaluator = make_evaluator(start=(500, 500, 5000), goal=(5500, 700, 5000))
    with pytest.raises(InputError, match=r"^The start's altitude of 5000 m is above the 80\d"):
        FpgaGeneticPlanner().plan(evaluator, OPTIONS)


def test_plans_on_other_boards(evaluator):
    result = FpgaGeneticPlanner(
        board="model:?population=16&children=10&survivors=4&elites=2&max_waypoints=5"
    ).plan(evaluator, Options(generations=60, population=16))
    assert max(len(path) for _, path in result.archive) <= 7
    assert result.evaluations == 64 + 60 * 10


def test_interrupt_returns_the_best_so_far(evaluator):
    stop = Stop()

    def progress(generation, best, mean):
        if generation == 3:
            stop.request()

    result = FpgaGeneticPlanner().plan(evaluator, OPTIONS, progress, stop)
    assert (result.interrupted, result.generations) == (True, 3)
    assert result.hardware["generations"] == 3


def interrupted_at(generation, request=lambda: None):
    """Return a function that opens a model that hangs at ``generation`` until an interrupt."""

    def opened(url):
        chip = open_board(url)
        step = chip.step

        def hang(order, mode):
            if chip.status()["generation"] == generation:
                request()
                raise KeyboardInterrupt
            return step(order, mode)

        chip.step = hang
        return chip

    return opened


def test_interrupt_of_a_hanging_board_returns_the_best_so_far(evaluator):
    stop = Stop()
    planner = FpgaGeneticPlanner(open_board=interrupted_at(4, stop.request))
    result = planner.plan(evaluator, OPTIONS, stop=stop)
    assert (result.stopped_by, result.failure) == ("interrupt", None)
    assert (result.generations, result.hardware) == (4, None)
    assert result.evaluation.fitness == pytest.approx(result.history[-1][1])
    assert stop.heeded


@pytest.mark.parametrize("stop", [None, Stop()])
def test_interrupt_without_a_request_continues(evaluator, stop):
    planner = FpgaGeneticPlanner(open_board=interrupted_at(4))
    with pytest.raises(KeyboardInterrupt):
        planner.plan(evaluator, OPTIONS, stop=stop)


def test_lost_board_keeps_the_best_so_far(evaluator):
    def opened(url):
        chip = open_board(url)
        step = chip.step

        def failing(order, mode):
            if chip.status()["generation"] == 4:
                raise JobError("The board is lost.")
            return step(order, mode)

        chip.step = failing
        return chip

    result = FpgaGeneticPlanner(open_board=opened).plan(evaluator, OPTIONS)
    assert (result.stopped_by, result.failure) == ("failure", "The board is lost.")
    assert (result.generations, result.hardware) == (4, None)
    assert result.evaluation.fitness == pytest.approx(result.history[-1][1])


def test_first_population_has_the_best_draws(evaluator):
    options = Options(generations=1, seed=3)
    one, four = (
        FpgaGeneticPlanner(initial_draws=draws).plan(evaluator, options) for draws in (1, 4)
    )
    assert (one.evaluations, four.evaluations) == (32 + 22, 128 + 22)
    assert four.history[0][2] > one.history[0][2]


@pytest.mark.parametrize("draws", [0, 1001])
def test_refuses_too_few_and_too_many_initial_draws(draws):
    sentence = rf"^The initial draws must be from 1 to 1000, not {draws}\.$"
    with pytest.raises(InputError, match=sentence):
        FpgaGeneticPlanner(initial_draws=draws)


@pytest.mark.parametrize(
    ("board", "options", "altitude", "sentence"),
    [
        ("sim:", Options(population=16), 200, "The population of this board is 32, not 16; "),
        (
            "sim:?population=16&children=10&survivors=4",
            Options(population=32),
            200,
            "The population of this board is 16, not 32; ",
        ),
        ("sim:", Options(), 900, "The start's altitude of 900 m is above the "),
    ],
)
def test_checks_the_url_before_a_board_is_opened(
    make_evaluator, monkeypatch, board, options, altitude, sentence
):
    monkeypatch.setattr(boards, "open_board", lambda url: pytest.fail("was opened"))
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}"):
        FpgaGeneticPlanner(board=board).plan(
            make_evaluator(start=(500, 500, altitude), goal=(5500, 700, altitude)), options
        )


@pytest.mark.parametrize("feasibility", ["host", "board"])
def test_makes_the_map_once(evaluator, monkeypatch, feasibility):
    made = []

    class RecordedMap(ChipMap):
        def __init__(self, config, problem):
            super().__init__(config, problem)
            made.append(config)

    monkeypatch.setattr(ga_fpga, "ChipMap", RecordedMap)
    planner = FpgaGeneticPlanner(feasibility=feasibility)
    assert planner.plan(evaluator, Options(generations=2, seed=1)).seconds["map"] > 0
    assert made == [Config(clocks_per_bit=4)]
