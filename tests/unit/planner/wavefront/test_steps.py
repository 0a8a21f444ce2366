"""Costs of steps and the constants that they need, compared with the definition."""

import dataclasses

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.layouts import problem_layout
from pathgene.hdl.planner.wavefront.layouts import COST_BITS
from pathgene.hdl.planner.wavefront.steps import StepConstants, StepPricer
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BASE_BITS,
    DRAG_FRACTION,
    FAR,
    FUEL_BITS,
    RISE_BITS,
    SLOPE_BITS,
    SLOPE_FRACTION,
    VALUE_BITS,
)
from pathgene.sim.model.planner.definition.wavefront import prices_of
from tests.support.gateware.streams import pulse, shared, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.wavefront import distances_of, problem


#: The smallest map and altitude.
TINY = SMALL.replace(map_size=8, coarse_factor=2, altitude_bits=4)


class Pricing(wiring.Component):
    """Constants of a problem, and a pricer for each kind of step."""

    def __init__(self, config):
        self.constants = StepConstants(
            problem_layout(config), config.coordinate_bits, config.altitude_bits
        )
        self.pricers = [StepPricer(config.altitude_bits) for _ in range(3)]
        super().__init__(
            {
                "problem": In(problem_layout(config)),
                "before": In(config.altitude_bits),
                "after": In(config.altitude_bits),
                "leads": In(1),
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
                pricer.before.eq(self.before),
                pricer.after.eq(self.after),
                pricer.leads.eq(self.leads),
                self.costs[i].eq(pricer.cost),
            ]
        return m


async def measure(ctx, dut, record, *, falls, limit=0):
    """Compute the constants of ``record``, in the stated number of cycles."""
    constants = dut.constants
    ctx.set(dut.problem, vars(record))
    ctx.set(constants.falls, falls)
    ctx.set(constants.limit, limit)
    await pulse(ctx, constants.launch)
    cycles = constants.cycles(falls=falls, fuel_shift=record.fuel_shift, key_shift=record.key_shift)
    assert cycles <= constants.most_cycles
    for _ in range(cycles - 1):
        assert not ctx.get(constants.done)
        await ctx.tick()
    assert ctx.get(constants.done)
    return ctx.get(constants.constants)


async def price(ctx, dut, steps, leads):
    """Return the costs of ``steps`` in all three ways, one step per cycle."""
    costs = []
    last = len(steps) - 1
    for cycle in range(len(steps) + StepPricer.latency):
        before, after = steps[min(cycle, last)]
        ctx.set(dut.before, before)
        ctx.set(dut.after, after)
        ctx.set(dut.leads, leads[min(max(cycle - StepPricer.latency + 1, 0), last)])
        if cycle >= StepPricer.latency:
            costs.append([ctx.get(cost) for cost in dut.costs])
        await ctx.tick()
    return costs


@pytest.mark.ci
@pytest.mark.parametrize(
    "config", [TINY, SMALL, USUAL, LARGE], ids=["tiny", "small", "usual", "large"]
)
def test_matches_the_definition(config):
    """Steps enter in every cycle and take ``latency`` cycles; first falls, then constants."""
    rng = np.random.default_rng(config.map_size)
    dut = shared(Pricing, config)
    top = config.blocked_altitude
    seen = set()

    async def bench(ctx):
        for number in range(15):
            record = problem(config, rng, any_field=number % 3 > 0)
            distances = distances_of(config, record)
            limit = int(rng.integers(16))
            found = await measure(ctx, dut, record, falls=True, limit=limit)
            shift = SLOPE_FRACTION + ALTITUDE_FRACTION + 1
            falls = [record.climb * limit * each >> shift for each in distances]
            assert [each.level for each in found.ways] == falls
            steps = rng.integers(top + 1, size=(4, 2)).tolist()
            least = [max(each, 1) for each in falls]
            assert await price(ctx, dut, steps, [1] * 4) == [least] * 4

            found = await measure(ctx, dut, record, falls=False, limit=limit)
            prices = prices_of(config, record, distances)
            assert tuple(each.factor for each in found.ways) == prices.factors
            assert tuple(each.level for each in found.ways) == prices.levels
            assert tuple(each.pull for each in found.ways) == prices.pulls
            assert found.climb == prices.climb

            steps = rng.integers(top + 1, size=(60, 2))
            steps[rng.random(steps.shape) < 0.2] = top
            steps[rng.random(steps.shape) < 0.2] = 0
            steps, leads = steps.tolist(), (rng.random(60) < 0.9).astype(int).tolist()
            costs = await price(ctx, dut, steps, leads)
            assert costs == [
                [prices.cost(*step, way) if leads[i] else FAR for way in range(3)]
                for i, step in enumerate(steps)
            ]
            seen.update(min(cost, 2) if cost < FAR else FAR for row in costs for cost in row)

    simulate(dut, bench)
    assert seen == {1, 2, FAR}


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_extremes(config):
    """The maximum and minimum constants: each part is clamped to its maximum, and no sum wraps."""
    rng = np.random.default_rng(1)
    dut = shared(Pricing, config)
    top = config.blocked_altitude
    most = (1 << VALUE_BITS) - 1
    usual = dataclasses.replace(
        problem(config, rng), x_scale=1 << 14, y_scale=1 << 14, fuel_shift=0, key_shift=0
    )
    dear = dataclasses.replace(
        usual,
        base=(1 << BASE_BITS - 1) - 1,
        drag=(1 << DRAG_FRACTION) - 1,
        fuel=(1 << FUEL_BITS) - 1,
        rise=(1 << RISE_BITS) - 1,
        climb=(1 << SLOPE_BITS) - 1,
        block_shift=max(config.coordinate_bits - 5, 0),
    )
    low = dataclasses.replace(dear, base=-1 << BASE_BITS - 1, drag=0)
    small = dataclasses.replace(low, block_shift=0, x_scale=0, y_scale=0, rise=0)
    coarse = dataclasses.replace(dear, fuel_shift=31, key_shift=63)

    async def bench(ctx):
        steps = [(top, top), (0, top), (top, 0), (0, 0)]
        found = {}
        for name, record in (("dear", dear), ("low", low), ("small", small), ("coarse", coarse)):
            prices = prices_of(config, record, distances_of(config, record))
            await measure(ctx, dut, record, falls=False)
            costs = await price(ctx, dut, steps, [1] * 4)
            assert costs == [[prices.cost(*step, way) for way in range(3)] for step in steps]
            found[name] = prices, np.array(costs)
        constants = await measure(ctx, dut, dear, falls=True, limit=15)
        assert max(each.level for each in constants.ways) <= most

        # The most expensive: fuel is clamped to the maximum key, and a climb over all altitudes has
        # the maximum factor.
        prices, costs = found["dear"]
        assert set(prices.pulls) == {most}
        assert prices.climb == (1 << 18) - 1
        assert prices.climb * top << 6 >> prices.fraction < 1 << 28
        assert 2 * top * max(prices.factors) >> prices.fraction < 1 << 23
        assert costs.max() < FAR
        assert np.array_equal(costs.argmax(0), [1] * 3)
        # Below the datum, a level step costs the least; a climb still costs its fuel.
        prices, costs = found["low"]
        assert max(prices.levels) <= -(1 << 25)
        if config is not LARGE:
            assert set(prices.levels) == {-most - 1}
        assert np.array_equal(costs[[0, 2, 3]], np.ones((3, 3)))
        # Without a length, or if the unit is greater than any cost, every step costs the same.
        assert np.array_equal(found["small"][1], np.ones((4, 3)))
        assert np.array_equal(found["coarse"][1], np.ones((4, 3)))

    simulate(dut, bench)


def test_cycles_of_the_page():
    """The longest constants are computed while the memories are filled, in 1,026 cycles."""
    dut = shared(Pricing, USUAL)
    assert dut.constants.most_cycles == 1009
    assert StepPricer.latency == 5
