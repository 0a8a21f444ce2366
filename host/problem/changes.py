"""A problem after changes in flight: zones appear or go, the aircraft moves, the wind turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.problem.zones import Zone, listed


__all__ = ["changed_problem"]


def changed_problem(
    problem: Problem,
    zones: Iterable[Zone] = (),
    start: Sequence[float] | None = None,
    heading: float | None = None,
    *,
    gone: Iterable[Zone] = (),
    goal: Sequence[float] | None = None,
    wind: Sequence[float] | None = None,
) -> Problem:
    """Return the problem with zones added and removed, new ends, and a new wind.

    A heading of the problem applies only to its own start or goal.

    Raises
    ------
    InputError
        If a value is not a zone, point, heading or wind, a removed zone does not belong to the
        problem, or the changed problem is invalid.
    """
    known = (*problem.zones, *wholes(problem.zones))
    added = tuple(zone for zone in listed(zones) if zone not in known)
    taken = listed(gone)
    for zone in taken:
        if zone not in known:
            raise InputError(f"The zone that is gone is none of the problem: {zone!r}.")
    if heading is None and start is None:
        heading = problem.start_heading_deg
    if heading is not None and problem.as_paper:
        raise InputError("The evaluation of the papers knows no headings; leave the heading out.")
    # The constructor of a problem does not convert numbers.
    return dataclasses.replace(
        problem,
        start=problem.start if start is None else start,  # type: ignore[arg-type]
        goal=problem.goal if goal is None else goal,  # type: ignore[arg-type]
        zones=(
            *(zone for zone in problem.zones if zone not in taken and zone.whole not in taken),
            *added,
        ),
        wind=problem.wind if wind is None else wind,  # type: ignore[arg-type]
        start_heading_deg=heading,
        goal_heading_deg=problem.goal_heading_deg if goal is None else None,
    )
