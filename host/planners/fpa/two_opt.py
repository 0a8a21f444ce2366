"""The 2-opt operator: reverses parts of a path as long as that improves it.

Source: *roberge*, section 3.4.
"""

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import Course, Floats, Scratch
from pathgene.host.evaluation.jit import compiled, inlined
from pathgene.host.evaluation.kernels import fitness_above
from pathgene.host.planners.fpa.steps import Pollination, to_beat


__all__ = [
    "CUT_SHORT",
    "EVALUATED",
    "Counts",
    "copy_path",
    "is_two_opt",
    "reversed_row",
    "untangle",
]

Counts = NDArray[np.int64]

# Counters: candidates evaluated to the end, and candidates abandoned early.
EVALUATED, CUT_SHORT = 0, 1


@inlined
def is_two_opt(iteration: int, every: int) -> bool:
    """Return whether the 2-opt operator follows an iteration; ``every`` is 0 if there is none."""
    return every > 0 and iteration % every == 0


@inlined
def reversed_row(row: int, first: int, last: int) -> int:
    """Return the row that moves to ``row`` when rows ``first`` to ``last`` are reversed."""
    return first + last - row if first <= row <= last else row


@inlined
def copy_path(source: Floats, target: Floats) -> None:
    """Copy a path; both (n, 3)."""
    for row in range(source.shape[0]):
        for axis in range(3):
            target[row, axis] = source[row, axis]


@compiled
def untangle(
    p: Pollination,
    path: Floats,
    fitness: float,
    candidate: Floats,
    course: Course,
    scratch: Scratch,
    counts: Counts,
) -> float:
    """Run the 2-opt operator on ``path`` (n, 3) until no reversal is better; return its fitness.

    Reversals of the waypoints ``i`` to ``j`` are tried in order of i, then j; the first improvement
    replaces the path, and the search starts again. Start and goal stay. It terminates because the
    fitness rises each time and there are finitely many orders of the waypoints. See section 3.4.
    """
    n = path.shape[0]
    first = 1
    while first < n - 2:
        improved = False
        for last in range(first + 1, n - 1):
            for row in range(n):
                source = reversed_row(row, first, last)
                for axis in range(3):
                    candidate[row, axis] = path[source, axis]
            value, exact = fitness_above(candidate, n, course, scratch, to_beat(p, fitness))
            counts[EVALUATED if exact else CUT_SHORT] += 1
            if value > fitness:
                copy_path(candidate, path)
                fitness = value
                improved = True
                break
        first = 1 if improved else first + 1
    return fitness
