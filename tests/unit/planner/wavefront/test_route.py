"""Routes over random costs and steps: the first of the cheapest, and the straight line."""

import numpy as np
import pytest

from pathgene.hdl.planner.wavefront.route import Route, TurnFinder
from pathgene.hdl.planner.wavefront.steps import StepPricer
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, FAR
from pathgene.sim.model.planner.definition.wavefront import turns_of
from pathgene.sim.model.planner.run_cycles import routing
from tests.support.gateware.streams import pulse, simulate


#: Waypoints of the longest path.
_MOST = 6


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
                for v in range(max(y - 1, 0), min(y + 2, len(costs)))
                for u in range(max(x - 1, 0), min(x + 2, len(costs)))
                if (u, v) != (x, y)
            )[:0:-1]
        )
    return route


def settled(goal, heights, blocked):
    """Return the minimum costs to the goal."""
    edge = len(heights)
    costs = np.full((edge, edge), FAR, dtype=np.int64)
    costs[goal[::-1]] = 0
    left = [goal]
    while left:
        x, y = left.pop(0)
        for v in range(max(y - 1, 0), min(y + 2, edge)):
            for u in range(max(x - 1, 0), min(x + 2, edge)):
                way = 2 if u != x and v != y else int(u == x)
                cost = costs[y, x] + price(heights[v, u], heights[y, x], way)
                if (u, v) != (x, y) and not blocked[v, u] and cost < costs[v, u]:
                    costs[v, u] = cost
                    left.append((u, v))
    return costs


@pytest.mark.parametrize("seed", range(4))
def test_random_costs(seed):
    rng, dut = np.random.default_rng(seed), Route(8, _MOST)
    counts = []

    async def bench(ctx):
        for number in range(5):
            edge = BLOCKS if number == 4 else COARSE_BLOCKS
            heights = rng.integers(8, size=(edge, edge))
            blocked = rng.random((edge, edge)) < rng.choice([0, 0.3, 0.6])
            start, goal = (tuple(each) for each in rng.integers(edge, size=(2, 2)).tolist())
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
            ctx.set(dut.fine, edge == BLOCKS)
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
                # Beyond the blocks, the memory has earlier costs.
                at = divmod(asked[-2], BLOCKS)
                is_there = max(at) < edge
                free = is_there and not blocked[at]
                ctx.set(dut.surface, {"free": free, "altitude": int(heights[at]) if free else 0})
                ctx.set(dut.cost, int(costs[at]) if is_there else 0)
                for way, port in enumerate(dut.prices):
                    ctx.set(port, price(*steps[-StepPricer.latency], way))
            assert cycles == routing(len(expected), bool(costs[start[::-1]] == FAR))
            assert ctx.get(dut.length) == len(expected)
            is_straight = costs[start[::-1]] == FAR
            turns = [] if is_straight else turns_of(expected)
            assert ctx.get(dut.turns) == min(len(turns), _MOST + 1)
            counts.append(len(turns))
            for of_turns, places in ((0, expected), (1, turns[:_MOST])):
                ctx.set(dut.of_turns, of_turns)
                for i, place in enumerate(places):
                    ctx.set(dut.number, i)
                    await ctx.tick().repeat(2)
                    found = ctx.get(dut.place)
                    assert (found.x, found.y) == place

    simulate(dut, bench)
    assert max(counts) > 1


@pytest.mark.parametrize("pause", [0, 3])
def test_turns_of_random_walks(pause):
    """Reversals and loops that no route has, at the shortest distance between blocks."""
    rng, dut = np.random.default_rng(pause), TurnFinder()
    counts = []

    async def bench(ctx):
        for number in range(30):
            steps = rng.integers(-1, 2, size=(40, 2)) * rng.integers(1, 5, size=(40, 1))
            if number % 3 == 0:
                steps[:, 0] = 1
            places = np.clip(np.cumsum(steps, axis=0) + rng.integers(64, size=2), 0, 63)
            route = [(x, y) for x, y in places.tolist()]
            found = []
            for i, (x, y) in enumerate(route):
                ctx.set(dut.place, {"x": x, "y": y})
                ctx.set(dut.begin, i == 0)
                ctx.set(dut.advance, i > 0)
                for _ in range(TurnFinder.cycles + 1 + pause):
                    await ctx.tick()
                    ctx.set(dut.begin, 0)
                    ctx.set(dut.advance, 0)
                    if ctx.get(dut.found):
                        turn = ctx.get(dut.turn)
                        found.append((turn.x, turn.y))
            assert found == turns_of(route)
            counts.append(len(found))

    simulate(dut, bench)
    assert max(counts) > 10
