"""Breeding: from the sorted population and the random words of a generation to its children.

A path is a list of :class:`Waypoint`, start and goal left out. Each child takes a step of the
random source: the selection word has the ranks of its parents, and above them the draw of a
survivor; the mutation word has its mutation, and above it the place where the parents are cut. A
draw below ``n`` is ``bits * n >> width``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ProblemRecord
from pathgene.hdl.protocol.planner_breeding import (
    CUT,
    DELETE,
    INSERT,
    MUTATIONS,
    OFFSETS,
    OPERATOR,
    PARENT_DRAWS,
    PLACE,
    SETTLE,
    SIZE,
    SURVIVOR_BITS,
)
from pathgene.sim.model.planner.definition.walk import Point
from pathgene.sim.model.random_source import RandomSource
from pathgene.sim.model.selection import DistinctDraw


__all__ = ["Waypoint", "bits", "breed", "cross", "draw", "mutate"]


class Waypoint(NamedTuple):
    """A waypoint, and the least margin of the segments at it when they were last walked."""

    x: int
    y: int
    z: int
    margin: int = 0


def bits(word: int, low: int, width: int) -> int:
    """Return ``width`` bits of a word from ``low`` on."""
    return word >> low & (1 << width) - 1


def draw(word: int, low: int, width: int, limit: int) -> int:
    """Return a draw below ``limit`` from bits of a word."""
    return bits(word, low, width) * limit >> width


def breed(
    config: Config,
    record: ProblemRecord,
    ends: tuple[Point, Point],
    population: Sequence[Sequence[Waypoint]],
    source: RandomSource,
) -> tuple[list[list[Waypoint]], list[int]]:
    """Return the children of a population sorted from the best, and the ranks of the survivors."""
    width = config.slot_bits
    others = DistinctDraw(config.population - config.elites)
    children, survivors = [], []
    for number in range(config.children):
        selection, mutation = source.step()
        draws = [bits(selection, i * width, width) for i in range(2 * PARENT_DRAWS)]
        first, second = min(draws[:PARENT_DRAWS]), min(draws[PARENT_DRAWS:])
        child = cross(population[first], population[second], mutation)
        children.append(mutate(config, record, ends, child, mutation))
        if number < config.survivors:
            at = draw(selection, 2 * PARENT_DRAWS * width, SURVIVOR_BITS, others.left)
            survivors.append(config.elites + others.take(at))
    return children, survivors


def cross(head: Sequence[Waypoint], tail: Sequence[Waypoint], word: int) -> list[Waypoint]:
    """Return the head of one path and the tail of another.

    Two bits of ``word`` choose where both are cut: behind 1, 3, 5 or 7 eighths of their waypoints,
    rounded down.
    """
    eighths = 2 * bits(word, *CUT) + 1
    return [*head[: len(head) * eighths >> 3], *tail[len(tail) * eighths >> 3 :]]


def mutate(
    config: Config,
    record: ProblemRecord,
    ends: tuple[Point, Point],
    path: Sequence[Waypoint],
    word: int,
) -> list[Waypoint]:
    """Return ``path`` after the mutation of ``word``.

    It chooses the operator, the place, the size, and three offsets in the box of *allaire-2008*, at
    the places of :mod:`pathgene.hdl.protocol.planner_breeding`. What a limit of the length forbids
    becomes a perturbation.
    """
    path = list(path)
    operator, size = draw(word, *OPERATOR, MUTATIONS), bits(word, *SIZE)
    is_insertion = INSERT <= operator < DELETE
    is_deletion = DELETE <= operator < SETTLE
    if is_insertion and len(path) < config.max_waypoints:
        at = draw(word, *PLACE, len(path) + 1)
        start, stop = [ends[0], *path, ends[1]][at : at + 2]
        middle = tuple(a + b >> 1 for a, b in zip(start[:3], stop[:3], strict=True))
        path.insert(at, _moved(config, record, middle, word, size * 7 >> 4))
        return path
    at = draw(word, *PLACE, len(path))
    if is_deletion and len(path) > config.MIN_WAYPOINTS:
        del path[at]
    elif operator < SETTLE:
        path[at] = _moved(config, record, path[at][:3], word, size >> 1)
    else:
        x, y, z, margin = path[at]
        # Half, once or twice the margin down; the whole of a negative one up.
        fall = margin << (size * 3 >> 4) >> 1 if margin >= 0 else margin
        path[at] = Waypoint(x, y, min(max(z - fall, 0), record.altitude_limit))
    return path


def _moved(
    config: Config, record: ProblemRecord, point: Sequence[int], word: int, shift: int
) -> Waypoint:
    """Return a point moved within the box, shifted right by ``shift``, and within the limits."""
    boxes = config.box_cells, config.box_cells, config.box_steps
    limits = record.x_limit, record.y_limit, record.altitude_limit
    first, width = OFFSETS
    moved = []
    for axis, (value, box, limit) in enumerate(zip(point, boxes, limits, strict=True)):
        offset = draw(word, first + width * axis, width, 2 * box + 1) - box
        moved.append(min(max(value + (offset >> shift), 0), limit))
    return Waypoint(*moved)
