"""Choices of a user about the flight plan of a path."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.mission.autopilot.fence_room import MOST_CORNERS
from pathgene.host.mission.ending import LOITER, Ending, ending_of
from pathgene.host.problem.problem import Problem


__all__ = ["USUAL", "HandOver", "choices_of", "hand_over_of"]

# Greatest tolerance of legs, metres.
_MOST_SIMPLIFY_M = 100.0


@dataclass(frozen=True)
class HandOver:
    """Choices of a user about a flight plan.

    Parameters
    ----------
    fence_corners : int, optional
        Maximum number of corners and circles of fences; by default the autopilot's.
    simplify_m : float
        Maximum distance of the legs from the planned track, except where the aircraft turns.
    autopilot : int, optional
        Value of MAV_AUTOPILOT, if it is known.
    ending : Ending
        The end of the mission after its goal.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    fence_corners: int | None = None
    simplify_m: float = 1.0
    autopilot: int | None = None
    ending: Ending = LOITER

    def __post_init__(self) -> None:
        corners = self.fence_corners
        if corners is not None and not 3 <= corners <= MOST_CORNERS:
            raise InputError(
                f"The corners of fences must be 3 to {MOST_CORNERS:,}, not {corners:,} "
                "(--fence-corners)."
            )
        if not (math.isfinite(self.simplify_m) and 0 <= self.simplify_m <= _MOST_SIMPLIFY_M):
            raise InputError(
                f"The tolerance of the legs must be 0 to {_MOST_SIMPLIFY_M:g} m, not "
                f"{self.simplify_m:g} (--simplify)."
            )


#: The choices of a user who makes none.
USUAL = HandOver()


def hand_over_of(values: Mapping[str, Any], autopilot: int | None = None) -> HandOver:
    """Return the choices among the values of options.

    Raises
    ------
    InputError
        If one is out of range.
    """
    given = {
        field: values[name]
        for field, name in (("fence_corners", "fence_corners"), ("simplify_m", "simplify"))
        if values.get(name) is not None
    }
    return HandOver(autopilot=autopilot, **given)


def choices_of(values: Mapping[str, Any], problem: Problem) -> HandOver:
    """Return the choices among the values of options or of a problem file, the end included.

    Raises
    ------
    InputError
        If one is out of range, or the values contradict each other.
    """
    return replace(hand_over_of(values), ending=ending_of(values, problem) or LOITER)
