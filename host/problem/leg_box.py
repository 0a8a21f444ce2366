"""The box of a terrain that the chip's map covers: the leg from start to goal, with room around."""

from __future__ import annotations

import math

from pathgene.host.problem.problem import Problem


__all__ = ["leg_box"]

#: Room around start and goal: this share of the distance between them, and at least these radii.
_ROOM, _ROOM_RADII = 0.25, 8.0


def leg_box(problem: Problem, size: int) -> tuple[slice, slice] | None:
    """Return rows and columns of the terrain's nodes around start and goal.

    The box has ``size`` nodes along each axis, at which every node is a cell of the map, or as many
    more as the leg with its room needs.

    Parameters
    ----------
    size : int
        Cells of an axis of the map.

    Returns
    -------
    (slice, slice) or None
        None if the box is the whole terrain.
    """
    terrain = problem.terrain
    ends = problem.start, problem.goal
    room_m = _ROOM * math.dist(ends[0][:2], ends[1][:2])
    radius_m = problem.limits.turn_radius_m
    if math.isfinite(radius_m):
        room_m = max(room_m, _ROOM_RADII * radius_m)
    rows, columns = (
        _span([end[axis] for end in ends], room_m, spacing_m, nodes, size)
        for axis, spacing_m, nodes in (
            (1, terrain.dy_m, terrain.shape[0]),
            (0, terrain.dx_m, terrain.shape[1]),
        )
    )
    is_whole = (rows.stop - rows.start, columns.stop - columns.start) == terrain.shape
    return None if is_whole else (rows, columns)


def _span(ends_m: list[float], room_m: float, spacing_m: float, nodes: int, size: int) -> slice:
    """Return the nodes of an axis around the ends."""
    first = math.floor((min(ends_m) - room_m) / spacing_m)
    last = math.ceil((max(ends_m) + room_m) / spacing_m)
    count = min(max(last - first + 1, size), nodes)
    start = min(max((first + last - count + 1) // 2, 0), nodes - count)
    return slice(start, start + count)
