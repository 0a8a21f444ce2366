"""Wavefront over blocks of the map: routes for the first population.

The map is cut into 32 x 32 blocks. Both relaxations go over the blocks in passes, forwards by rows
and backwards, so that a pass needs a row of memory and four neighbours of a block; a sweep is one
pass each way, and a bounded number of sweeps ends at the first that changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isqrt

from hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BLOCKS,
    POSITION_FRACTION,
    SLOPE_FRACTION,
    ProblemRecord,
)
from sim.model.planner.definition.score import corner_of, piece_cost, scaled
from sim.model.planner.definition.walk import Corner, Ground


__all__ = ["Block", "Blocks", "Surface", "blocks_of", "descend", "limit_slopes", "spread"]

#: x and y in blocks.
Block = tuple[int, int]
#: Altitude of each free block, in steps.
Surface = dict[Block, int]

#: Most sweeps of a relaxation.
SWEEPS = 64
#: A cost to the goal from which a route is none, 30 bits.
FAR = 1 << 30


@dataclass(frozen=True)
class Blocks:
    """Blocks of a map.

    Attributes
    ----------
    least : Surface
        Least ground of the blocks without a blocked corner, and of those of start and goal.
    lowest : dict
        First of the lowest corners of each block, by rows.
    start, goal : Block
    distances : (int, int, int)
        Between the centres of neighbours in x, in y, and across, in units of length.
    """

    least: Surface
    lowest: dict[Block, Corner]
    start: Block
    goal: Block
    distances: tuple[int, int, int]


def blocks_of(record: ProblemRecord, ground: Ground, blocked: int) -> Blocks:
    """Return the blocks of a map. Corners beyond the map are blocked.

    A blocked block of start or goal has the altitude of that end.
    """
    shift = record.block_shift
    edge = 1 << shift
    least, lowest = {}, {}
    for y in range(BLOCKS):
        for x in range(BLOCKS):
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
    return Blocks(least, lowest, ends[0], ends[1], distances)


def limit_slopes(record: ProblemRecord, blocks: Blocks, surface: Surface, limit: int) -> int:
    """Raise ``surface`` until no slope exceeds ``limit`` halves of the climb limit.

    Returns the passes taken.
    """
    falls = [
        record.climb * distance * limit >> SLOPE_FRACTION + ALTITUDE_FRACTION + 1
        for distance in blocks.distances
    ]
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for block, neighbours in _visits():
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


def spread(record: ProblemRecord, blocks: Blocks, surface: Surface) -> tuple[dict[Block, int], int]:
    """Return the cost from each block to the goal, where there is a way, and the passes taken."""
    field = {blocks.goal: 0}
    passes = 0
    for _ in range(SWEEPS):
        changed = False
        for block, neighbours in _visits():
            if block not in surface:
                continue
            costs = [
                field[other] + _step_cost(record, blocks, surface, block, other, way)
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
    record: ProblemRecord, blocks: Blocks, surface: Surface, field: dict[Block, int]
) -> list[Block]:
    """Return the route from start to goal; a straight line of 64 blocks where there is none.

    Of the eight neighbours, by rows, the first with the least cost follows.
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
                    cost = _step_cost(record, blocks, surface, (x, y), (u, v), way)
                    costs.append((field[u, v] + cost, v, u))
        _, v, u = min(costs)
        route.append((u, v))
    return route


def _step_cost(
    record: ProblemRecord, blocks: Blocks, surface: Surface, block: Block, other: Block, way: int
) -> int:
    """Return the cost of a step between neighbours as a value, 1 or more."""
    before, after = (surface[each] << ALTITUDE_FRACTION for each in (block, other))
    cost = piece_cost(record, before, after, blocks.distances[way])
    return max(cost >> record.key_shift, 1)


def _visits() -> Iterator[tuple[Block, list[tuple[int, Block]]]]:
    """Yield the blocks of a sweep, and of each the neighbours that the pass has come by.

    With each neighbour comes the index of its distance.
    """
    forwards = [(x, y) for y in range(BLOCKS) for x in range(BLOCKS)]
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
