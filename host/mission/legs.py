"""The plan of a mission and its legs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation
from pathgene.host.mission.mission import Mission
from pathgene.host.planning import Plan
from pathgene.host.problem.zones import Zone
from pathgene.host.report.summary import finite
from pathgene.host.report.via import Visit, visits


__all__ = ["Leg", "MissionPlan", "capitalised", "shortcoming"]


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg of a mission and its plan.

    Parameters
    ----------
    name : str
        Its number and ends, in words.
    path : ndarray
        Waypoints, (n, 3) float64 metres; a straight line if there is no plan.
    plan : Plan or None
        The run of the planner; None for a leg that failed or was not reached.
    failure : str or None
        The message of the failure that ended the leg, or None.
    joined : Evaluation or None
        Terms of the path together with the end of the previous leg, if it was searched that way.
    """

    name: str
    path: NDArray[np.float64]
    plan: Plan | None = None
    failure: str | None = None
    joined: Evaluation | None = None

    @property
    def feasible(self) -> bool:
        """True if the leg has a path that is feasible, on its own or joined to the previous leg."""
        return self.verdict is not None and self.verdict.feasible

    @property
    def verdict(self) -> Evaluation | None:
        """The terms that decide: the leg's own, or the joined ones if only those are feasible.

        On its own, a leg begins with a turn from the heading of arrival, and a sharp corner at a
        via point leaves no room for it. On the arc of the joined legs, the leg may still be
        flyable.
        """
        if self.plan is None:
            return None
        own = self.plan.evaluation
        return self.joined if self.joined is not None and not own.feasible else own

    def describe(self, number: int) -> dict[str, Any]:
        """Return the leg as in ``summary.json``; ``number`` counts from 1."""
        table: dict[str, Any] = {
            "index": number,
            "name": self.name,
            "from": self.path[0].tolist(),
            "to": self.path[-1].tolist(),
            "planned": self.plan is not None,
            "feasible": self.feasible,
            "failure": self.failure,
            "reason": None,
            "fallback": None,
            "waypoints": len(self.path),
        }
        if self.plan is None or self.verdict is None:
            return table
        result, evaluation = self.plan.result, self.plan.evaluation
        table |= {
            "length_m": evaluation.length_m,
            "fitness": self.verdict.fitness,
            "fuel_N": evaluation.fuel_N,
            "start_heading_deg": self.plan.evaluator.problem.start_heading_deg,
            "generations": result.generations,
            "evaluations": result.evaluations,
            "stopped_by": result.stopped_by,
            "seconds": result.seconds,
            "hardware": result.hardware,
            "reason": None if self.plan.reason is None else self.plan.reason.to_dict(),
            "fallback": self.plan.fallback,
        }
        return {key: finite(value) for key, value in table.items()}


@dataclass(frozen=True, repr=False, eq=False)
class MissionPlan(Plan):
    """The plan of a mission of several legs.

    ``path``, ``evaluation`` and ``summary`` cover all legs together. ``history`` counts the
    generations of all legs; its fitness is the fitness of the current leg.

    Parameters
    ----------
    mission : Mission
        The mission.
    legs : tuple of Leg
        Its legs in order.
    """

    mission: Mission
    legs: tuple[Leg, ...]

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of ``summary.json`` in plain JSON values; every number is finite."""
        return {
            **super().summary,
            "legs": [leg.describe(number) for number, leg in enumerate(self.legs, start=1)],
            "via": [list(point) for point in self.mission.via],
            "return": self.mission.return_to_start,
            "visits": [visit.to_dict() for visit in self.visits],
        }

    def replan(
        self,
        zones: Iterable[Zone] = (),
        start: Sequence[float] | None = None,
        heading: float | None = None,
        *,
        gone: Iterable[Zone] = (),
        goal: Sequence[float] | None = None,
        wind: Sequence[float] | None = None,
    ) -> Plan:
        """Refuse: a plan of several legs has no single search to continue from."""
        raise InputError(
            "A plan of several legs cannot be replanned as one; replan its leg, as in "
            "plan.legs[0].plan.replan(...), and plan the later legs again."
        )

    @cached_property
    def visits(self) -> list[Visit]:
        """Minimum distance of the path from each via point, and from the goal before a return."""
        return visits(self.evaluator, self.path)


def shortcoming(summary: Mapping[str, Any]) -> str | None:
    """Return, in a sentence, why the path of a summary must not be flown; None if it may."""
    if summary["feasible"]:
        visited = [Visit.from_dict(visit) for visit in summary.get("visits", ())]
        return next((visit.sentence for visit in visited if visit.missed), None)
    reason = summary["reason"]
    sentence = "No feasible path was found." if reason is None else reason["sentence"]
    leg = next((leg["name"] for leg in summary.get("legs", ()) if not leg["feasible"]), None)
    return sentence if leg is None else f"{capitalised(leg)}: {sentence}"


def capitalised(text: str) -> str:
    """Return a sentence with its first letter as a capital."""
    return text[:1].upper() + text[1:]
