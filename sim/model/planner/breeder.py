"""Compiled breeding: turns the sorted population and random words into children.

A path is an array of rows x, y, step, margin, including start and goal. Each child takes one step
of the random source. The selection word contains the ranks of its parents and, above them, the draw
of a survivor; the mutation word contains the mutation and, above it, the place where the parents
are cut. A draw below ``n`` is ``bits * n >> width``.
"""

from __future__ import annotations

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.breeding import (
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
from pathgene.sim.model.compiled import compiled, inlined
from pathgene.sim.model.planner.course import ALTITUDE_LIMIT as TOP
from pathgene.sim.model.planner.course import (
    BOX_X,
    CHILDREN,
    ELITES,
    MAX_WAYPOINTS,
    POPULATION,
    RANK_BITS,
    SURVIVORS,
    X_LIMIT,
    Course,
    Members,
)
from pathgene.sim.model.planner.random_words import Words, draw, field, step
from pathgene.sim.model.planner.walk import Integers


__all__ = ["breed", "clamp", "cross", "mutate"]

_MIN_WAYPOINTS = Config.MIN_WAYPOINTS
_FIRST_OFFSET, _OFFSET_BITS = OFFSETS


@compiled
def breed(
    course: Course,
    members: Members,
    free: Integers,
    survivors: Integers,
    others: Integers,
    words: Words,
) -> None:
    """Breed a child for each of the slots ``free``, and draw the ranks of the survivors.

    Parameters
    ----------
    members : Members
        The population; its keys are not read.
    free : (children,) int64
    survivors : (survivors,) int64
        Output: ranks of the survivors, in the order drawn.
    others : (population,) int64
        Work space: the remaining ranks.
    words : Words
        Random source, which advances by one step per child.
    """
    problem, sizes = course.problem, course.sizes
    paths, points, order = members.paths, members.points, members.order
    width = sizes[RANK_BITS]
    left = sizes[POPULATION] - sizes[ELITES]
    for rank in range(left):
        others[rank] = sizes[ELITES] + rank
    for number in range(sizes[CHILDREN]):
        slot = free[number]
        step(words)
        first = second = sizes[POPULATION]
        for i in range(PARENT_DRAWS):
            first = min(first, field(words, 0, i * width, width))
            second = min(second, field(words, 0, (PARENT_DRAWS + i) * width, width))
        child, head, tail = paths[slot], order[first], order[second]
        cut = 2 * field(words, 1, *CUT) + 1
        length = cross(paths[head], points[head], paths[tail], points[tail], child, cut)
        points[slot] = mutate(problem, sizes, child, length, words)
        if number < sizes[SURVIVORS]:
            at = draw(words, 0, 2 * PARENT_DRAWS * width, SURVIVOR_BITS, left - number)
            survivors[number] = others[at]
            for rank in range(at, left - number - 1):
                others[rank] = others[rank + 1]


@inlined
def clamp(value: int, high: int) -> int:
    """Return ``value`` limited to 0..high."""
    return min(max(value, 0), high)


@compiled
def cross(
    head: Integers,
    head_points: int,
    tail: Integers,
    tail_points: int,
    child: Integers,
    eighths: int,
) -> int:
    """Write the head of one path and the tail of another to ``child``; return its number of points.

    Each path is cut after ``eighths`` eighths of its waypoints, rounded down.
    """
    length = 0
    for k in range(((head_points - 2) * eighths >> 3) + 1):
        for i in range(4):
            child[length, i] = head[k, i]
        length += 1
    for k in range(((tail_points - 2) * eighths >> 3) + 1, tail_points):
        for i in range(4):
            child[length, i] = tail[k, i]
        length += 1
    return length


@compiled
def mutate(problem: Integers, sizes: Integers, path: Integers, points: int, words: Words) -> int:
    """Apply the mutation of the mutation word to ``path``; return its number of points.

    The word selects the operator, the place, the size, and three offsets in the box of
    *allaire-2008*, at the places of :mod:`pathgene.hdl.protocol.breeding`. If the length limits
    forbid an insertion or a deletion, the operator becomes a perturbation.
    """
    inner = points - 2
    operator, size = draw(words, 1, *OPERATOR, MUTATIONS), field(words, 1, *SIZE)
    if INSERT <= operator < DELETE and inner < sizes[MAX_WAYPOINTS]:
        at = draw(words, 1, *PLACE, inner + 1)
        for k in range(points, at + 1, -1):
            for i in range(4):
                path[k, i] = path[k - 1, i]
        for axis in range(3):
            path[at + 1, axis] = path[at, axis] + path[at + 2, axis] >> 1
        _move(problem, sizes, path[at + 1], words, size * 7 >> 4)
        return points + 1
    at = 1 + draw(words, 1, *PLACE, inner)
    if DELETE <= operator < SETTLE and inner > _MIN_WAYPOINTS:
        for k in range(at, points - 1):
            for i in range(4):
                path[k, i] = path[k + 1, i]
        return points - 1
    if operator < SETTLE:
        _move(problem, sizes, path[at], words, size >> 1)
        return points
    margin = path[at, 3]
    # Down by half, once or twice the margin, or up by a negative margin.
    fall = margin << (size * 3 >> 4) >> 1 if margin >= 0 else margin
    path[at, 2] = clamp(path[at, 2] - fall, problem[TOP])
    path[at, 3] = 0
    return points


@inlined
def _move(problem: Integers, sizes: Integers, point: Integers, words: Words, shift: int) -> None:
    """Move a point within the box, scaled by a right shift of ``shift``, and within the limits."""
    for axis in range(3):
        box = sizes[BOX_X + axis]
        low = _FIRST_OFFSET + axis * _OFFSET_BITS
        offset = draw(words, 1, low, _OFFSET_BITS, 2 * box + 1) - box
        point[axis] = clamp(point[axis] + (offset >> shift), problem[X_LIMIT + axis])
    point[3] = 0
