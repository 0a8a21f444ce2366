"""Runs of the planner core over a link, on the software model."""

import dataclasses

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.planner import VALUE_BITS, NoFlyShape, PathClass
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError, RefusedError
from pathgene.host.device.paths import unpack_waypoints
from pathgene.host.device.runs import Runs, RunStatus
from pathgene.host.errors import InputError
from pathgene.sim.model import requests
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from pathgene.sim.model.planner.run import plan
from pathgene.sim.model.run_commands import block
from tests.support.gateware.refusals import run_refusals
from tests.support.planner.cases import SMALL, ground, record, shape


OPTIONS = RunOptions(seed=7, generations=40, seeds=16, give_up_rank=3)
WARM = dataclasses.replace(OPTIONS, seed=8, slopes=(3,), warm=True)
UNITS = ("breed", "score", "walk", "sort", "wavefront")


def opened(model):
    return Chip(Link(ModelPort(model), timeout_s=0.01, attempts=3))


@pytest.fixture
def chip():
    with opened(ChipModel(SMALL)) as chip:
        yield chip


@pytest.fixture
def problem():
    rng = np.random.default_rng(5)
    return ground(SMALL, rng), record(SMALL, rng)


@pytest.fixture
def posed(chip, problem):
    """The problem once the chip has it and its map."""
    heights, task = problem
    chip.update_map(heights)
    chip.runs.set_problem(task)
    return problem


def test_a_run_returns_what_the_model_plans(chip, posed):
    heights, task = posed
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
    units = [getattr(status, unit) for unit in UNITS]
    assert units == [getattr(expected, unit) for unit in UNITS]
    assert all(units)
    counters = chip.counters()
    assert counters["generations"] == expected.generations == 40
    assert counters["clocks"] > expected.cycles
    chip.runs.stop()


def test_another_problem_voids_the_paths(chip, posed):
    _, task = posed
    assert chip.runs.status() == RunStatus(False, 0, 0, PathClass.VOID << VALUE_BITS)
    chip.runs.start(OPTIONS)
    run = chip.runs.status()
    chip.runs.set_problem(dataclasses.replace(task, goal_x=task.goal_x - 256))
    assert chip.runs.best().paths == []
    # Cycles and generations stay until the next run.
    assert chip.runs.status() == dataclasses.replace(run, key=PathClass.VOID << VALUE_BITS)


def test_a_warm_run_goes_on_from_the_latest_population(chip, posed):
    heights, task = posed
    with pytest.raises(RefusedError, match="RUN with BAD_VALUE"):
        chip.runs.start(WARM)
    chip.runs.start(OPTIONS)
    first = plan(SMALL, heights, task, OPTIONS)
    moved = dataclasses.replace(task, start_x=task.start_x + 512)
    chip.runs.set_problem(moved)
    for options in (WARM, dataclasses.replace(WARM, slopes=())):
        chip.runs.start(options)
        # Nothing of the map has changed.
        second = plan(SMALL, heights, moved, options, first.population, marked=0)
        status = chip.runs.status()
        assert (status.key, status.cycles) == (second.keys[0], second.cycles)
        assert chip.runs.best().keys == second.keys
        first = second


def test_a_long_run_of_the_model_goes_on_until_it_is_stopped(chip, posed):
    heights, task = posed
    endless = {"cycles": (1 << 32) - 1, "generations": (1 << 32) - 1}
    chip.runs.start(dataclasses.replace(OPTIONS, **endless))
    status = chip.runs.status()
    assert status.running
    assert status.generations >= 4000
    assert status.cycles > 0
    chip.runs.stop()
    last = next(status for status in iter(chip.runs.status, None) if not status.running)
    assert last.generations >= status.generations
    assert chip.runs.best().keys[0] == last.key
    assert chip.counters()["generations"] == last.generations
    # The next run is as usual.
    chip.runs.start(OPTIONS)
    outcome = plan(SMALL, heights, task, OPTIONS, marked=0)
    assert chip.runs.status().cycles == outcome.cycles
    assert chip.runs.best().keys == outcome.keys


