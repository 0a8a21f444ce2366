"""An ample search for a path at the instant of a change, with two planners.

It starts at the place and heading of the flight's first attempt, and its paths must pass the same
checks. If it finds none, that does not prove that none exists.
"""

from __future__ import annotations

from dataclasses import dataclass

from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Search
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.replanning.departure import Departure, depart, fault_of
from pathgene.host.replanning.present import Present


__all__ = ["AMPLE_MS", "Question", "is_there_a_path"]

#: Chip time in milliseconds of a plan whose first run finds a path; up to eight first runs, each at
#: most a quarter of that time, search for one.
AMPLE_MS = 50
_SEEDS = range(2)


@dataclass(frozen=True)
class Question:
    """The state in which a flight asked for a new path.

    Parameters
    ----------
    departure : Departure
        Place where the plan begins.
    present : Present
        The situation at that time.
    aircraft : Aircraft
        The aircraft with its remaining fuel.
    since_m : float
        Distance along the track from which it is checked again.
    """

    departure: Departure
    present: Present
    aircraft: Aircraft
    since_m: float


def is_there_a_path(question: Question, chip: Chip) -> bool:
    """Return whether a chip's planner, with ample time, or ``astar`` finds a path."""
    departure = question.departure
    led = depart(question.present, departure.track, departure.leaves_m, is_committed=False)
    committed = depart(question.present, departure.track, departure.leaves_m, is_committed=True)
    searches = [(led, Search("astar"))]
    for seed in _SEEDS:
        searches.append((committed, Search("ga-chip", seed=seed, board=chip, chip_ms=AMPLE_MS)))
    return any(_finds(search, start, question) for start, search in searches)


def _finds(search: Search, departure: Departure, question: Question) -> bool:
    try:
        evaluator = Evaluator(departure.problem(question.present, question.aircraft), threads=1)
        plan = search.run(evaluator)
    except InputError:
        # Start or goal is in a zone, or in the ground.
        return False
    if not plan.evaluation.feasible:
        return False
    path = evaluator.track(plan.path).pieces
    return not fault_of(departure.joined(path, question.since_m), question.present)
