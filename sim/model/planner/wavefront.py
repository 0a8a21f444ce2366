"""Compiled wavefront over blocks of the map."""

from __future__ import annotations

import math

import numpy as np

from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    FAR,
    POSITION_FRACTION,
    SLOPE_FRACTION,
    SWEEPS,
    VALUE_BITS,
)
from pathgene.sim.model.compiled import compiled, inlined
from pathgene.sim.model.planner.course import (
    ALTITUDE_BITS,
    BASE,
    BLOCK_SHIFT,
    CLIMB,
    COORDINATE_BITS,
    DRAG,
    FUEL,
    FUEL_SHIFT,
    KEY_SHIFT,
    RISE,
    X_SCALE,
    Y_SCALE,
)
from pathgene.sim.model.planner.score import scaled
from pathgene.sim.model.planner.walk import Ground, Integers


__all__ = [
    "LEAST",
    "LOWEST_X",
    "LOWEST_Y",
    "PRICES",
    "descend",
    "find_turns",
    "limit_slopes",
    "measure_blocks",
    "measure_distances",
    "measure_prices",
    "root",
    "spread",
]


@inlined
def root(square: int) -> int:
    """Return the square root of ``square``, 0..2**60, rounded down.

    A CPU's root is rounded to nearest on every machine: below 2**52, its integer part is already
    the root; above, it may be off by one.
    """
    whole = int(math.sqrt(square))
    while whole * whole > square:
        whole -= 1
    while (whole + 1) * (whole + 1) <= square:
        whole += 1
    return whole


#: Layers of the blocks: minimum altitude, -1 if blocked, and the corner of the minimum.
LEAST, LOWEST_X, LOWEST_Y = range(3)
_NONE = -1
#: Places of the constants of the costs of steps: three of each except the last two.
_FACTOR, _LEVEL, _PULL, _CLIMB, _FRACTION = 0, 3, 6, 9, 10
PRICES = 11
_FACTOR_BITS, _CLIMB_SHIFT = 18, 6
_MOST = (1 << VALUE_BITS) - 1


@compiled
def measure_distances(problem: Integers, distances: Integers) -> None:
    """Write the distances between neighbours in x, in y, and diagonally, (3,) int64."""
    side = 1 << problem[BLOCK_SHIFT] + POSITION_FRACTION
    east, north = scaled(side, problem[X_SCALE]), scaled(side, problem[Y_SCALE])
    distances[0], distances[1] = east, north
    distances[2] = root(east * east + north * north)


@compiled
def measure_prices(
    problem: Integers, sizes: Integers, distances: Integers, prices: Integers
) -> None:
    """Write the constants of the costs of steps, (11,) int64.

    See :class:`pathgene.sim.model.planner.definition.wavefront.Prices`.
    """
    fraction = sizes[ALTITUDE_BITS] - 4
    distance_bits = max(sizes[COORDINATE_BITS] - 5, 0) + POSITION_FRACTION + 1
    least_unit = distance_bits + ALTITUDE_FRACTION + fraction - _FACTOR_BITS
    unit = max(problem[KEY_SHIFT], least_unit)
    weight = min(problem[DRAG] * problem[FUEL] >> problem[FUEL_SHIFT], _MOST)
    climb = min(problem[RISE] * problem[FUEL] >> problem[FUEL_SHIFT], _MOST)
    climb = climb << ALTITUDE_FRACTION + fraction >> min(unit + _CLIMB_SHIFT, 63)
    for way in range(3):
        distance = distances[way]
        prices[_FACTOR + way] = distance << ALTITUDE_FRACTION + fraction >> unit
        prices[_LEVEL + way] = min(max(problem[BASE] * distance >> unit, ~_MOST), _MOST)
        prices[_PULL + way] = min(weight * distance >> unit, _MOST)
    prices[_CLIMB] = min(climb, (1 << _FACTOR_BITS) - 1)
    prices[_FRACTION] = fraction


@compiled
def measure_blocks(
    problem: Integers, ground: Ground, blocked: int, ends: Integers, blocks: Integers
) -> None:
    """Write the layers of the blocks, (3, edge, edge) int64; ``ends`` (6,) x, y, step."""
    shift, edge = problem[BLOCK_SHIFT], blocks.shape[1]
    for y in range(edge):
        for x in range(edge):
            least, is_free = blocked + 1, True
            for v in range(y << shift, y + 1 << shift):
                for u in range(x << shift, x + 1 << shift):
                    height = blocked
                    if v < len(ground) and u < len(ground):
                        height = int(np.int64(ground[v, u]))
                    is_free &= height < blocked
                    if height < least:
                        least = height
                        blocks[LOWEST_X, y, x], blocks[LOWEST_Y, y, x] = u, v
            blocks[LEAST, y, x] = least if is_free else _NONE
    for end in range(2):
        x, y = ends[3 * end] >> shift, ends[3 * end + 1] >> shift
        if blocks[LEAST, y, x] == _NONE:
            blocks[LEAST, y, x] = ends[3 * end + 2]