@pytest.mark.parametrize("is_reopened", [True, False])
def test_a_session_ends_the_run_that_another_left(problem, is_reopened):
    heights, task = problem
    model = ChipModel(SMALL)
    endless = dataclasses.replace(OPTIONS, cycles=(1 << 32) - 1, generations=(1 << 32) - 1)
    chip = opened(model)
    chip.update_map(heights)
    chip.runs.set_problem(task)
    chip.runs.start(endless)
    assert chip.runs.status().running
    if is_reopened:
        chip.reopen()
    else:
        chip = opened(model)
    ended = chip.runs.status()
    assert not ended.running
    assert ended.generations >= 4000
    chip.runs.set_problem(task)
    chip.runs.start(OPTIONS)
    assert chip.runs.best().keys == plan(SMALL, heights, task, OPTIONS, marked=0).keys


def test_a_run_that_does_not_end_costs_the_patience(monkeypatch):
    model, said = ChipModel(SMALL), []
    real = Runs.status

    def status(runs):
        said.append("status")
        return dataclasses.replace(real(runs), running=len(said) < most)

    monkeypatch.setattr(Runs, "status", status)
    most = 4
    opened(model).close()
    assert len(said) == 4
    most = np.inf
    sentence = r"^The board continues a run 0\.03 s after it was told to stop: reset it\.$"
    with pytest.raises(LinkTimeoutError, match=sentence):
        opened(model)


def test_a_run_scans_the_blocks_that_have_changed(chip, posed):
    heights, task = posed
    few = dataclasses.replace(OPTIONS, generations=0)

    def scanned():
        chip.runs.start(few)
        return chip.runs.status().wavefront

    def expected(marked):
        return plan(SMALL, heights, task, few, marked=marked).wavefront

    assert [scanned(), scanned()] == [expected(1024), expected(0)]
    # On a map of 32 x 32 corners, a block has one corner.
    chip.upload_map(heights[3:5, 4:7], 4, 3)
    assert [scanned(), scanned()] == [expected(6), expected(0)]
    corner = NoFlyShape(first_x=9, first_y=9, last_x=10, last_y=9, edges=((0, -1, 0),))
    chip.runs.block(corner)
    heights[9, 9] = SMALL.blocked_altitude
    assert [scanned(), scanned()] == [expected(1), expected(0)]


def test_a_shape_is_blocked_and_an_upload_frees_it(problem):
    heights, _ = problem
    model = ChipModel(SMALL)
    chip = opened(model)
    chip.update_map(heights)
    rng = np.random.default_rng(8)
    for _ in range(20):
        # Without an edge, the first edge, of zeros, bends.
        drawn = NoFlyShape.unpack(SMALL, shape(SMALL, rng).pack(SMALL))
        blocked = heights.copy()
        chip.runs.block(drawn)
        block(blocked, SMALL.blocked_altitude, drawn)
        assert np.array_equal(model.checking.terrain.heights, blocked)
        coarse = blocked.reshape(8, 4, 8, 4).max(axis=(1, 3))
        assert np.array_equal(model.checking.terrain.coarse, coarse)
        # The host knows what the chip has drawn, so nothing is sent again.
        frames = chip.link.traffic.frames_to_board
        chip.update_map(blocked)
        assert chip.link.traffic.frames_to_board == frames
        chip.update_map(heights)
        assert np.array_equal(model.checking.terrain.heights, heights)
    empty = NoFlyShape(first_x=9, first_y=9, last_x=8, last_y=9, edges=())
    with pytest.raises(ValueError, match=r"^The box of a shape must have a corner at least, not "):
        chip.runs.block(empty)


def test_after_a_block_that_failed_its_box_is_sent_again(problem, monkeypatch):
    heights, _ = problem
    model = ChipModel(SMALL)
    chip = opened(model)
    chip.update_map(heights)
    corner = NoFlyShape(first_x=9, first_y=9, last_x=11, last_y=9, edges=((0, -1, 0),))
    real = chip.link.order

    def lost(commands, *_):
        real(commands)
        raise LinkError("The board was lost: unplugged.")

    monkeypatch.setattr(chip.link, "order", lost)
    with pytest.raises(LinkError):
        chip.runs.block(corner)
    monkeypatch.undo()
    assert model.checking.terrain.heights[9, 9] == SMALL.blocked_altitude
    chip.update_map(heights)
    assert np.array_equal(model.checking.terrain.heights, heights)


def test_runs_are_counted(chip, posed):
    assert chip.runs.started == 0
    chip.runs.start(OPTIONS)
    chip.runs.start(WARM)
    assert chip.runs.started == 2


