"""The track of a planned path, from which every format is written."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator, SmoothedTrack
from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.formats.track import Track
from pathgene.host.problem.problem import Problem
from pathgene.host.report.marks import mark_names, marked_waypoints


__all__ = ["track_of"]


def track_of(
    problem: Problem,
    path: NDArray[np.float64],
    curve: SmoothedTrack | None = None,
    *,
    flight: FlightPlan | None = None,
    page: Callable[[], str] | None = None,
) -> Track:
    """Return the track of a path of a problem.

    Parameters
    ----------
    problem : Problem
        The problem.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    curve : SmoothedTrack, optional
        The smoothed path, if it is already computed.
    flight, page
        As for :class:`Track`.
    """
    return Track(
        path,
        Evaluator(problem).track(path) if curve is None else curve,
        problem.terrain,
        tuple(zip(mark_names(problem.way), problem.way, strict=True)),
        marked_waypoints(path, problem.way),
        tuple(zone.shape for zone in problem.zones),
        flight,
        page,
    )
