# amaranth: UnusedElaboratable=no
"""Costs of steps, and the constants that they take, against the definition."""

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.planner.layouts import problem_layout
from hdl.planner.wavefront.step_constants import StepConstants
from hdl.planner.wavefront.step_pricer import StepPricer
from hdl.planner.wavefront.widths import COST_BITS
from hdl.protocol.planner import ALTITUDE_FRACTION, SLOPE_FRACTION
from sim.model.planner.definition.score import piece_cost
from tests.planner_cases import LARGE, SMALL, USUAL
from tests.planner_wavefront import FAR, distances_of, problem
from tests.streams import simulate
from tests.wrong_sizes import check_sizes


class Pricing(wiring.Component):
    """Constants of a problem, and a pricer for each way."""

    def __init__(self, config):
        self.constants = StepConstants(problem_layout(config), config.coordinate_bits)
        self.pricers = [StepPricer(config.coordinate_bits, config.altitude_bits) for _ in range(3)]
        super().__init__(
            {
                "problem": In(problem_layout(config)),
                "before": In(config.altitude_bits),
                "after": In(config.altitude_bits),
                "costs": Out(COST_BITS).array(3),
            }
        )

    def elaborate(self, platform):
        m = Module()
        m.submodules.constants = self.constants
        m.d.comb += self.constants.problem.eq(self.problem)
        for i, pricer in enumerate(self.pricers):
            m.submodules[f"pricer_{i}"] = pricer
            m.d.comb += [
                pricer.way.eq(self.constants.constants.ways[i]),
                pricer.climb.eq(self.constants.constants.climb),
                pricer.fuel_shift.eq(self.problem.fuel_shift),
                pricer.key_shift.eq(self.problem.key_shift),
                pricer.before.eq(self.before),
                pricer.after.eq(self.after),
                self.costs[i].eq(pricer.cost),
            ]
        return m


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_matches_the_definition(config):
    """A step in every cycle, ``latency`` cycles each; the constants after ``cycles``."""
    rng = np.random.default_rng(config.map_size)
    dut = Pricing(config)
    top = config.blocked_altitude
    seen = set()

    async def bench(ctx):
        for number in range(12):
            record = problem(config, rng, any_field=number % 3 > 0)
            limit = int(rng.integers(16))
            distances = distances_of(config, record)
            ctx.set(dut.problem, vars(record))
            ctx.set(dut.constants.limit, limit)
            ctx.set(dut.constants.launch, 1)
            await ctx.tick()
            ctx.set(dut.constants.launch, 0)
            for _ in range(dut.constants.cycles - 1):
                assert not ctx.get(dut.constants.done)
                await ctx.tick()
            assert ctx.get(dut.constants.done)
            for way, distance in zip(dut.constants.constants.ways, distances, strict=True):
                assert ctx.get(way.distance) == distance
                fall = record.climb * distance * limit >> SLOPE_FRACTION + ALTITUDE_FRACTION + 1
                assert ctx.get(way.fall) == min(fall, FAR)

            steps = rng.integers(top + 1, size=(60, 2))
            steps[rng.random(steps.shape) < 0.2] = top
            steps[rng.random(steps.shape) < 0.2] = 0
            expected = [
                [
                    min(
                        max(
                            piece_cost(record, a << ALTITUDE_FRACTION, b << ALTITUDE_FRACTION, d)
                            >> record.key_shift,
                            1,
                        ),
                        FAR,
                    )
                    for d in distances
                ]
                for a, b in steps.tolist()
            ]
            costs = []
            for cycle in range(len(steps) + StepPricer.latency):
                before, after = steps[min(cycle, len(steps) - 1)].tolist()
                ctx.set(dut.before, before)
                ctx.set(dut.after, after)
                if cycle >= StepPricer.latency:
                    costs.append([ctx.get(cost) for cost in dut.costs])
                await ctx.tick()
            assert costs == expected
            seen.update(min(cost, 2) if cost < FAR else FAR for row in costs for cost in row)

    simulate(dut, bench)
    assert seen == {1, 2, FAR}


def test_sizes():
    check_sizes(
        StepConstants,
        {"problem_layout": problem_layout(SMALL), "coordinate_bits": SMALL.coordinate_bits},
        {"coordinate_bits": ("Coordinate width", 1)},
    )
    check_sizes(
        StepPricer,
        {"coordinate_bits": 9, "altitude_bits": 12},
        {"coordinate_bits": ("Coordinate width", 1), "altitude_bits": ("Altitude width", 1)},
    )
