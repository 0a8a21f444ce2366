"""Commands whose answers have no payload, given one by one and together."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.codes import Command, Status
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError, RefusedError
from pathgene.host.device.orders import Orders
from pathgene.host.device.runs import Runs
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from tests.support.planner.cases import SMALL, ground, record, shape
from tests.unit.device.link_bench import FIRST, Script, connect, lose


OPTIONS = RunOptions(seed=7, generations=40, seeds=16, give_up_rank=3)


def commands(*numbers):
    return [(Command.WRITE, bytes([number, 0])) for number in numbers]


class Noted:
    """Names of losses and actions, in order."""

    def __init__(self):
        self.lost, self.done = [], []

    def of(self, name):
        return {"lost": lambda: self.lost.append(name), "then": lambda: self.done.append(name)}


def _give_together(orders, noted, *, refused=False, stop=None):
    with orders.together():
        orders.give(commands(1), **noted.of(1))
        if refused:
            orders.give([(Command.WRITE, b"!")])
        orders.give(commands(2), **noted.of(2))
        if stop is not None:
            raise stop


@pytest.fixture
def noted():
    return Noted()


def test_each_command_is_sent_at_once(noted):
    link, chip, _ = connect()
    orders = Orders(link)
    for number in range(3):
        orders.give(commands(number), **noted.of(number))
        assert chip.executed == commands(*range(number + 1))
    assert (noted.lost, noted.done) == ([], [0, 1, 2])
    assert link.traffic.exchanges == 3


def test_commands_together_share_a_wait(noted):
    link, chip, _ = connect()
    orders = Orders(link)
    with orders.together():
        for number in range(5):
            orders.give(commands(number, 100 + number), **noted.of(number))
        assert chip.executed == []
        assert noted.done == [0, 1, 2, 3, 4]
    assert chip.executed == commands(*itertools.chain(*((n, 100 + n) for n in range(5))))
    assert link.traffic.exchanges == 1
    assert noted.lost == []
    orders.give(commands(9))
    assert chip.executed[-1:] == commands(9)
    with orders.together():
        pass
    assert link.traffic.exchanges == 2


def test_many_commands_are_sent_before_the_end():
    link, chip, _ = connect()
    orders = Orders(link)
    with orders.together():
        for number in range(100):
            orders.give(commands(number))
        assert chip.executed == commands(*range(64))
    assert chip.executed == commands(*range(100))
    assert link.traffic.exchanges == 2


@pytest.mark.parametrize("place", range(4))
def test_each_command_is_executed_once_whatever_answer_is_lost(place, noted):
    for fault in ({"to_board": place}, {"from_board": place}):
        scripts = {name: Script({FIRST + at: lose}) for name, at in fault.items()}
        link, chip, _ = connect(**scripts)
        orders = Orders(link)
        with orders.together():
            for number in range(4):
                orders.give(commands(number), **noted.of(number))
        assert chip.executed == commands(*range(4))
    assert noted.lost == []


def test_nothing_is_sent_behind_an_error(noted):
    link, chip, _ = connect()
    orders = Orders(link)
    with pytest.raises(KeyError):
        _give_together(orders, noted, stop=KeyError)
    assert chip.executed == []
    assert sorted(noted.lost) == [1, 2]
    orders.give(commands(3), **noted.of(3))
    assert chip.executed == commands(3)
    assert sorted(noted.lost) == [1, 2]


def test_a_dead_line_loses_all_that_is_under_way(noted):
    link, _, _ = connect(to_board=Script(dict.fromkeys(range(FIRST, 10_000), lose)))
    orders = Orders(link)
    with pytest.raises(LinkTimeoutError):
        _give_together(orders, noted)
    assert sorted(noted.lost) == [1, 2]
    with pytest.raises(LinkError, match=r"^No session"):
        orders.give(commands(3), **noted.of(3))
    assert sorted(noted.lost) == [1, 2, 3]
    assert noted.done == [1, 2]


def test_a_refusal_is_told_at_the_end(noted):
    link, chip, _ = connect()
    orders = Orders(link)
    with pytest.raises(RefusedError) as caught:
        _give_together(orders, noted, refused=True)
    assert caught.value.status == Status.BAD_VALUE
    assert chip.executed == commands(1)
    assert sorted(noted.lost) == [1, 2]


@pytest.mark.parametrize("seed", range(5))
def test_a_map_a_block_a_problem_and_a_run_together_are_as_one_by_one(seed):
    rng = np.random.default_rng(seed)
    heights, task = ground(SMALL, rng), record(SMALL, rng)
    changed = heights.copy()
    changed[5:9, 7:20] = rng.integers(0, SMALL.blocked_altitude, (4, 13))
    zone = shape(SMALL, rng)
    results = []
    for is_together in (True, False):
        model = ChipModel(SMALL)
        with Chip(Link(ModelPort(model), timeout_s=0.01, attempts=3)) as chip:
            chip.update_map(heights)
            before = chip.link.traffic.exchanges
            if is_together:
                with chip.runs.together():
                    _send(chip, zone, changed, task)
                assert chip.link.traffic.exchanges == before + 1
            else:
                _send(chip, zone, changed, task)
                assert chip.link.traffic.exchanges >= before + 4
            assert np.array_equal(model.checking.terrain.heights, changed)
            results.append((chip.runs.status(), chip.runs.best()))
    assert results[0] == results[1]


def _send(chip, zone, heights, task):
    chip.runs.block(zone)
    chip.update_map(heights)
    chip.runs.set_problem(task)
    chip.runs.start(OPTIONS)


def test_a_map_that_was_not_sent_is_sent_again(monkeypatch):
    rng = np.random.default_rng(2)
    heights = ground(SMALL, rng)
    model = ChipModel(SMALL)
    with Chip(Link(ModelPort(model), timeout_s=0.01, attempts=3)) as chip:
        chip.update_map(heights)
        changed = heights.copy()
        changed[3, 3:5] ^= 1
        monkeypatch.setattr(Runs, "set_problem", _fails)
        with pytest.raises(KeyError), chip.runs.together():
            _send(chip, shape(SMALL, rng), changed, None)
        assert np.array_equal(model.checking.terrain.heights, heights)
        chip.update_map(changed)
        assert np.array_equal(model.checking.terrain.heights, changed)
        chip.update_map(heights)
        assert np.array_equal(model.checking.terrain.heights, heights)


def _fails(*_):
    raise KeyError


def test_an_interrupt_while_losses_are_told_leaves_none_untold(noted):
    link, _, _ = connect(to_board=Script(dict.fromkeys(range(FIRST, 10_000), lose)))
    orders = Orders(link)
    interrupts = iter([KeyboardInterrupt])

    def interrupted():
        for interrupt in interrupts:
            raise interrupt
        noted.lost.append("interrupted")

    with pytest.raises(KeyboardInterrupt):
        _give_two(orders, noted, interrupted)
    assert noted.lost == ["interrupted", 1]


def _give_two(orders, noted, lost):
    with orders.together():
        orders.give(commands(1), **noted.of(1))
        orders.give(commands(2), lost=lost)
