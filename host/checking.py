"""Check of a given path, shared by the command line and the Python API."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.report.read import Run
from pathgene.host.report.summary import describe_problem, terms, version
from pathgene.host.report.via import Visit, visits


__all__ = ["Check", "check", "evaluator_of", "path_fault"]


@dataclass(frozen=True)
class Check:
    """The evaluation of a given path.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    """

    evaluator: Evaluator
    path: NDArray[np.float64]
    evaluation: Evaluation
    source: Mapping[str, Any] = field(default_factory=dict)

    @property
    def report(self) -> dict[str, Any]:
        """The output of ``pathgene check --json``: plain JSON values, every number finite."""
        return {
            "pathgene": version(),
            **terms(self.evaluation),
            "waypoints": self.path.tolist(),
            **describe_problem(self.evaluator, self.source),
            **({"visits": [visit.to_dict() for visit in self.visits]} if self.visits else {}),
        }

    @cached_property
    def visits(self) -> list[Visit]:
        """The minimum distance between the path and each via point of the problem."""
        return visits(self.evaluator, self.path)

    @property
    def fault(self) -> str | None:
        """A sentence: the limit that the path breaks and where, or the via point that it misses.

        None if the path is feasible and misses none.
        """
        if not self.evaluation.feasible:
            return f"The path {self._broken()}."
        return next((visit.sentence for visit in self.visits if visit.missed), None)

    def _broken(self) -> str:
        """Return the end of a sentence that names the limit that the path breaks."""
        # Loaded only if a path is infeasible.
        from pathgene.host.diagnosis.reason import broken_limit, listed

        worst = broken_limit(self.evaluation.limits)
        if worst is not None:
            return worst
        for limit, from_m, to_m in self.evaluator.broken(self.path):
            return f"breaks the limit {limit} from {from_m:.0f} m to {to_m:.0f} m after the start"
        terms = self.evaluation
        parts = {
            "under the terrain": terms.distance_under_terrain_m,
            "in no-fly zones": terms.distance_in_nofly_m,
            "too steep": terms.distance_too_steep_m,
        }
        broken = [f"{metres:.1f} m {where}" for where, metres in parts.items() if metres]
        if terms.impossible_arcs:
            broken.append(f"{terms.impossible_arcs} turns tighter than the aircraft can fly")
        return f"is not feasible: {listed(broken)}" if broken else "touches terrain or a zone"


def path_fault(run: Run) -> str | None:
    """Return, in a sentence, why the path of a finished run must not be flown; None if it may.

    The verdict in the summary is ignored, because the waypoints may have been edited since.
    """
    return check(run.problem, run.path).fault


def check(problem: Problem, path: ArrayLike, *, source: Mapping[str, Any] | None = None) -> Check:
    """Evaluate a path of a problem.

    Parameters
    ----------
    path : array_like
        Waypoints, (n, 3) metres, start and goal included.
    source : mapping, optional
        Origin of the terrain for the report; by default the origin that the terrain states.

    Raises
    ------
    InputError
        If the path is not an array of real numbers, has the wrong shape, does not have the
        problem's start and goal as its ends, or a coordinate is not finite or too large.
    """
    evaluator = evaluator_of(problem)
    waypoints = _waypoints(path)
    try:
        evaluation = evaluator.evaluate(waypoints)
    except ValueError as error:
        raise InputError(f"{error}.") from None
    return Check(
        evaluator,
        waypoints,
        evaluation,
        problem.terrain.loading if source is None else source,
    )


def evaluator_of(problem: Problem) -> Evaluator:
    """Return the evaluator of a problem.

    Raises
    ------
    InputError
        If ``problem`` is not a :class:`Problem`, or its costs have no reference.
    """
    if not isinstance(problem, Problem):
        raise InputError(
            f"The problem must be a Problem, not of the type {type(problem).__name__}."
        )
    return Evaluator(problem)


def _waypoints(path: ArrayLike) -> NDArray[np.float64]:
    """Return a user's path as a new array of float64, of any shape."""
    try:
        if np.asarray(path).dtype.kind in "iufO":
            return np.array(path, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    raise InputError("The path must be rows of three real numbers: x, y and altitude.")