@compiled
def limit_slopes(problem: Integers, distances: Integers, surface: Integers, limit: int) -> int:
    """Raise ``surface``, (edge, edge), to slopes of ``limit`` halves of the climb limit or a step.

    Returns the number of passes.
    """
    shift, edge = SLOPE_FRACTION + ALTITUDE_FRACTION + 1, len(surface)
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for step in (-1, 1):
            for i in range(edge * edge):
                at = i if step < 0 else edge * edge - 1 - i
                x, y = at % edge, at // edge
                if surface[y, x] == _NONE:
                    continue
                for n in range(4):
                    u, v, way = _neighbour(x, y, step, n)
                    if 0 <= u < edge and 0 <= v < edge and surface[v, u] != _NONE:
                        fall = max(problem[CLIMB] * limit * distances[way] >> shift, 1)
                        least = surface[v, u] - fall
                        if least > surface[y, x]:
                            surface[y, x] = least
                            changed = True
        passes += 2
        if not changed:
            break
    return passes


@compiled
def spread(prices: Integers, surface: Integers, goal: int, field: Integers) -> int:
    """Write the cost from each block to the goal, (edge, edge); return the number of passes.

    ``goal`` is edge y + x. A block without a route has 2**30.
    """
    edge = len(surface)
    field[:] = FAR
    field[goal // edge, goal % edge] = 0
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for step in (-1, 1):
            for i in range(edge * edge):
                at = i if step < 0 else edge * edge - 1 - i
                x, y = at % edge, at // edge
                if surface[y, x] == _NONE:
                    continue
                for n in range(4):
                    u, v, way = _neighbour(x, y, step, n)
                    if 0 <= u < edge and 0 <= v < edge and field[v, u] < FAR:
                        step_cost = _step_cost(prices, surface[y, x], surface[v, u], way)
                        cost = field[v, u] + step_cost
                        if cost < field[y, x]:
                            field[y, x] = cost
                            changed = True
        passes += 2
        if not changed:
            break
    return passes


@compiled
def descend(
    prices: Integers,
    surface: Integers,
    field: Integers,
    start: int,
    goal: int,
    route: Integers,
) -> int:
    """Write the route, rows x, y of ``route`` (edge**2, 2), and return its length."""
    edge = len(surface)
    x, y = start % edge, start // edge
    goal_x, goal_y = goal % edge, goal // edge
    if field[y, x] == FAR:
        for i in range(64):
            route[i, 0] = x + ((goal_x - x) * i >> 6)
            route[i, 1] = y + ((goal_y - y) * i >> 6)
        return 64
    length = 0
    while True:
        route[length, 0], route[length, 1] = x, y
        length += 1
        if x == goal_x and y == goal_y:
            return length
        best, best_x, best_y = 2 * FAR, x, y
        for v in range(max(y - 1, 0), min(y + 2, edge)):
            for u in range(max(x - 1, 0), min(x + 2, edge)):
                if (u == x and v == y) or field[v, u] == FAR:
                    continue
                way = 2 if u != x and v != y else int(u == x)
                cost = field[v, u] + _step_cost(prices, surface[y, x], surface[v, u], way)
                if cost < best:
                    best, best_x, best_y = cost, u, v
        x, y = best_x, best_y


@compiled
def find_turns(route: Integers, length: int, turns: Integers) -> int:
    """Write the turns of a route, rows x, y of ``turns`` (n, 2); return their number, or n if more.

    See ``turns_of`` of :mod:`pathgene.sim.model.planner.definition.wavefront`.
    """
    count = 0
    at_x, at_y = route[0, 0], route[0, 1]
    left_x, left_y, right_x, right_y, narrows = 0, 0, 0, 0, False
    for i in range(1, length):
        x, y = route[i, 0] - at_x, route[i, 1] - at_y
        if narrows and (right_x * y < right_y * x or x * left_y < y * left_x):
            if count == len(turns):
                break
            at_x, at_y = route[i - 1, 0], route[i - 1, 1]
            turns[count, 0], turns[count, 1] = at_x, at_y
            count += 1
            narrows = False
            x, y = route[i, 0] - at_x, route[i, 1] - at_y
        beside_x, beside_y = int(x > 0) - int(x < 0), int(y > 0) - int(y < 0)
        if not narrows or (x - beside_y) * left_y > (y + beside_x) * left_x:
            left_x, left_y = x - beside_y, y + beside_x
        if not narrows or right_x * (y - beside_x) > right_y * (x + beside_y):
            right_x, right_y = x + beside_y, y - beside_x
        narrows = True
    return count


@compiled
def _neighbour(x: int, y: int, step: int, number: int) -> tuple[int, int, int]:
    """Return x, y and the distance index of one of the four neighbours that a pass has visited."""
    if number == 0:
        return x + step, y, 0
    return x + number - 2, y + step, 1 if number == 2 else 2


@inlined
def _step_cost(prices: Integers, before: int, after: int, way: int) -> int:
    """Return the cost of a step between two altitudes, 1 or more."""
    height = prices[_FACTOR + way] * (before + after) >> prices[_FRACTION]
    burnt = prices[_CLIMB] * (after - before) << _CLIMB_SHIFT >> prices[_FRACTION]
    cost: int = height + prices[_LEVEL + way] + max(burnt + prices[_PULL + way], 0)
    return max(cost, 1)
