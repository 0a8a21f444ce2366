"""The plan of a mission and its legs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.planning import Plan
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.report.summary import finite
from pathgene.host.report.via import Visit, visits


if TYPE_CHECKING:
    from pathgene.host.diagnosis import Reason


__all__ = ["JoinedEvaluator", "Leg", "MissionPlan", "capitalised", "reason_of_joint", "shortcoming"]


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg of a mission and its plan.

    Parameters
    ----------
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
    legs : tuple of Leg
        Its legs in order.
    """

    mission: MissionProblem
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
        elapsed_s: float = 0.0,
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


Floats = NDArray[np.float64]

# Sharpest turn at a joint: the arc of a sharper turn begins too early to visit the point.
_SHARPEST_RAD = 0.5 * math.pi
_ROUNDING_RAD = 1e-9


class JoinedEvaluator(Evaluator):
    """Evaluates paths of a leg preceded by the last waypoints of the previous leg.

    The arc at the via point needs room on both legs, and its climb depends on both; a path that is
    feasible here stays feasible in the mission. A turn of more than a right angle there is not
    feasible: its arc would pass the point at more than 0.42 turn radii, up to kilometres away for a
    reversal. The penalty then rises by the radius times the excess angle.

    Parameters
    ----------
    before : ndarray
        Waypoints before its start, (k, 3) float64 metres.
    joined : Problem
        The problem from the first of ``before`` to the leg's goal.
    **options
        Options of :class:`Evaluator`.
    """

    def __init__(self, problem: Problem, before: Floats, joined: Problem, **options: Any) -> None:
        super().__init__(problem, **options)
        self._before = np.ascontiguousarray(before, dtype=np.float64)
        self._joined = Evaluator(joined, **options)

    def among(self, zones: tuple[Zone, ...]) -> JoinedEvaluator:
        """Return the evaluator with other zones; see :meth:`Evaluator.among`."""
        leg, joined = (each.among(zones) for each in (self.problem, self._joined.problem))
        return JoinedEvaluator(leg, self._before, joined, ds_m=self.ds_m, threads=self.threads)

    def evaluate(self, path: Floats) -> Evaluation:
        """Return every term of the previous waypoints and ``path`` as one path."""
        found = self._joined.evaluate(np.concatenate((self._before, self._checked(path))))
        back_m = self._back_m(path[None])
        if back_m[0] == 0:
            return found
        return dataclasses.replace(
            found,
            feasible=False,
            feasible_at_ds=False,
            fitness=float(_lowered(np.array([found.fitness]), back_m)[0]),
            penalty=found.penalty + float(back_m[0]),
            penalty_fine=found.penalty_fine + float(back_m[0]),
        )

    def fitness(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], *, strict: bool = False
    ) -> Floats:
        """Return the fitness of a population; see :meth:`Evaluator.fitness`."""
        found = self._joined.fitness(*self._with_before(paths, lengths), strict=strict)
        return _lowered(found, self._back_m(paths))

    def fitness_counted(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], counted_m: Floats
    ) -> Floats:
        """Return the fitness of a population; see :meth:`Evaluator.fitness_counted`."""
        found = self._joined.fitness_counted(*self._with_before(paths, lengths), counted_m)
        return _lowered(found, self._back_m(paths))

    def penalty_cost(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], *, fine: bool = False
    ) -> tuple[Floats, Floats]:
        """Return penalty and cost of a population; see :meth:`Evaluator.penalty_cost`."""
        penalty, cost = self._joined.penalty_cost(*self._with_before(paths, lengths), fine=fine)
        return penalty + self._back_m(paths), cost

    def _back_m(self, paths: Floats) -> Floats:
        """Return the turn radius times the excess of each path's turn at the joint, (m,) metres."""
        radius = self.problem.limits.turn_radius_m
        if not math.isfinite(radius):
            return np.zeros(len(paths))  # No turn is possible, and evaluations know it.
        paths = np.asarray(paths, dtype=np.float64)
        east, north = (paths[:, 0] - self._before[-1])[:, :2].T
        on_east, on_north = (paths[:, 1] - paths[:, 0])[:, :2].T
        turn = np.abs(
            np.arctan2(east * on_north - north * on_east, east * on_east + north * on_north)
        )
        excess = turn - _SHARPEST_RAD
        return np.where(excess > _ROUNDING_RAD, radius * excess, 0.0)

    def _with_before(
        self, paths: Floats, lengths: NDArray[np.integer[Any]]
    ) -> tuple[Floats, NDArray[np.int64]]:
        paths = np.asarray(paths, dtype=np.float64)
        front = np.broadcast_to(self._before, (len(paths), *self._before.shape))
        joined = np.concatenate((front, paths), axis=1)
        return joined, np.asarray(lengths, dtype=np.int64) + len(self._before)


def _lowered(fitness: Floats, penalty_m: Floats) -> Floats:
    """Return fitness values, equation (3), after adding penalties; 0 changes nothing."""
    before = np.where(fitness > 1, 0.0, 1 / np.minimum(fitness, 1) - 1)
    lowered: Floats = np.where(penalty_m > 0, 1 / (1 + before + penalty_m), fitness)
    return lowered


def reason_of_joint(reason: Reason, joints: Mapping[str, str]) -> Reason:
    """Return a leg's reason without the headings at via points, which are not the user's.

    Parameters
    ----------
    reason : Reason
        The reason why the leg has no path.
    joints : mapping
        Names of the via points at which the leg joins another leg, by its ends ``start`` and
        ``goal``.
    """
    if not any(end in joints for end, _, _ in reason.headings):
        return reason
    demanded, found = [], []
    for end, fixed, flown in reason.headings:
        verb = "leaves" if end == "start" else "reaches"
        point = joints.get(end, f"the {end}")
        other = "the leg before arrives" if end == "start" else "the leg after leaves"
        why = f", as {other}" if end in joints else ""
        demanded.append(f"{verb} {point} heading for {fixed:.0f} degrees{why}")
        found.append(f"{verb} {point} heading for {flown:.0f} degrees")
    points = " and ".join(
        dict.fromkeys(joints[end] for end, *_ in reason.headings if end in joints)
    )
    return dataclasses.replace(
        reason,
        code="joint",
        sentence=f"No path was found that {' and '.join(demanded)}; there is one that "
        f"{' and '.join(found)}. Move {points}, or give it a neighbour from which the turn is "
        "gentler.",
        figure=None,
    )
