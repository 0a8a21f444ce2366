"""The time that is stated for a replan on the chip, beside that of the gates and their line."""

import contextlib

import numpy as np
import pytest

from host.device.chip import Chip
from host.device.link import Link
from host.evaluation import Evaluator
from host.planners import problem_on_chip
from host.planners.chip_time import chip_time
from host.planning import Search
from host.problem import aircraft
from host.problem.problem import Problem
from host.problem.zones import Zone
from host.terrain import Terrain
from tools.faults.chips import CHIPS, CLOCK_HZ, VerilatedOnLine


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

CONFIG = CHIPS["planner"].replace(clocks_per_bit=33)


class Gates:
    """A chip as a port, and as the host's clock: time passes by cycles alone."""

    timeout = write_timeout = None

    def __init__(self, chip):
        self.chip, self._received = chip, b""

    @property
    def in_waiting(self):
        return len(self._received)

    def read(self, size):
        if not self._received:
            self._received, _ = self.chip.wait(1e6 / CLOCK_HZ)
        data, self._received = self._received[:size], self._received[size:]
        return data

    def write(self, data):
        self._received += self.chip.feed(data)

    def close(self):
        pass

    def monotonic(self):
        return self.chip.cycles / CONFIG.clock_hz

    def sleep(self, seconds):
        # Until a frame comes, of which there is none now.
        received, _ = self.chip.wait(seconds * CONFIG.clock_hz / CLOCK_HZ)
        assert not received


def flat_but_for_a_ridge():
    elevation = np.full((41, 61), 100.0)
    elevation[:30, 28:33] = 600.0
    terrain = Terrain("ridge", elevation, 100.0, 100.0, None, (0.0, 0.0))
    uav = aircraft.load("silver-fox")
    return Evaluator(Problem(terrain, (500, 500, 200), (5500, 700, 220), uav), threads=1)


def test_replans_on_the_gates_take_the_time_that_is_stated(monkeypatch):
    with contextlib.closing(VerilatedOnLine(CONFIG)) as verilated:
        gates = Gates(verilated)
        monkeypatch.setattr(problem_on_chip, "time", gates)
        chip = Chip(Link(gates, timeout_s=1, attempts=1, clock=gates.monotonic))
        search = Search("ga-chip", board=chip, chip_ms=1, polish="off", seed=1)
        plan = search.run(flat_but_for_a_ridge())
        shares = []
        for number in range(4):
            before = verilated.cycles
            zone = Zone.circle(1500 + 900 * number, 1200 + 500 * number, 250)
            plan = plan.replan(zones=[zone], start=(600 + 200 * number, 700 + 300 * number, 220))
            taken = verilated.cycles - before
            stated = chip_time(plan.result.hardware).whole_s * CONFIG.clock_hz
            shares.append(taken / stated)
    assert shares == pytest.approx([1] * 4, abs=0.02)
