"""The problem of a path through several points: a mission as a whole."""

from __future__ import annotations

import dataclasses
import itertools
import operator
from collections.abc import Sequence
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["WayProblem"]


class WayProblem(Problem):
    """A problem whose costs are relative to the straight lines through several points.

    Less clearance is required near its start and end, but the whole clearance near the points
    between them. The evaluation does not check whether a path passes those points.

    Parameters
    ----------
    terrain : Terrain
        The ground.
    way : sequence of (float, float, float)
        Three points or more, x, y and altitude; the last may equal the first.
    **options
        Options of :class:`Problem`.

    Raises
    ------
    InputError
        If two consecutive points are the same, or as :class:`Problem` does.
    """

    def __init__(self, terrain: Terrain, way: Sequence[Point], **options: Any) -> None:
        if any(itertools.starmap(operator.eq, itertools.pairwise(way))):
            raise InputError("Two points of a mission that follow each other are the same.")
        object.__setattr__(self, "_way", tuple(way))
        super().__init__(terrain, way[0], way[-1], **options)

    @property
    def way(self) -> tuple[Point, ...]:
        """All points in order."""
        points: tuple[Point, ...] = self.__dict__["_way"]
        return points

    def among(self, zones: tuple[Zone, ...]) -> WayProblem:
        """Return the problem with other zones."""
        options = {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}
        del options["start"], options["goal"]
        return WayProblem(way=self.way, **{**options, "zones": zones})
