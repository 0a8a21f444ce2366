"""Routes over random costs and steps: the first of the cheapest, and the straight line."""

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.route import Route
from pathgene.hdl.planner.wavefront.steps import StepPricer
from pathgene.hdl.protocol.planner import BLOCKS, FAR
from pathgene.sim.model.planner.run_cycles import routing
from tests.support.gateware.streams import pulse, simulate


def price(before, after, way):
    """Any function of a step suffices."""
    return (before * 7 + after * 3 + way * 5) % 11 + 1


def expected_route(start, goal, costs, heights):
    """Return the route of ``descend``, with :func:`price`."""
    if costs[start[::-1]] == FAR:
        return [
            tuple(a + ((b - a) * i >> 6) for a, b in zip(start, goal, strict=True))
            for i in range(64)
        ]
    route = [start]
    while route[-1] != goal:
        x, y = route[-1]
        route.append(
            min(
                (
                    costs[v, u]
                    + price(heights[y, x], heights[v, u], 2 if u != x and v != y else int(u == x)),
                    v,
                    u,
                )
                for v in range(max(y - 1, 0), min(y + 2, BLOCKS))
                for u in range(max(x - 1, 0), min(x + 2, BLOCKS))
                if (u, v) != (x, y)
            )[:0:-1]
        )
    return route


def settled(goal, heights, blocked):
    """Return the minimum costs to the goal."""
    costs = np.full((BLOCKS, BLOCKS), FAR, dtype=np.int64)
    costs[goal[::-1]] = 0
    left = [goal]
    while left:
        x, y = left.pop(0)
        for v in range(max(y - 1, 0), min(y + 2, BLOCKS)):
            for u in range(max(x - 1, 0), min(x + 2, BLOCKS)):
                way = 2 if u != x and v != y else int(u == x)
                cost = costs[y, x] + price(heights[v, u], heights[y, x], way)
                if (u, v) != (x, y) and not blocked[v, u] and cost < costs[v, u]:
                    costs[v, u] = cost
                    left.append((u, v))
    return costs


@pytest.mark.parametrize("seed", range(4))
def test_random_costs(seed):
    rng, dut = np.random.default_rng(seed), Route(8)

    async def bench(ctx):
        for number in range(5):
            heights = rng.integers(8, size=(BLOCKS, BLOCKS))
            blocked = rng.random((BLOCKS, BLOCKS)) < rng.choice([0, 0.3, 0.6])
            start, goal = (tuple(each) for each in rng.integers(BLOCKS, size=(2, 2)).tolist())
            if number == 2:
                goal = start
            if number == 3:
                # A straight line, then a route.
                blocked[:] = True
            blocked[start[::-1]] = blocked[goal[::-1]] = False
            costs = settled(goal, heights, blocked)
            expected = expected_route(start, goal, costs, heights)
            for port, place in ((dut.start, start), (dut.goal, goal)):
                ctx.set(port, {"x": place[0], "y": place[1]})
            # Between routes, the blocks read and their steps may cost nothing.
            for port in (dut.cost, *dut.prices):
                ctx.set(port, 0)
            await ctx.tick().repeat(dut.step_cycles)
            await pulse(ctx, dut.launch)
            asked, steps, cycles = [0] * 2, [(0, 0)] * StepPricer.latency, 0
            while ctx.get(dut.busy):
                asked.append(ctx.get(dut.read_block))
                steps.append((ctx.get(dut.before), ctx.get(dut.after)))
                await ctx.tick()
                cycles += 1
                at = divmod(asked[-2], BLOCKS)
                ctx.set(dut.surface, {"free": not blocked[at], "altitude": int(heights[at])})
                ctx.set(dut.cost, int(costs[at]))
                for way, port in enumerate(dut.prices):
                    ctx.set(port, price(*steps[-StepPricer.latency], way))
            assert cycles == routing(len(expected), bool(costs[start[::-1]] == FAR))
            assert ctx.get(dut.length) == len(expected)
            for i, place in enumerate(expected):
                ctx.set(dut.number, i)
                await ctx.tick().repeat(2)
                found = ctx.get(dut.place)
                assert (found.x, found.y) == place

    simulate(dut, bench)
