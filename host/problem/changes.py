"""A problem after changes in flight: the aircraft has moved, zones have come."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

from host.errors import InputError
from host.problem.problem import Problem
from host.problem.zones import Zone


__all__ = ["changed_problem"]


def changed_problem(
    problem: Problem,
    zones: Iterable[Zone] = (),
    start: Sequence[float] | None = None,
    heading: float | None = None,
) -> Problem:
    """Return the problem with zones added, another start, and the heading there.

    A heading of the problem itself holds for its own start alone.

    Raises
    ------
    InputError
        If they are no zones, no point or no heading, or the problem has none with these changes.
    """
    given = tuple(zones) if isinstance(zones, Iterable) else (None,)
    if not all(isinstance(zone, Zone) for zone in given):
        raise InputError(f"The zones must be a list of no-fly zones, not {zones!r}.")
    added = tuple(zone for zone in given if isinstance(zone, Zone) and zone not in problem.zones)
    if heading is None and start is None:
        heading = problem.start_heading_deg
    if heading is not None and problem.as_paper:
        raise InputError("The evaluation of the papers knows no headings; leave the heading out.")
    # The function that makes a problem takes three numbers as they are.
    return dataclasses.replace(
        problem,
        start=problem.start if start is None else start,  # type: ignore[arg-type]
        zones=problem.zones + added,
        start_heading_deg=heading,
    )
