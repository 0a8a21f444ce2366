"""The first population of a planner whose paths have a fixed number of waypoints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.planners.airspace import Airspace


__all__ = ["first_population", "with_more_waypoints"]

Path = NDArray[np.float64]


def first_population(
    space: Airspace,
    rng: np.random.Generator,
    count: int,
    waypoints: int,
    given: Sequence[Path] = (),
) -> NDArray[np.float64]:
    """Return ``count`` paths, (count, n, 3) float64 metres, start and goal included.

    The paths of ``given`` come first, in order;
    :meth:`~pathgene.host.planners.airspace.Airspace.draw` draws the waypoints of the remaining
    paths. All paths get the same number of waypoints, n - 2: ``waypoints``, or the maximum among
    the given paths if that is greater. A given path with fewer waypoints gets more on its track.

    Parameters
    ----------
    space : Airspace
        The airspace, with start and goal.
    rng : Generator
        Draws the waypoints.
    count, waypoints : int
        Number of paths, 1 or more; minimum number of waypoints, 0 or more.
    given : sequence of (k, 3) float64
        Paths to start from, including the ends; at most ``count`` are used.
    """
    points = max([waypoints + 2, *(len(path) for path in given)])
    paths = np.empty((count, points, 3))
    taken = [with_more_waypoints(path, points) for path in given[:count]]
    if taken:
        paths[: len(taken)] = taken
    drawn = count - len(taken)
    inner = space.draw(rng, drawn * (points - 2))
    paths[len(taken) :, 1:-1] = inner.reshape(drawn, points - 2, 3)
    paths[:, 0], paths[:, -1] = space.start, space.goal
    return paths


def with_more_waypoints(path: Path, points: int) -> Path:
    """Return ``path`` with new waypoints on its longest legs until it has ``points`` points."""
    while len(path) < points:
        legs = np.linalg.norm(np.diff(path, axis=0), axis=1)
        longest = int(np.argmax(legs))
        middle = path[longest : longest + 2].mean(axis=0)
        path = np.insert(path, longest + 1, middle, axis=0)
    return path
