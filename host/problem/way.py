"""The problem of a path over several points: a mission as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from host.problem.ends import Point
from host.problem.problem import Problem
from host.terrain import Terrain


__all__ = ["WayProblem"]


class WayProblem(Problem):
    """A problem whose costs are relative to the straight lines through several points.

    Near its start and its end less clearance is demanded, near the points between them the whole
    clearance. The evaluation does not look whether a path passes those points.

    Parameters
    ----------
    terrain : Terrain
        The ground.
    way : sequence of (float, float, float)
        Three points or more, x, y and altitude; the last may be the first.
    **options
        Those of :class:`Problem`.
    """

    def __init__(self, terrain: Terrain, way: Sequence[Point], **options: Any) -> None:
        object.__setattr__(self, "_way", tuple(way))
        super().__init__(terrain, way[0], way[-1], **options)

    @property
    def way(self) -> tuple[Point, ...]:
        """All points in order."""
        points: tuple[Point, ...] = self.__dict__["_way"]
        return points
