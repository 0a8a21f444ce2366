"""Paths for the evaluator, and the results from its model."""

import dataclasses
from dataclasses import dataclass, field

from pathgene.hdl.protocol.planner import POSITION_FRACTION, SLOPE_BITS, VALUE_BITS
from pathgene.sim.model.planner.cycles import (
    counters_vector,
    delays_vector,
    enter,
    goal,
    take,
)
from pathgene.sim.model.planner.definition.score import score
from pathgene.sim.model.planner.evaluation import NO_LIMIT
from pathgene.sim.model.planner.evaluator_cycles import PLACES, cost
from tests.support.planner.cases import path, record, segments_of
from tests.support.planner.plain import Evaluator, Memo


TOP = (1 << VALUE_BITS) - 1


@dataclass
class OfferedPath:
    """A path with its head, and the timing with which it is offered.

    Attributes
    ----------
    points : list of Point
    gap : int
        Cycles without an offer before its first point.
    gaps : sequence of int
        Cycles before each later point, repeated.
    """

    points: list
    slot: int
    first: bool
    limit: int | None
    gap: int = 0
    gaps: tuple = (0,)

    @property
    def head(self):
        """The head of the path, as the fields of a signal."""
        head = {"slot": self.slot, "first": self.first, "limited": self.limit is not None}
        return head | {"limit": 0 if self.limit is None else self.limit}


@dataclass
class Outcome:
    """Result of the evaluator for a path, with the costs of its segments if it is walked."""

    key: int
    slot: int
    length: int
    margins: list = field(default_factory=list)
    costs: list | None = None


def drawn_evaluator(config, rng, terrain, heading, **fields):
    """Return an evaluator over some ground, for a problem with entry (1) and exit (2) or without.

    Nearly all paths are within the limits of the problem.
    """
    steepest = (1 << SLOPE_BITS) - 1
    problem = record(config, rng, **{"climb": steepest, "descent": steepest, **fields})
    far = (config.map_size - 2) << POSITION_FRACTION
    problem = dataclasses.replace(
        problem,
        has_entry=heading & 1,
        entry_y=far // 3,
        entry_altitude=problem.start_altitude,
        has_exit=heading >> 1,
        exit_x=far,
        exit_altitude=problem.goal_altitude,
    )
    return Evaluator(config, problem, terrain, 0)


def drawn_paths(evaluator, rng, count, slots, *, repeat=0.4, gaps=False):
    """Return paths, some of which share segments; most begin right after the previous one."""
    config, record = evaluator.config, evaluator.record
    start, goal = evaluator.ends
    paths, values = [], [0]
    for number in range(count):
        if paths and rng.random() < repeat:
            points = list(paths[-int(rng.integers(1, min(len(paths), 8) + 1))].points)
            points[int(rng.integers(1, len(points) - 1))] = path(config, rng)[1]
        else:
            points = [start, *path(config, rng)[1:-1], goal]
        value = score(record, points).cost >> record.key_shift
        # Also just above the value of a path, so that it is walked.
        values = [*values[-20:], min(max(value, 0), TOP)]
        above = min(int(rng.choice(values)) + int(rng.integers(2)), TOP)
        limit = above if rng.random() < 0.7 else None
        gap = int(rng.choice([0, 0, 0, 0, 1, 2, 3, 40, 150])) if gaps else 0
        # At most two generations are inside at a time.
        first = bool(rng.random() < (0.2, 0.8, 0.5)[number // 20 % 3])
        paths.append(OfferedPath(points, int(rng.integers(slots)), first, limit, gap))
    return paths


def outcomes(evaluator, rows, paths):
    """Return the outcome of each path in an evaluator whose memo has ``rows`` rows."""
    results = []
    memo = Memo(evaluator.config, rows)
    for each in paths:
        margins = [0] * len(each.points)
        limit = NO_LIMIT if each.limit is None else each.limit
        key = evaluator.evaluate(each.points, margins, limit, first=each.first)
        outcome = Outcome(key, each.slot, len(each.points) - 2)
        results.append(outcome)
        scored = score(evaluator.record, each.points)
        value = scored.cost >> evaluator.record.key_shift
        if each.first and (scored.penalty or max(value, 0) >= limit):
            continue
        outcome.margins = [(each.slot, *margin) for margin in enumerate(margins[1:-1])]
        chords = chords_of(evaluator.record, scored)
        outcome.costs = [
            _cost(evaluator.config, memo, start, stop)
            for start, stop, _ in segments_of(each.points, chords, each.first)
        ]
    return results


def chords_of(record, scored):
    """Return the chord at each point of a path, None where there is none."""
    arcs = [None if arc is None else arc.chord for arc in scored.arcs]
    return [*[None] * (1 - record.has_entry), *arcs, *[None] * (1 - record.has_exit)]


def _cost(config, memo, start, stop):
    known = memo.get(start, stop) is not None
    memo.put(start, stop, (0, 0))
    return cost(start, stop, known, config.lanes)


def check_findings(found, expected):
    """Compare keys, margins and cycles of walking with the model's.

    Return the minimum number of cycles from a path's decision and last margin to its key.
    """
    assert found.members == [(each.key, each.slot, each.length) for each in expected]
    assert found.decisions == [(each.slot, each.costs is not None) for each in expected]
    assert found.margins == [margin for each in expected for margin in each.margins]
    written, ahead = iter(found.written), []
    for each, decided, keyed in zip(expected, found.decided, found.keyed, strict=True):
        margins = [next(written) for _ in each.margins]
        assert each.costs is None or len(margins) == each.length
        ahead.append(keyed - max([decided, *margins]))
    assert found.walk == sum(sum(each.costs or ()) for each in expected)
    return min(ahead)


def check_cycles(evaluator, paths, found, expected):
    """Compare cycles of keys and goals with the model; return how many paths waited for room."""
    record = evaluator.record
    delays, counters = delays_vector(evaluator.config), counters_vector()
    late, model = 0, []
    for offer, each, offered in zip(paths, expected, found.offered, strict=True):
        points = len(offer.points) + record.has_entry + record.has_exit
        entering = offered, points, sum(each.costs or ()), record.has_exit
        # The place if no other place were taken.
        free = counters.copy()
        free[-PLACES:] = -1
        enter(delays, free, *entering)
        # Keys are taken in every cycle, one more than if none passes another in the sorter.
        key = take(counters, enter(delays, counters, *entering), -1)
        model.append((key, goal(counters)))
        late += goal(counters) > goal(free)
    assert list(zip(found.keyed, found.goals, strict=True)) == model
    return late
