"""Distances between a path and its via points."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.ends import Point
from pathgene.host.report.nearest import NearTrack


__all__ = ["Visit", "visits"]

Floats = NDArray[np.float64]

# A path may miss a point by the rounding of a file and still visit it.
_ROUNDING_M = 0.01
# Distance of the point from a right-angle turn, the sharpest turn at a joint, in turn radii.
_ROUNDED = math.sqrt(2) - 1


@dataclass(frozen=True)
class Visit:
    """The minimum distance between a path and a via point.

    Parameters
    ----------
    index : int
        Number of the via point, from 1.
    point : tuple of float
        The point: x, y and altitude, metres.
    distance_m : float
        Minimum distance of the smoothed track from the point, in three dimensions.
    horizontal_m, at_m : float
        Horizontal distance at that place, and metres flown to it.
    line_m : float
        Minimum distance of the straight lines through the waypoints from the point, in three
        dimensions.
    missed : bool
        True if neither these lines nor the track pass the point after the previous via point, or if
        the track rounds the point at a greater distance than a right-angle turn would.
    """

    index: int
    point: Point
    distance_m: float
    horizontal_m: float
    at_m: float
    line_m: float
    missed: bool

    def to_dict(self) -> dict[str, Any]:
        """Return the values as in ``summary.json``."""
        return {**asdict(self), "point": list(self.point)}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Visit:
        """Return the visit of a dict from :meth:`to_dict`."""
        x, y, z = values["point"]
        return cls(**{**values, "point": (x, y, z)})

    @property
    def sentence(self) -> str:
        """A sentence for a missed point."""
        x, y, z = self.point
        name = f"via point {self.index} at ({x:.10g}, {y:.10g}, {z:.10g})"
        if min(self.line_m, self.distance_m) <= _ROUNDING_M:
            if self.horizontal_m > _ROUNDING_M:
                return (
                    f"The path turns back at {name} and rounds it at {self.horizontal_m:.1f} m; "
                    "give it two waypoints to turn with."
                )
            return f"The path passes {name} in another order; give the via points in its order."
        return (
            f"The path misses {name} by {self.distance_m:.1f} m; it must have a waypoint there, "
            "which a turn may round."
        )


def visits(evaluator: Evaluator, path: Floats) -> list[Visit]:
    """Return how close a path comes to each point between the ends of its problem.

    Points are visited if the straight lines through the waypoints pass them in order. The smoothed
    track then misses a point only by the rounding of a turn of at most a right angle; a path that
    turns back at a point on one arc does not come close to it. A track that itself passes a point,
    on the arc of a neighbouring waypoint, also visits it.

    Parameters
    ----------
    evaluator : Evaluator
        Evaluates paths of the problem. The goal before a return is the last of these points.
    path : ndarray
        Waypoints, (n, 3) float64 metres.
    """
    points = evaluator.problem.way[1:-1]
    if not points:
        return []
    near_track = NearTrack(evaluator.track(path))
    rounded_m = _ROUNDING_M
    if math.isfinite(evaluator.problem.limits.turn_radius_m):
        rounded_m += _ROUNDED * evaluator.problem.limits.turn_radius_m
    found: list[Visit] = []
    reached = 0.0
    for index, point in enumerate(points, start=1):
        near = near_track.nearest(point)
        places, distances = _nearest_on_lines(path, point)
        line_m = float(distances.min())
        off_m = max(_ROUNDING_M, line_m) if near[0] <= _ROUNDING_M else _ROUNDING_M
        passed = places[(distances <= off_m) & (places >= reached)].tolist()
        reached = min(passed, default=reached)
        beside_m = near_track.nearest(point, axes=2)[0]
        missed = not passed or beside_m > rounded_m
        found.append(Visit(index, point, *near, line_m, missed))
    return found


def _nearest_on_lines(path: Floats, point: Sequence[float]) -> tuple[Floats, Floats]:
    """Return where each segment of a path is closest to a point, and the distance.

    Returns
    -------
    tuple of ndarray
        The place, as the number of the segment plus a fraction of it, and the distance in metres,
        both (n - 1,) float64.
    """
    corners, steps = path[:-1], np.diff(path, axis=0)
    square = (steps**2).sum(axis=1)
    along = ((np.array(point) - corners) * steps).sum(axis=1)
    part = np.clip(along / np.where(square > 0, square, 1), 0, 1)
    distance = np.linalg.norm(corners + part[:, None] * steps - point, axis=1)
    return np.arange(len(steps)) + part, distance
