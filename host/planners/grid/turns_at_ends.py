"""Waypoints that lead a path from its start onto its route, and from there to its goal."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.problem import Problem


__all__ = ["Leads", "around", "leads"]

Floats = NDArray[np.float64]
#: Waypoints after the start, and before the goal: (k, 2) float64 metres each.
Leads = tuple[Floats, Floats]

_NONE: Floats = np.empty((0, 2))
# Unit vectors to eight points of the compass.
_ANGLES = np.arange(8) * (math.pi / 4)
_COMPASS: Floats = np.stack((np.sin(_ANGLES), np.cos(_ANGLES)), axis=1)
# Turns below the first angle are made at the end itself or just ahead of it; above the second, the
# path must turn back.
_GENTLE_RAD, _BACK_RAD = math.radians(45), math.radians(100)


def leads(problem: Problem) -> Iterator[Leads]:
    """Yield ways of leaving the start and reaching the goal with their headings, in metres.

    Without headings there is a single lead, without waypoints. A waypoint lies a turn radius ahead
    of the start, so that a right angle fits there; if the route leads back, another one lies two
    radii to the side. The ways of reaching the goal mirror these. A way with a waypoint off the map
    is left out.
    """
    start, goal = np.array(problem.start[:2]), np.array(problem.goal[:2])
    after, before = problem.headings
    if not math.isfinite(problem.limits.turn_radius_m):
        after = before = None
    radius = problem.limits.turn_radius_m
    firsts = [_NONE] if after is None else list(_ways(start, np.array(after), goal, radius))
    lasts = [_NONE] if before is None else list(_ways(goal, -np.array(before), start, radius))
    for first, last in itertools.product(firsts, lasts):
        points = np.concatenate((first, last))
        most = problem.terrain.width_m, problem.terrain.height_m
        if ((points >= 0) & (points <= most)).all():
            yield first, last[::-1]


def _ways(end: Floats, heading: Floats, other: Floats, radius: float) -> Iterator[Floats]:
    """Yield the waypoints of ways that leave an end with ``heading`` and lead to ``other``."""
    line = other - end
    cross = heading[0] * line[1] - heading[1] * line[0]
    turn = math.atan2(cross, float(heading @ line))
    ahead = end + radius * heading
    aside = 2.0 * radius * np.array((-heading[1], heading[0]))
    if abs(turn) < _GENTLE_RAD:
        yield _NONE
    if abs(turn) < _BACK_RAD:
        yield ahead[None]
    if abs(turn) > _GENTLE_RAD:
        side = 1.0 if turn >= 0 else -1.0
        yield np.stack((ahead, ahead + side * aside))
        if abs(turn) > _BACK_RAD:
            yield np.stack((ahead, ahead - side * aside))


def around(problem: Problem, at_goal: bool, away_m: float) -> list[Floats]:
    """Return waypoints around the start or the goal, (1, 2) metres each, in eight directions.

    Waypoints off the map are left out; an end with a fixed heading has none.
    """
    if problem.headings[at_goal] is not None or not math.isfinite(away_m):
        return []
    end = np.array((problem.goal if at_goal else problem.start)[:2])
    most = problem.terrain.width_m, problem.terrain.height_m
    places = end + away_m * _COMPASS
    return [place[None] for place in places if ((place >= 0) & (place <= most)).all()]
