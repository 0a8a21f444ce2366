"""Problems and paths for the scorer, and their scores by its model."""

import dataclasses

import numpy as np

from pathgene.hdl.protocol.planner import POSITION_FRACTION, VALUE_BITS
from pathgene.sim.model.planner.course import problem_vector
from pathgene.sim.model.planner.definition.score import score as defined
from pathgene.sim.model.planner.score import FROM_X, HAS_CHORD, WORK_ROWS, score
from tests.support.planner.cases import any_record, headed, path, record, rows


TOP = (1 << VALUE_BITS) - 1


def drawn_problem(config, rng):
    """Return a problem, which in three of four cases has an entry, an exit or both."""
    return headed(config, rng, drawn_free_problem(config, rng))


def drawn_free_problem(config, rng):
    """Return a problem without headings: common, with gentle limits, or with any values."""
    kind = rng.integers(4)
    if kind == 0:
        return any_record(config, rng)
    if kind == 1:
        return record(config, rng)
    # Wide turns, and slopes that some paths meet.
    steps = config.blocked_altitude
    fields = {
        "climb": int(rng.integers(1, 12_000 * steps // 100)),
        "descent": int(rng.integers(1, 12_000 * steps // 100)),
        "radius": int(rng.integers(1, 1 << int(rng.integers(2, POSITION_FRACTION + 6)))),
        "rise": int(rng.integers(1 << int(rng.integers(1, 21)))),
        "drag": int(rng.integers(1 << 14)),
        "fuel_shift": int(rng.integers(32)),
        "key_shift": int(rng.integers(4, 20)),
    }
    ends = {"start_altitude": 8 * steps, "goal_altitude": int(rng.integers(7 * steps, 9 * steps))}
    return record(config, rng, **fields, **(ends if rng.integers(2) else {}))


def drawn_paths(config, rng, problem, count):
    """Return ``count`` paths: random corners, or routes to the goal, some with odd waypoints."""
    paths = []
    for _ in range(count):
        waypoints = int(rng.integers(config.max_waypoints + 1))
        if rng.integers(3) == 0:
            paths.append(path(config, rng, waypoints=waypoints))
            continue
        ends = np.array(
            [
                [getattr(problem, f"{end}_{axis}") for axis in ("x", "y", "altitude")]
                for end in ("start", "goal")
            ]
        ) / [256, 256, 16]
        shares = np.linspace(0, 1, waypoints + 2)[:, None]
        spread = config.map_size * rng.choice([0, 0.01, 0.03, 0.1]) * np.array([1, 1, 0.5])
        points = ends[0] + shares * (ends[1] - ends[0])
        points += rng.normal(size=points.shape) * spread
        limits = [config.map_size - 1, config.map_size - 1, config.blocked_altitude - 1]
        points = np.clip(points, 0, limits).astype(int)
        if waypoints and rng.integers(4) == 0:
            # A repeated waypoint, a vertical hop, or a step back.
            at = int(rng.integers(1, waypoints + 1))
            other = int(rng.integers(waypoints + 2))
            axes = slice(0, int(rng.integers(2, 4)))
            points[at, axes] = points[other, axes]
        paths.append([tuple(point) for point in points.tolist()])
    return paths


def problem_fields(problem):
    """Return the record in the form of a constant of ``problem_layout``."""
    return dataclasses.asdict(problem)


def defined_score(problem, points):
    """Return the score of ``points``, and the chord after each segment, by the definition."""
    result = defined(problem, points)
    chords = [None if arc is None else arc.chord for arc in result.arcs]
    return _sent(problem, result.cost, result.penalty), [*chords, None]


def compiled_score(config, problem, points):
    """Return the score of ``points``, and the chord after each segment, by the compiled model."""
    count = len(points) + problem.has_entry + problem.has_exit
    work = np.zeros((WORK_ROWS, count), dtype=np.int64)
    result = score(problem_vector(config, problem), rows(points), len(points), work, False)
    return _sent(problem, *result), [*compiled_chords(work), None]


def compiled_chords(work):
    """Return the chords in the compiled score's work space, None for an arc without a chord."""
    ends = work[FROM_X:HAS_CHORD, 1:-1].T.tolist()
    has_chord = work[HAS_CHORD, 1:-1].tolist()
    return [
        (tuple(each[:3]), tuple(each[3:])) if has else None
        for each, has in zip(ends, has_chord, strict=True)
    ]


def _sent(problem, cost, penalty):
    """Return ``infeasible`` and ``value`` of a score."""
    value = penalty if penalty else cost >> problem.key_shift
    return bool(penalty), min(max(int(value), 0), TOP)
