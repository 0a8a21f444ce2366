"""Warm start: the rest of the paths of an earlier run."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ProblemRecord
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.definition.walk import Point


__all__ = ["ahead"]


def ahead(config: Config, record: ProblemRecord, path: Sequence[Point]) -> list[Point]:
    """Return ``path`` without the first waypoints that the start has passed.

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
