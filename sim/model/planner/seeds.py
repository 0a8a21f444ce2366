"""First paths of an island, compiled: points along its route, and remainders of earlier paths."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import SEED_WAYPOINTS, ProblemRecord
from pathgene.sim.model.compiled import compiled
from pathgene.sim.model.planner.breeder import clamp
from pathgene.sim.model.planner.course import (
    ALTITUDE_LIMIT,
    BLOCK_SHIFT,
    BOX_STEPS,
    MAX_WAYPOINTS,
    X_LIMIT,
    Y_LIMIT,
    Course,
    Route,
)
from pathgene.sim.model.planner.definition.score import Point, corner_of
from pathgene.sim.model.planner.random_words import Words, draw, field, step
from pathgene.sim.model.planner.walk import Integers
from pathgene.sim.model.planner.wavefront import LOWEST_X, LOWEST_Y


__all__ = ["ahead", "lift", "seed_path"]


_FEWEST, _MOST = SEED_WAYPOINTS


@compiled
def seed_path(
    course: Course,
    ends: Integers,
    route: Route,
    words: Words,
    path: Integers,
) -> int:
    """Write a path along ``route``; return its number of points.

    Its waypoints are at the centres of the blocks at which the route turns, if the seeds follow
    them. Otherwise they are evenly spaced, each on the lowest corner of its block; their number and
    the place of the first are random. If the seeds follow the guide, they have its waypoints. Each
    has a random height above the surface, or above the waypoint of the guide: uniform within
    the mutation box, shifted right by 0 to 7 for the whole path. The source advances by one step,
    and one more for each waypoint.
    """
    problem, sizes = course.problem, course.sizes
    blocks, surface, places, length, turns, followed, guide, guided = route
    fewest, most = min(_FEWEST, sizes[MAX_WAYPOINTS]), min(_MOST, sizes[MAX_WAYPOINTS])
    step(words)
    count = guided or followed or fewest + draw(words, 0, 0, 8, most - fewest + 1)
    phase, shift = field(words, 0, 8, 8), field(words, 0, 16, 3)
    for axis in range(3):
        path[0, axis], path[count + 1, axis] = ends[axis], ends[3 + axis]
    path[0, 3] = path[count + 1, 3] = 0
    edge = 1 << problem[BLOCK_SHIFT]
    for i in range(count):
        step(words)
        up = draw(words, 0, 0, 16, sizes[BOX_STEPS]) >> shift
        if guided:
            corner_x, corner_y, ground = guide[i, 0], guide[i, 1], guide[i, 2]
        elif followed:
            x, y = turns[i, 0], turns[i, 1]
            ground = surface[y, x]
            corner_x, corner_y = x * edge + (edge >> 1), y * edge + (edge >> 1)
        else:
            at = ((i << 8) + phase) * length // (count << 8)
            x, y = places[at, 0], places[at, 1]
            ground = surface[y, x]
            corner_x, corner_y = blocks[LOWEST_X, y, x], blocks[LOWEST_Y, y, x]
        path[i + 1, 0] = min(corner_x, problem[X_LIMIT])
        path[i + 1, 1] = min(corner_y, problem[Y_LIMIT])
        path[i + 1, 2] = clamp(max(ground, 0) + up, problem[ALTITUDE_LIMIT])
        path[i + 1, 3] = 0
    points: int = count + 2
    return points


@compiled
def lift(problem: Integers, path: Integers, points: int) -> None:
    """Raise each waypoint of ``path`` by the amount of a negative margin."""
    for k in range(1, points - 1):
        path[k, 2] = clamp(path[k, 2] - min(path[k, 3], 0), problem[ALTITUDE_LIMIT])


def ahead(config: Config, record: ProblemRecord, path: Sequence[Point]) -> list[Point]:
    """Return ``path`` without the first waypoints if the start has passed them.

    A corner has been passed unless it lies on the goal's side of the line through the start that is
    perpendicular to the direction of the goal. The minimum number of waypoints is kept.
    """
    start, goal = corner_of(record, "start"), corner_of(record, "goal")
    passed = 0
    for x, y, _ in path[: -config.MIN_WAYPOINTS]:
        if (x - start[0]) * (goal[0] - start[0]) + (y - start[1]) * (goal[1] - start[1]) > 0:
            break
        passed += 1
    return list(path[passed:])
