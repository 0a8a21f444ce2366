"""The time that is stated for a replan on the chip, beside that of the gates and their line."""

import contextlib

import numpy as np
import pytest

from host.device.chip import Chip
from host.device.link import Link
from host.evaluation import Evaluator
from host.planners import problem_on_chip
from host.planners.chip_time import BAUD, chip_time
from host.planning import Search
from host.problem import aircraft
from host.problem.problem import Problem
from host.problem.zones import Zone
from host.terrain import Terrain
from tools.faults.chips import CHIPS, CLOCK_HZ, VerilatedOnLine


pytestmark = pytest.mark.cosim


class Gates:
    """A chip as a port, and as the host's clock: time passes by cycles alone."""

    timeout = write_timeout = None

    def __init__(self, chip, clock_hz):
        self._chip, self._clock_hz, self._received = chip, clock_hz, b""

    @property
    def in_waiting(self):
        return len(self._received)

    def read(self, size):
        if not self._received:
            # Until a frame comes.
            self._received, _ = self._chip.wait(1e6 / CLOCK_HZ)
        data, self._received = self._received[:size], self._received[size:]
        return data

    def write(self, data):
        self._received += self._chip.feed(data)

    def close(self):
        pass

    def monotonic(self):
        return self._chip.cycles / self._clock_hz

    def sleep(self, seconds):
        received, _ = self._chip.wait(seconds * self._clock_hz / CLOCK_HZ)
        assert not received


@pytest.fixture
def evaluator():
    """Evaluator of a flight around a ridge."""
    elevation = np.full((41, 61), 100.0)
    elevation[:30, 28:33] = 600.0
    terrain = Terrain("ridge", elevation, 100.0, 100.0, None, (0.0, 0.0))
    uav = aircraft.load("silver-fox")
    return Evaluator(Problem(terrain, (500, 500, 200), (5500, 700, 220), uav), threads=1)


@pytest.mark.parametrize(
    "clocks_per_bit",
    [pytest.param(4, marks=pytest.mark.ci), pytest.param(33, marks=pytest.mark.long)],
)
def test_replans_on_the_gates_take_the_time_that_is_stated(evaluator, monkeypatch, clocks_per_bit):
    config = CHIPS["planner"].replace(clocks_per_bit=clocks_per_bit)
    # What makes a bit take as long as on the line of which the time is stated.
    clock_hz = clocks_per_bit * BAUD
    with contextlib.closing(VerilatedOnLine(config)) as verilated:
        gates = Gates(verilated, config.clock_hz)
        monkeypatch.setattr(problem_on_chip, "time", gates)
        chip = Chip(Link(gates, timeout_s=1, attempts=1, clock=gates.monotonic))
        search = Search("ga-chip", board=chip, chip_ms=1, polish="off", seed=1)
        plan = search.run(evaluator)
        taken, stated = [], []
        for number in range(4):
            before = verilated.cycles
            zone = Zone.circle(1500 + 900 * number, 1200 + 500 * number, 250)
            plan = plan.replan(zones=[zone], start=(600 + 200 * number, 700 + 300 * number, 220))
            taken.append(verilated.cycles - before)
            hardware = {**plan.result.hardware, "clock_hz": clock_hz}
            stated.append(chip_time(hardware).whole_s * clock_hz)
    assert taken == pytest.approx(stated, rel=0.01)
