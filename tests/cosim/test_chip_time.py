"""The stated time of a replan on the chip, compared with the time of the gates and their line."""

import dataclasses

import numpy as np
import pytest

from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.chip import problem_on_chip
from pathgene.host.planners.chip import replanner as chip_replanner
from pathgene.host.planners.chip.schedule import BAUD, chip_time
from pathgene.host.planning import Search
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from tools.faults.chips import CHIPS, CLOCK_HZ, VerilatedOnLine


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

CONFIG = CHIPS["planner"].replace(clocks_per_bit=33)


class Gates:
    """A chip as a port and as the host's clock: time only passes in cycles."""

    timeout = write_timeout = None

    def __init__(self, chip):
        self._chip, self._received = chip, b""

    @property
    def in_waiting(self):
        return len(self._received)

    def read(self, size):
        if not self._received:
            # Until a frame arrives.
            self._received, _ = self._chip.wait(1e6 / CLOCK_HZ)
        data, self._received = self._received[:size], self._received[size:]
        return data

    def write(self, data):
        self._received += self._chip.feed(data)

    def close(self):
        pass

    def monotonic(self):
        return self._chip.cycles / CONFIG.clock_hz

    def sleep(self, seconds):
        received, _ = self._chip.wait(seconds * CONFIG.clock_hz / CLOCK_HZ)
        assert not received


@pytest.fixture
def evaluator():
    """Evaluator of a flight around a ridge."""
    elevation = np.full((41, 61), 100.0)
    elevation[:30, 28:33] = 600.0
    terrain = Terrain("ridge", elevation, 100.0, 100.0, None, (0.0, 0.0))
    uav = aircraft.load("silver-fox")
    return Evaluator(Problem(terrain, (500, 500, 200), (5500, 700, 220), uav), threads=1)


@pytest.mark.parametrize("ends_by", [pytest.param("generations", marks=pytest.mark.long), "cycles"])
def test_replans_on_the_gates_take_the_time_that_is_stated(evaluator, monkeypatch, ends_by):
    limit = getattr(chip_replanner.replan_options(CONFIG, 0), ends_by)
    others = {"until_feasible": False, "generations": 10**6, "cycles": 10**6, ends_by: limit}
    warm = dataclasses.replace(chip_replanner.replan_options(CONFIG, 0), **others)
    monkeypatch.setattr(chip_replanner, "replan_options", lambda *arguments: warm)
    with VerilatedOnLine(CONFIG) as verilated:
        gates = Gates(verilated)
        monkeypatch.setattr(problem_on_chip, "time", gates)
        chip = Chip(Link(gates, timeout_s=1, attempts=1, clock=gates.monotonic))
        search = Search("ga-chip", board=chip, chip_ms=1, polish="off", seed=1)
        plan = search.run(evaluator)
        taken, stated, zones, ended = [], [], [[]], []
        poll = chip.runs.poll

        def noted_poll():
            polled = poll()
            ended.append(verilated.cycles)
            return polled

        monkeypatch.setattr(chip.runs, "poll", noted_poll)
        for number in range(4):
            before = verilated.cycles
            # The sliver covers little, but its box is large: drawing takes 1,000 cycles.
            east = 5800 + number
            sliver = Zone.polygon([(2600, 3950), (2700, 3950), (east, 500), (east, 550)])
            zones.append([Zone.circle(1500 + 900 * number, 1200 + 500 * number, 250), sliver])
            start = (600 + 200 * number, 700 + 300 * number, 220)
            plan = plan.replan(zones=zones[-1], gone=zones[-2], start=start)
            hardware = plan.result.hardware
            (run,) = hardware["runs"]
            assert run["cycles"] >= limit if ends_by == "cycles" else run["generations"] == limit
            assert hardware["drawing_cycles"] > 1_000
            taken.append(ended[-1] - before)
            # At this clock a bit takes as long as on the line of the stated time.
            clock_hz = CONFIG.clocks_per_bit * BAUD
            time = chip_time({**hardware, "clock_hz": clock_hz})
            # A poll ends with the answer to STATUS.
            stated.append((time.whole_s + time.status_s) * clock_hz)
            plan.finish()
    assert taken == pytest.approx(stated, rel=0.0003)
