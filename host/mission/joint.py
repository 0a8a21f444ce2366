"""The joint of two legs at a via point: evaluation of both, and the reason if they do not fit."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from host.diagnosis import Reason
from host.evaluation import Evaluation, Evaluator
from host.problem.problem import Problem


__all__ = ["JoinedEvaluator", "reason_of_joint"]

Floats = NDArray[np.float64]


class JoinedEvaluator(Evaluator):
    """Evaluates paths of a leg with the last waypoints of the leg before it in front.

    The arc at the via point between the two needs room on both, and climbs with both; a path that
    is feasible here stays so in the mission.

    Parameters
    ----------
    problem : Problem
        The leg.
    before : ndarray
        Waypoints before its start, (k, 3) float64 metres.
    joined : Problem
        The problem from the first of ``before`` to the leg's goal.
    **options
        Those of :class:`Evaluator`.
    """

    def __init__(self, problem: Problem, before: Floats, joined: Problem, **options: Any) -> None:
        super().__init__(problem, **options)
        self._before = np.ascontiguousarray(before, dtype=np.float64)
        self._joined = Evaluator(joined, **options)

    def evaluate(self, path: Floats) -> Evaluation:
        """Return every term of the waypoints before and of ``path`` as one path."""
        return self._joined.evaluate(np.concatenate((self._before, self._checked(path))))

    def fitness(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], *, strict: bool = False
    ) -> Floats:
        """Return the fitness of a population; see :meth:`Evaluator.fitness`."""
        return self._joined.fitness(*self._with_before(paths, lengths), strict=strict)

    def fitness_counted(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], counted_m: Floats
    ) -> Floats:
        """Return the fitness of a population; see :meth:`Evaluator.fitness_counted`."""
        return self._joined.fitness_counted(*self._with_before(paths, lengths), counted_m)

    def penalty_cost(
        self, paths: Floats, lengths: NDArray[np.integer[Any]], *, fine: bool = False
    ) -> tuple[Floats, Floats]:
        """Return penalty and cost of a population; see :meth:`Evaluator.penalty_cost`."""
        return self._joined.penalty_cost(*self._with_before(paths, lengths), fine=fine)

    def _with_before(
        self, paths: Floats, lengths: NDArray[np.integer[Any]]
    ) -> tuple[Floats, NDArray[np.int64]]:
        paths = np.asarray(paths, dtype=np.float64)
        front = np.broadcast_to(self._before, (len(paths), *self._before.shape))
        joined = np.concatenate((front, paths), axis=1)
        return joined, np.asarray(lengths, dtype=np.int64) + len(self._before)


def reason_of_joint(reason: Reason, joints: Mapping[str, str]) -> Reason:
    """Return the reason of a leg without headings that nobody gave: those at its via points.

    Parameters
    ----------
    reason : Reason
        The reason why the leg has no path.
    joints : mapping
        Names of the via points at which the leg is joined to another, by its ends ``start`` and
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
