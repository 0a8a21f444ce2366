"""Wavefront over blocks of the map, which finds routes for the first population.

The map is divided into 64 x 64 blocks, or 32 x 32 if they cover the limits. Both relaxations go
over the blocks in passes, forwards by rows and then backwards, so that a pass needs one row of
memory and four neighbours of a block. A sweep is one pass in each direction; sweeps end with the
first one that changes nothing, or at a maximum number.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from math import isqrt

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    FAR,
    POSITION_FRACTION,
    SLOPE_FRACTION,
    SWEEPS,
    VALUE_BITS,
    ProblemRecord,
)
from pathgene.sim.model.planner.definition.score import Corner, Ground, corner_of, scaled


__all__ = [
    "Block",
    "Blocks",
    "Prices",
    "Surface",
    "blocks_of",
    "descend",
    "limit_slopes",
    "prices_of",
    "spread",
    "turns_of",
]

#: x and y in blocks.
Block = tuple[int, int]
#: Altitude of each free block, in steps.
Surface = dict[Block, int]

#: Width of the factors of altitudes in the cost of a step.
_FACTOR_BITS = 18
#: The factor of a climb has this many fraction bits fewer than the factors of altitudes.
_CLIMB_SHIFT = 6
#: Maximum value of a key: each part of a step's cost is clamped to it.
_MOST = (1 << VALUE_BITS) - 1


@dataclass(frozen=True)
class Blocks:
    """Blocks of a map.

    Attributes
    ----------
    least : Surface
        Minimum ground of the blocks without a blocked corner, and of the blocks of start and goal.
    lowest : dict
        First of the lowest corners of each block, by rows.
    edge : int
        Number of blocks along each edge of the map.
    distances : (int, int, int)
        Distances between the centres of neighbours in x, in y, and diagonally, in units of length.
    """

    least: Surface
    lowest: dict[Block, Corner]
    start: Block
    goal: Block
    edge: int
    distances: tuple[int, int, int]


@dataclass(frozen=True)
class Prices:
    """Constants of the costs of steps, rounded down.

    The unit of a cost is ``2**unit``: the unit of a key's value, or a greater one if the factors
    would not fit in 18 bits.

    Attributes
    ----------
    fraction : int
        Fraction bits of ``factors``; ``climb`` has 6 fewer. All possible altitudes cost less than
        2**23, and a climb over all of them less than 2**28.
    factors : (int, int, int)
        Cost of an altitude step of the block and of its neighbour, in x, in y, and diagonally.
    levels : (int, int, int)
        Cost of the base, which may be negative; clamped to -2**28 and 2**28 - 1.
    pulls : (int, int, int)
        Cost of fuel in level flight, clamped to 2**28 - 1.
    climb : int
        Cost of the fuel for a step of climb, clamped to 2**18 - 1.
    """

    fraction: int
    factors: tuple[int, ...]
    levels: tuple[int, ...]
    pulls: tuple[int, ...]
    climb: int

    def cost(self, before: int, after: int, way: int) -> int:
        """Return the cost of a step between two altitudes, at least 1 and less than :data:`FAR`."""
        height = (self.factors[way] * (before + after) >> self.fraction) + self.levels[way]
        burnt = (self.climb * (after - before) << _CLIMB_SHIFT >> self.fraction) + self.pulls[way]
        return max(height + max(burnt, 0), 1)


def prices_of(config: Config, record: ProblemRecord, distances: tuple[int, int, int]) -> Prices:
    """Return the constants of the costs of steps over distances in units of length.

    Their costs equal :func:`pathgene.sim.model.planner.definition.score.piece_cost` except
    for rounding, as long as nothing is clamped to its maximum.
    """
    fraction = config.altitude_bits - 4
    # Width of the maximum distance: the diagonal of the largest blocks that the map needs.
    distance_bits = max(config.coordinate_bits - 5, 0) + POSITION_FRACTION + 1
    least_unit = max(distance_bits + ALTITUDE_FRACTION + fraction - _FACTOR_BITS, 0)
    unit = max(record.key_shift, least_unit)
    weight = min(record.drag * record.fuel >> record.fuel_shift, _MOST)
    climb = min(record.rise * record.fuel >> record.fuel_shift, _MOST)
    climb = climb << ALTITUDE_FRACTION + fraction >> unit + _CLIMB_SHIFT
    return Prices(
        fraction,
        tuple(each << ALTITUDE_FRACTION + fraction >> unit for each in distances),
        tuple(min(max(record.base * each >> unit, ~_MOST), _MOST) for each in distances),
        tuple(min(weight * each >> unit, _MOST) for each in distances),
        min(climb, (1 << _FACTOR_BITS) - 1),
    )


def blocks_of(record: ProblemRecord, ground: Ground, blocked: int) -> Blocks:
    """Return the blocks of a map. Corners beyond the map are blocked.

    A blocked block of start or goal has the altitude of that end.
    """
    shift = record.block_shift
    edge = 1 << shift
    least, lowest = {}, {}
    for y in range(record.blocks):
        for x in range(record.blocks):
            corners = [
                (int(ground[v, u]) if v < len(ground) and u < len(ground) else blocked, v, u)
                for v in range(y << shift, y + 1 << shift)
                for u in range(x << shift, x + 1 << shift)
            ]
            height, v, u = min(corners)
            lowest[x, y] = u, v
            if max(corners)[0] < blocked:
                least[x, y] = height
    ends = []
    for end in ("start", "goal"):
        x, y, altitude = corner_of(record, end)
        ends.append((x >> shift, y >> shift))
        least.setdefault(ends[-1], altitude)
    side = edge << POSITION_FRACTION
    east, north = scaled(side, record.x_scale), scaled(side, record.y_scale)
    distances = east, north, isqrt(east * east + north * north)
    return Blocks(least, lowest, ends[0], ends[1], record.blocks, distances)


def limit_slopes(record: ProblemRecord, blocks: Blocks, surface: Surface, limit: int) -> int:
    """Raise ``surface`` until no slope exceeds ``limit`` halves of the climb limit, or one step.

    Returns the passes taken.
    """
    shift = SLOPE_FRACTION + ALTITUDE_FRACTION + 1
    falls = [max(record.climb * limit * distance >> shift, 1) for distance in blocks.distances]
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for block, neighbours in _visits(blocks.edge):
            if block in surface:
                least = [
                    surface[other] - falls[way] for way, other in neighbours if other in surface
                ]
                risen = max([surface[block], *least])
                changed |= risen != surface[block]
                surface[block] = risen
        passes += 2
        if not changed:
            break
    return passes


def spread(prices: Prices, blocks: Blocks, surface: Surface) -> tuple[dict[Block, int], int]:
    """Return the cost from each block with a route to the goal, and the number of passes."""
    field = {blocks.goal: 0}
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for block, neighbours in _visits(blocks.edge):
            if block not in surface:
                continue
            costs = [
                field[other] + prices.cost(surface[block], surface[other], way)
                for way, other in neighbours
                if other in field
            ]
            best = min([field.get(block, FAR), *costs])
            if best < field.get(block, FAR):
                field[block] = best
                changed = True
        passes += 2
        if not changed:
            break
    return field, passes


def descend(
    prices: Prices, blocks: Blocks, surface: Surface, field: dict[Block, int]
) -> list[Block]:
    """Return the route from start to goal; a straight line of 64 blocks if there is none.

    The next block is the first of the eight neighbours, by rows, that has the minimum cost.
    """
    if blocks.start not in field:
        (x, y), (goal_x, goal_y) = blocks.start, blocks.goal
        return [(x + ((goal_x - x) * i >> 6), y + ((goal_y - y) * i >> 6)) for i in range(64)]
    route = [blocks.start]
    while route[-1] != blocks.goal:
        x, y = route[-1]
        costs = []
        for v in (y - 1, y, y + 1):
            for u in (x - 1, x, x + 1):
                if (u, v) != (x, y) and (u, v) in field:
                    way = 2 if u != x and v != y else int(u == x)
                    cost = prices.cost(surface[x, y], surface[u, v], way)
                    costs.append((field[u, v] + cost, v, u))
        _, v, u = min(costs)
        route.append((u, v))
    return route


def turns_of(route: list[Block]) -> list[Block]:
    """Return the blocks at which ``route`` turns: the straight lines between them stay near it.

    From the start, and from each turn, the route is straight as long as its blocks lie in a wedge
    that each of them narrows to its own width, about a block on either side. The block before the
    first one outside is the next turn. Start and goal are not among them.
    """
    turns: list[Block] = []
    (at_x, at_y), left, right = route[0], None, None
    for before, (x, y) in itertools.pairwise(route):
        way = x - at_x, y - at_y
        if left and right and (_cross(right, way) < 0 or _cross(way, left) < 0):
            turns.append(before)
            (at_x, at_y), left, right = before, None, None
            way = x - at_x, y - at_y
        aside = _sign(way[0]), _sign(way[1])
        to_left = way[0] - aside[1], way[1] + aside[0]
        to_right = way[0] + aside[1], way[1] - aside[0]
        if not left or _cross(to_left, left) > 0:
            left = to_left
        if not right or _cross(right, to_right) > 0:
            right = to_right
    return turns


def _cross(one: Block, other: Block) -> int:
    return one[0] * other[1] - one[1] * other[0]


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)


def _visits(edge: int) -> Iterator[tuple[Block, list[tuple[int, Block]]]]:
    """Yield the blocks of a sweep, each with the neighbours that the pass has already visited.

    Each neighbour comes with the index of its distance.
    """
    forwards = [(x, y) for y in range(edge) for x in range(edge)]
    for step, visits in ((-1, forwards), (1, forwards[::-1])):
        for x, y in visits:
            yield (
                (x, y),
                [
                    (0, (x + step, y)),
                    (2, (x - 1, y + step)),
                    (1, (x, y + step)),
                    (2, (x + 1, y + step)),
                ],
            )
