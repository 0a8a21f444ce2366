"""Single passes over the blocks: costs and falls, forwards and backwards."""

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.relaxer import Relaxer
from pathgene.hdl.planner.wavefront.steps import StepPricer
from pathgene.hdl.planner.wavefront.wavefront import Wavefront
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, FAR, VALUE_BITS
from pathgene.sim.model.planner import run_cycles
from pathgene.sim.model.planner.definition.wavefront import prices_of
from tests.support.gateware.streams import pulse, shared, simulate
from tests.support.planner.cases import USUAL
from tests.support.planner.wavefront import distances_of, problem


def constants_of(prices, falls):
    """Return the constants in the form of their layout."""
    if falls is not None:
        ways = [{"factor": 0, "level": fall, "pull": 0} for fall in falls]
        return {"ways": ways, "climb": 0}
    columns = zip(prices.factors, prices.levels, prices.pulls, strict=True)
    ways = [{"factor": factor, "level": level, "pull": pull} for factor, level, pull in columns]
    return {"ways": ways, "climb": prices.climb}


def relaxed(prices, falls, free, heights, costs, backwards):
    """Return the costs after a pass; ``falls`` is None where steps keep their cost."""
    costs = costs.copy()
    step = 1 if backwards else -1
    edge = len(costs)
    for i in range(edge**2):
        y, x = divmod(edge**2 - 1 - i if backwards else i, edge)
        if not free[y, x]:
            continue
        for u, v, way in ((x + step, y, 0), *((x + n, y + step, 2 - (n == 0)) for n in (-1, 0, 1))):
            if not (0 <= u < edge and 0 <= v < edge):
                continue
            if falls is None:
                cost = prices.cost(int(heights[y, x]), int(heights[v, u]), way)
            else:
                cost = max(falls[way], 1)
            costs[y, x] = min(costs[y, x], costs[v, u] + cost)
    return costs


@pytest.mark.parametrize("config", [USUAL], ids=["usual"])
def test_passes(config):
    rng = np.random.default_rng(config.map_size)
    dut = shared(Relaxer, config.altitude_bits)
    top = config.blocked_altitude
    changes = []

    async def bench(ctx):
        for number in range(12):
            record = problem(config, rng, any_field=number % 4 == 3)
            prices = prices_of(config, record, distances_of(config, record))
            most = (1 << VALUE_BITS) - 1
            falls = None if number % 2 else [int(each) for each in rng.choice([0, 3, 90, most], 3)]
            backwards = bool(number // 2 % 2)
            fine = number >= 8
            edge = BLOCKS if fine else COARSE_BLOCKS
            free = rng.random((edge, edge)) < rng.choice([0.5, 0.95, 1])
            heights = rng.integers(top + 1, size=free.shape)
            kinds = rng.random(free.shape)
            costs = rng.integers(rng.choice([100, FAR]), size=free.shape)
            costs[~free | (kinds < rng.choice([0, 0.99, 1]))] = FAR
            expected = relaxed(prices, falls, free, heights, costs, backwards)
            changes.append(not np.array_equal(expected, costs))

            ctx.set(dut.constants, constants_of(prices, falls))
            ctx.set(dut.backwards, backwards)
            ctx.set(dut.fine, fine)
            await pulse(ctx, dut.launch)
            found = costs.copy()
            asked, cycles, written = [(0, 0)] * 2, 1, 0
            while ctx.get(dut.busy):
                asked.append((ctx.get(dut.surface_block), ctx.get(dut.cost_block)))
                write = ctx.get(dut.write)
                await ctx.tick()
                if write.valid:
                    found[divmod(write.block, BLOCKS)] = write.cost
                    written += 1
                surface, cost = (divmod(block, BLOCKS) for block in asked[-2])
                ctx.set(
                    dut.surface,
                    {"free": bool(free[surface]), "altitude": int(heights[surface])},
                )
                ctx.set(dut.cost, int(found[cost]))
                cycles += 1
            assert np.array_equal(found, expected)
            assert written == edge**2
            assert ctx.get(dut.changed) == changes[-1]
            assert cycles == Relaxer.pass_cycles(fine) == run_cycles.passing(edge)

            # Steps between passes, with the current constants.
            steps = rng.integers(top + 1, size=(20, 2)).tolist()
            for cycle, (before, after) in enumerate(steps):
                ctx.set(dut.before, before)
                ctx.set(dut.after, after)
                if cycle >= StepPricer.latency:
                    step = steps[cycle - StepPricer.latency]
                    assert [ctx.get(each) for each in dut.prices] == [
                        prices.cost(*step, way) if falls is None else max(falls[way], 1)
                        for way in range(3)
                    ]
                await ctx.tick()

    simulate(dut, bench)
    assert any(changes)
    assert not all(changes)


def test_cycles_are_those_of_the_model():
    for edge in (COARSE_BLOCKS, BLOCKS):
        fills = run_cycles.spreading(edge, 0, 0) - 1
        assert fills == 2 * Wavefront.fill_cycles(edge == BLOCKS)