def test_a_repeated_block_is_not_drawn_again():
    model = ChipModel(SMALL)
    corner = NoFlyShape(first_x=9, first_y=9, last_x=9, last_y=9, edges=()).pack(SMALL)
    model.checking.terrain.write(0, 0, np.zeros((32, 32), dtype=int))
    assert model.running.block(corner, True) == b""
    assert not model.checking.terrain.heights.any()
    assert model.running.block(corner, False) == b""
    assert model.checking.terrain.heights[9, 9] == SMALL.blocked_altitude


def test_a_busy_board_is_named(chip, monkeypatch):
    """The model's runs end immediately, so the refusal is simulated here."""

    def busy(*_):
        raise requests.RefusedError(Status.BUSY)

    model = chip.link._transport.chip
    monkeypatch.setitem(model._commands, Command.BEST, busy)
    sentence = (
        r"^The board is busy with a run and refused the command BEST: wait for the end of the run, "
        r"or stop it\.$"
    )
    with pytest.raises(RefusedError, match=sentence):
        chip.runs.best()
    chip.runs.stop()


def test_paths_are_there_when_the_run_is_over(chip, posed, monkeypatch):
    chip.runs.start(dataclasses.replace(OPTIONS, generations=10**9, cycles=(1 << 32) - 1))
    assert chip.runs.poll() is None
    # The session continues.
    assert chip.runs.status().running
    chip.runs.stop()
    while (polled := chip.runs.poll()) is None:
        pass
    best, status = polled
    assert status == chip.runs.status()
    assert not status.running
    assert best == chip.runs.best()
    assert best.paths

    def refuse(payload, repeated):
        raise requests.RefusedError(Status.BAD_LENGTH)

    monkeypatch.setitem(chip.link._transport.chip._commands, Command.BEST, refuse)
    with pytest.raises(RefusedError, match="refused the command BEST with BAD_LENGTH"):
        chip.runs.poll()


@pytest.mark.parametrize("times", [1, 2])
def test_a_refused_poll_leaves_the_session_and_the_order_of_commands(chip, posed, times):
    chip.runs.start(dataclasses.replace(OPTIONS, generations=10**9, cycles=(1 << 32) - 1))
    port = chip.link._transport
    write = port.write
    # The line may bring every frame to the chip twice.
    port.write = lambda data: max(write(data) for _ in range(times))
    before = dataclasses.replace(chip.link.traffic)
    assert [chip.runs.poll() for _ in range(3)] == [None] * 3
    taken = chip.link.traffic.since(before)
    # A poll has the number of the one that was refused before.
    assert taken.exchanges == 3
    assert taken.frames_to_board - taken.frames_repeated == 6
    assert taken.frames_repeated == 0 or times == 2
    assert chip.runs.status().running
    chip.runs.stop()
    while (polled := chip.runs.poll()) is None:
        pass
    best, status = polled
    assert not status.running
    assert best == chip.runs.best()
    assert best.paths
    port.write = write
    chip.runs.start(OPTIONS)
    assert chip.runs.poll()[1].generations == OPTIONS.generations


def test_work_is_done_between_the_commands_and_their_answers(chip, posed):
    model, seen = chip.link._transport.chip, []
    read = chip.link._transport.read
    chip.link._transport.read = lambda size: seen.append("read") or read(size)
    with chip.runs.together(meanwhile=lambda: seen.append(model.running.latest.generations)):
        chip.runs.set_problem(posed[1])
        chip.runs.start(OPTIONS)
    assert seen[0] == OPTIONS.generations
    assert set(seen[1:]) == {"read"}


def test_a_repeated_run_is_not_run_again(problem):
    heights, task = problem
    model = ChipModel(SMALL)
    chip = opened(model)
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

    def refused(command, payload=b""):
        with pytest.raises(RefusedError) as caught:
            request(command, payload)
        return caught.value.status

    assert refused(Command.RUN, OPTIONS.pack(SMALL)) == Status.BAD_VALUE
    chip.update_map(heights)
    chip.runs.set_problem(task)
    for command, payload, status in run_refusals(SMALL):
        assert refused(command, payload) == status, (command, payload)
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
    with pytest.raises(InputError, match=r"has the planner core, which breeds without"):
        chip.start(1, (3, 3, 3))
    with pytest.raises(InputError, match=r"has the planner core, which checks the paths"):
        chip.check_path([0, 1])
    with opened(ChipModel(Config())) as other:
        with pytest.raises(InputError, match=r"^The board has no planner core: "):
            other.runs.best()
        with pytest.raises(RefusedError) as refused:
            other.link.request(Command.RUN, b"")
        assert refused.value.status == Status.UNKNOWN_COMMAND
