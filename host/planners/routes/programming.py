"""The deterministic crossover operator: forward dynamic programming by stages, compiled.

Source: *cheng*, section IV with equations (7) to (9). Stage i holds the best routes from the start
to every point over i segments; a route that has reached the goal waits there, so routes may have
fewer segments than stages. The number of stages follows from
:data:`pathgene.host.planners.routes.field.MOST_POINTS`.

No route passes a point twice, although labels do not record their points: terms are not negative,
so a route without its loop has fewer segments and is no worse, and among equal routes the one with
fewer segments is chosen. This does not cover the list of the best few routes, where points already
passed are excluded one by one.
"""

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.jit import allocating, compiled
from pathgene.host.planners.routes.field import GOAL, MOST_POINTS, START


__all__ = ["best_by_sum", "best_by_whole", "segments_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Sums in a different order may differ by this share, so a bound must exceed a total by more.
_ROUNDING = 1e-12


def segments_of(route: Ints) -> Ints:
    """Return the segments of a route, (stages,), in the form that the functions below return."""
    return route[route >= 0]


@allocating
def best_by_sum(
    tails: Ints, heads: Ints, costs: Floats, points: int, keep: int
) -> tuple[Ints, Floats]:
    """Return the best few routes if a route costs the sum of its segments: equation (8).

    The best route is exact. Further routes may be missed, because each label list keeps only
    ``keep`` routes.

    Parameters
    ----------
    tails, heads : (m,) int64
        Points that each segment leaves and reaches; none leads to the start or leaves the goal.
    costs : (m,) float64
        Cost of each segment, 0 or more; infinite if there is no segment.
    points : int
        Number of points, 2 to 62.
    keep : int
        Number of routes, 1 or more.

    Returns
    -------
    tuple
        Segments of each route, (keep, stages) int64, -1 beyond its last one; and the cost of each,
        (keep,) float64, best first, infinite if there is no such route.
    """
    stages = MOST_POINTS - 1
    total = np.full((stages + 1, points, keep), np.inf)
    passed = np.zeros((stages + 1, points, keep), dtype=np.int64)  # A bit for each point.
    edge = np.full((stages + 1, points, keep), -1, dtype=np.int64)
    before = np.zeros((stages + 1, points, keep), dtype=np.int64)  # Slot at the previous stage.
    total[0, START, 0] = 0.0
    passed[0, START, 0] = 1 << START
    for stage in range(1, stages + 1):
        for slot in range(keep):  # Waits at the goal.
            total[stage, GOAL, slot] = total[stage - 1, GOAL, slot]
            before[stage, GOAL, slot] = slot
        for e in range(len(tails)):
            tail, head = tails[e], heads[e]
            for slot in range(keep):
                cost = total[stage - 1, tail, slot] + costs[e]
                if not cost < total[stage, head, keep - 1]:
                    break
                seen = passed[stage - 1, tail, slot]
                if seen >> head & 1:
                    continue
                at = keep - 1
                while at > 0 and cost < total[stage, head, at - 1]:
                    total[stage, head, at] = total[stage, head, at - 1]
                    passed[stage, head, at] = passed[stage, head, at - 1]
                    edge[stage, head, at] = edge[stage, head, at - 1]
                    before[stage, head, at] = before[stage, head, at - 1]
                    at -= 1
                total[stage, head, at] = cost
                passed[stage, head, at] = seen | 1 << head
                edge[stage, head, at] = e
                before[stage, head, at] = slot

    routes = np.full((keep, stages), -1, dtype=np.int64)
    for rank in range(keep):
        if total[stages, GOAL, rank] == np.inf:
            break
        point, slot = GOAL, rank
        for stage in range(stages, 0, -1):
            e = edge[stage, point, slot]
            slot = before[stage, point, slot]
            routes[rank, stage - 1] = e
            if e >= 0:
                point = tails[e]
        # If the last stages waited, the goal was reached early.
        length = 0
        while length < stages and routes[rank, length] >= 0:
            length += 1
        routes[rank, length:] = -1
    return routes, total[stages, GOAL].copy()


@allocating
def least_to_go(tails: Ints, heads: Ints, terms: Floats, points: int) -> Floats:
    """Return lower bounds of length, turning and elevation from each point to the goal.

    The result is (points, 3) float64; each bound is the minimum over all routes, regardless of the
    remaining two terms.
    """
    bounds = np.full((points, 3), np.inf)
    bounds[GOAL] = 0.0
    for _ in range(points):
        for e in range(len(tails)):
            tail, head = tails[e], heads[e]
            bounds[tail, 0] = min(bounds[tail, 0], terms[e, 0] + bounds[head, 0])
            for axis in range(1, 3):
                bounds[tail, axis] = min(
                    bounds[tail, axis], max(terms[e, axis], bounds[head, axis])
                )
    return bounds


@allocating
def best_by_whole(
    tails: Ints, heads: Ints, terms: Floats, weights: Floats, points: int
) -> tuple[Ints, float]:
    """Return the best route if the cost applies to the whole route.

    The first term of a route is the sum over its segments, the second and third are maxima over
    them, and the cost is the weighted mean of the three. A route to a point is kept unless another
    route to the point, over no more segments, is at least as good in all three terms: with any
    continuation, the whole route through that route is no worse. By the same rule no loop is kept.
    A route is also discarded if a bound shows that it cannot beat the best known route. The result
    is exact.

    Parameters
    ----------
    tails, heads : (m,) int64
        Points that each segment leaves and reaches; none leads to the start or leaves the goal.
    terms : (m, 3) float64
        Terms of each segment, 0 or more.
    weights : (3,) float64
        Weights of the terms, 0 or more.
    points : int
        Number of points, 2 or more.

    Returns
    -------
    tuple
        Segments of the route, (stages,) int64, -1 beyond its last one; and its cost, infinite if
        nothing leads to the goal.
    """
    stages = MOST_POINTS - 1
    bounds = least_to_go(tails, heads, terms, points)
    order = np.argsort(tails, kind="mergesort")
    first = np.searchsorted(tails[order], np.arange(points + 1))

    room = 256
    totals = np.empty((room, 3))
    # Columns of a label: its point, the segment that leads there, the previous label, the next at
    # its point, and whether it still counts.
    links = np.empty((room, 5), dtype=np.int64)
    newest = np.full(points, -1, dtype=np.int64)
    totals[0] = 0.0
    links[0] = (START, -1, -1, -1, 1)
    newest[START] = 0
    labels = 1
    weight = weights.sum()
    best = np.inf
    best_label = -1
    begin = 0
    for _ in range(stages):
        end = labels
        for label in range(begin, end):
            if not links[label, 4]:
                continue
            tail = links[label, 0]
            for position in range(first[tail], first[tail + 1]):
                e = order[position]
                head = heads[e]
                length = totals[label, 0] + terms[e, 0]
                turning = max(totals[label, 1], terms[e, 1])
                rate = max(totals[label, 2], terms[e, 2])
                bound = (
                    weights[0] * (length + bounds[head, 0])
                    + weights[1] * max(turning, bounds[head, 1])
                    + weights[2] * max(rate, bounds[head, 2])
                ) / weight
                if not bound <= best * (1.0 + _ROUNDING):
                    continue
                if head == GOAL:
                    if not bound < best:
                        continue
                    best, best_label = bound, labels
                elif dominated(totals, links, newest[head], length, turning, rate, end):
                    continue
                if labels == room:
                    totals = np.concatenate((totals, np.empty((room, 3))))
                    links = np.concatenate((links, np.empty((room, 5), dtype=np.int64)))
                    room *= 2
                totals[labels, 0], totals[labels, 1], totals[labels, 2] = length, turning, rate
                links[labels, 0], links[labels, 1], links[labels, 2] = head, e, label
                links[labels, 3], links[labels, 4] = newest[head], head != GOAL
                newest[head] = labels
                labels += 1
        begin = end

    route = np.full(stages, -1, dtype=np.int64)
    length = 0
    label = best_label
    while label > 0:
        route[length] = links[label, 1]
        label = links[label, 2]
        length += 1
    route[:length] = route[:length][::-1].copy()
    return route, best


@compiled
def dominated(
    totals: Floats, links: Ints, newest: int, length: float, turning: float, rate: float, stage: int
) -> bool:
    """Return whether a label of the list starting at ``newest`` is at least as good in all terms.

    Labels from ``stage`` on belong to the new label's stage; those that it dominates are removed.
    """
    other = newest
    while other >= 0:
        if links[other, 4]:
            if (
                totals[other, 0] <= length
                and totals[other, 1] <= turning
                and totals[other, 2] <= rate
            ):
                return True
            if (
                other >= stage
                and length <= totals[other, 0]
                and turning <= totals[other, 1]
                and rate <= totals[other, 2]
            ):
                links[other, 4] = 0
        other = links[other, 3]
    return False
