"""A problem after changes in flight: zones appear or go, the aircraft moves, the wind turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

from pathgene.host.errors import InputError
from pathgene.host.numeric import is_number
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import wholes
from pathgene.host.problem.zones import Zone, listed


__all__ = ["changed_problem", "zones_after"]


def changed_problem(
    problem: Problem,
    zones: Iterable[Zone] = (),
    start: Sequence[float] | None = None,
    heading: float | None = None,
    *,
    gone: Iterable[Zone] = (),
    goal: Sequence[float] | None = None,
    wind: Sequence[float] | None = None,
    elapsed_s: float = 0.0,
) -> Problem:
    """Return the problem with zones added and removed, new ends, and a new wind.

    A heading of the problem applies only to its own start or goal.

    Parameters
    ----------
    elapsed_s : float
        Seconds flown from the start of the problem to the new start, from which the times of zones
        then count; the times of new zones count from there already.

    Raises
    ------
    InputError
        If a value is not a zone, point, heading or wind, a removed zone does not belong to the
        problem, or the changed problem is invalid.
    """
    known = (*problem.zones, *wholes(problem.zones))
    added = tuple(zone for zone in listed(zones) if zone not in known)
    taken = listed(gone)
    if not (is_number(elapsed_s) and elapsed_s >= 0):
        raise InputError(f"The seconds flown must be a number of 0 or more, not {elapsed_s!r}.")
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
            *zones_after(
                (z for z in problem.zones if z not in taken and z.whole not in taken), elapsed_s
            ),
            *added,
        ),
        wind=problem.wind if wind is None else wind,  # type: ignore[arg-type]
        start_heading_deg=heading,
        goal_heading_deg=problem.goal_heading_deg if goal is None else None,
    )


def zones_after(zones: Iterable[Zone], elapsed_s: float) -> tuple[Zone, ...]:
    """Return zones with times counted from ``elapsed_s``; zones that have ended are left out."""
    later = []
    for zone in zones:
        t0, t1 = zone.t0_s, zone.t1_s
        if elapsed_s and (t0 is not None or t1 is not None):
            if t1 is not None and t1 <= elapsed_s:
                continue
            begin_s = None if t0 is None or t0 <= elapsed_s else t0 - elapsed_s
            end_s = None if t1 is None else t1 - elapsed_s
            zone = dataclasses.replace(zone, t0_s=begin_s, t1_s=end_s)
        later.append(zone)
    return tuple(later)
