"""Runs of the planner on the chip over a link, on the software model."""

import dataclasses

import numpy as np
import pytest

from hdl.config import Config
from hdl.protocol import Command, Status, StickyError
from hdl.protocol.planner import VALUE_BITS, PathClass
from hdl.protocol.runs import RunOptions, run_request
from host.device.chip import Chip, unpack_waypoints
from host.device.link import Link, RefusedError
from host.errors import InputError
from sim.model.chip import ChipModel
from sim.model.planner.run import plan
from sim.model.port import ModelPort
from tests.planner_cases import SMALL, ground, record


OPTIONS = RunOptions(seed=7, generations=40, seeds=16, give_up_rank=3)


def opened(config):
    return Chip(Link(ModelPort(ChipModel(config)), timeout_s=0.01, attempts=3))


@pytest.fixture
def chip():
    with opened(SMALL) as chip:
        yield chip


@pytest.fixture
def problem():
    rng = np.random.default_rng(5)
    return ground(SMALL, rng), record(SMALL, rng)


def test_a_run_returns_what_the_model_plans(chip, problem):
    heights, task = problem
    chip.update_map(heights)
    chip.runs.set_problem(task)
    assert chip.runs.best().paths == []
    chip.runs.start(OPTIONS)
    status, best = chip.runs.status(), chip.runs.best()
    expected = plan(SMALL, heights, task, OPTIONS)
    assert [unpack_waypoints(SMALL, path).tolist() for path in best.paths] == [
        [list(waypoint) for waypoint in path] for path in expected.paths
    ]
    assert best.keys == expected.keys
    assert best.classes == expected.classes
    assert (status.running, status.generations, status.cycles, status.key) == (
        False, expected.generations, expected.cycles, expected.keys[0],
    )  # fmt: skip
    counters = chip.counters()
    assert counters["generations"] == expected.generations == 40
    assert counters["clocks"] > expected.cycles
    chip.runs.stop()


def test_another_problem_voids_the_paths(chip, problem):
    heights, task = problem
    chip.update_map(heights)
    chip.runs.set_problem(task)
    chip.runs.start(OPTIONS)
    chip.runs.set_problem(dataclasses.replace(task, goal_x=task.goal_x - 256))
    assert chip.runs.best().paths == []
    status = chip.runs.status()
    assert (status.generations, status.cycles) == (0, 0)
    assert status.key >> VALUE_BITS == PathClass.VOID


def test_a_repeated_run_is_not_run_again(problem):
    heights, task = problem
    model = ChipModel(SMALL)
    chip = Chip(Link(ModelPort(model), timeout_s=0.01, attempts=3))
    chip.update_map(heights)
    chip.runs.set_problem(task)
    payload = OPTIONS.pack(SMALL)
    assert model.running.run(payload, False) == b""
    first = model.running.latest
    assert model.running.run(payload, True) == b""
    assert model.running.latest is first
    model.running.set_problem(task.pack(SMALL), True)
    assert model.running.latest is first


def test_what_is_out_of_range_is_refused(chip, problem):
    heights, task = problem
    request = chip.link.request

    def refusal(command, payload=b""):
        with pytest.raises(RefusedError) as refused:
            request(command, payload)
        return refused.value.status

    assert refusal(Command.RUN, OPTIONS.pack(SMALL)) == Status.BAD_VALUE
    chip.update_map(heights)
    high = dataclasses.replace(task, altitude_limit=SMALL.blocked_altitude)
    assert refusal(Command.PROBLEM, high.pack(SMALL)) == Status.BAD_VALUE
    assert refusal(Command.PROBLEM, task.pack(SMALL) + b"\0") == Status.BAD_LENGTH
    chip.runs.set_problem(task)
    fields = run_request(SMALL).unpack(OPTIONS.pack(SMALL)) | {"islands": 3}
    assert refusal(Command.RUN, run_request(SMALL).pack(**fields)) == Status.BAD_VALUE
    assert refusal(Command.RUN, b"") == Status.BAD_LENGTH
    assert refusal(Command.BEST, b"\0") == Status.BAD_LENGTH
    assert refusal(Command.STOP, b"\0") == Status.BAD_LENGTH
    assert chip.status()["errors"] == StickyError.REFUSED
    assert chip.runs.best().paths == []


@pytest.mark.parametrize(
    "command", [Command.START, Command.GENERATE, Command.CHECK, Command.RESULTS]
)
def test_a_streaming_chip_knows_no_other_loop(chip, command):
    with pytest.raises(RefusedError) as refused:
        chip.link.request(command, b"")
    assert refused.value.status == Status.UNKNOWN_COMMAND


def test_the_host_names_the_core_that_is_missing(chip):
    with pytest.raises(InputError, match=r"has the streaming genetic core, which breeds without"):
        chip.start(1, (3, 3, 3))
    with pytest.raises(InputError, match=r"has the streaming genetic core, which checks the paths"):
        chip.check_path([0, 1])
    with opened(Config()) as other:
        with pytest.raises(InputError, match=r"^The board has no streaming genetic core: "):
            other.runs.best()
        with pytest.raises(RefusedError) as refused:
            other.link.request(Command.RUN, b"")
        assert refused.value.status == Status.UNKNOWN_COMMAND
