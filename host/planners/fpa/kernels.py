"""Iterations of the flower pollination algorithm on a CPU, compiled: scalar code, no allocation.

A thread runs whole solutions. An iteration reads only the population before it, and a random number
is a function of seed, iteration, solution and draw, so the result does not depend on the number of
threads. A candidate replaces its solution if it is strictly better.

Source: *roberge*, sections 3.3 and 3.4. :mod:`host.planners.fpa.gpu_kernel` is the same for a GPU.
"""

from typing import NamedTuple

import numpy as np

from host.evaluation.constants import Constants, Flags, Floats
from host.evaluation.jit import compiled
from host.evaluation.kernels import fitness_above
from host.planners.fpa.atomic import fetch_add, read, sleep, yield_core
from host.planners.fpa.steps import Pollination, choose_step, move, to_beat
from host.planners.fpa.two_opt import (
    CUT_SHORT,
    EVALUATED,
    Counts,
    copy_path,
    is_two_opt,
    untangle,
)


__all__ = [
    "BEST_FITNESS",
    "CUT_SHORT_SO_FAR",
    "EVALUATED_SO_FAR",
    "HISTORY_FIELDS",
    "LINE",
    "MEAN_FITNESS",
    "Shared",
    "improve_share",
    "pollinate_share",
    "shared_state",
]

# Counters of different threads are as far apart as lines of a cache, in words.
LINE = 16

# Fields of the record of an iteration; the path of the best is recorded beside them.
BEST_FITNESS, MEAN_FITNESS, EVALUATED_SO_FAR, CUT_SHORT_SO_FAR = range(4)
HISTORY_FIELDS = 4

# Polls of a meeting point before a thread yields its core between two polls (some microseconds),
# and before it sleeps (some hundred).
_POLLS, _YIELDS = 500, 700
_SLEEP_US = np.uint32(50)


class Shared(NamedTuple):
    """State that the threads of a run share, to meet after each iteration.

    Each field is an array of one cache line. ``cursor`` is the next solution that no thread has
    taken, ``arrived`` the number of threads that wait for the others, ``meetings`` the number of
    complete iterations, ``best`` the best solution, g*. Once ``ended`` is 1, all threads leave.
    """

    cursor: Counts
    arrived: Counts
    meetings: Counts
    best: Counts
    ended: Counts


def shared_state(best: int) -> Shared:
    """Return the shared state before the first iteration."""
    shared = Shared(*np.zeros((5, LINE), dtype=np.int64))
    shared.best[0] = best
    return shared


@compiled
def improve_share(
    p: Pollination,
    iteration: int,
    two_opt: bool,
    shared: Shared,
    chunk: int,
    old: Floats,
    old_fitness: Floats,
    new: Floats,
    new_fitness: Floats,
    settled: Flags,
    box: Floats,
    ground: Floats,
    zoned: Floats,
    c: Constants,
    candidate: Floats,
    turns: Floats,
    pieces: Floats,
    counts: Counts,
) -> None:
    """Take solutions through one iteration until none is left; several threads may run it at once.

    Parameters
    ----------
    p, iteration, box
        As for :func:`move`.
    two_opt : bool
        The 2-opt operator follows.
    shared : Shared
        The same for all threads. Each takes ``chunk`` solutions at a time, so that those whose
        2-opt ends early take more.
    old, old_fitness : (m, n, 3), (m,) float64
        The population before the iteration.
    new, new_fitness : (m, n, 3), (m,) float64
        The population after it.
    settled : (m,) uint8
        1 where the last 2-opt left a solution as it is now: another would change nothing.
    ground, zoned, c
        As for :func:`host.evaluation.kernels.path_terms`.
    candidate, turns, pieces : (n, 3), (n, TURN_FIELDS), (2 n, PIECE_FIELDS) float64
        Scratch of one thread.
    counts : (2,) int64
        :data:`EVALUATED` and :data:`CUT_SHORT` are counted up; one array for each thread.
    """
    count, n = old.shape[0], old.shape[1]
    best = shared.best[0]
    while not read(shared.ended):
        start = fetch_add(shared.cursor, chunk)
        if start >= count:
            return
        for i in range(start, min(start + chunk, count)):
            step = choose_step(p, iteration, i, count)
            copy_path(old[i], candidate)
            for d in range(3 * (n - 2)):
                candidate[1 + d // 3, d % 3] = move(p, iteration, i, d, step, old, best, box)
            value, exact = fitness_above(
                candidate, n, ground, zoned, c, to_beat(p, old_fitness[i]), turns, pieces
            )
            counts[EVALUATED if exact else CUT_SHORT] += 1
            if value > old_fitness[i]:
                copy_path(candidate, new[i])
                new_fitness[i] = value
                settled[i] = 0
            else:
                copy_path(old[i], new[i])
                new_fitness[i] = old_fitness[i]
            if two_opt and not settled[i]:
                new_fitness[i] = untangle(
                    p, new[i], new_fitness[i], candidate, ground, zoned, c, turns, pieces, counts
                )
                settled[i] = 1


@compiled
def note_iteration(
    fitness: Floats,
    paths: Floats,
    counts: Counts,
    shared: Shared,
    history: Floats,
    leader: Floats,
) -> None:
    """Find g* and write the record of an iteration; for one thread, in a fixed order."""
    best = 0
    total = 0.0
    for i in range(fitness.shape[0]):
        total += fitness[i]
        if fitness[i] > fitness[best]:
            best = i
    shared.best[0] = best
    copy_path(paths[best], leader)
    history[BEST_FITNESS] = fitness[best]
    history[MEAN_FITNESS] = total / fitness.shape[0]
    history[EVALUATED_SO_FAR] = 0.0
    history[CUT_SHORT_SO_FAR] = 0.0
    for thread in range(counts.shape[0]):
        history[EVALUATED_SO_FAR] += counts[thread, EVALUATED]
        history[CUT_SHORT_SO_FAR] += counts[thread, CUT_SHORT]


@compiled
def pollinate_share(
    p: Pollination,
    first: int,
    iterations: int,
    two_opt_every: int,
    shared: Shared,
    chunk: int,
    paths: Floats,
    fitness: Floats,
    side: int,
    settled: Flags,
    box: Floats,
    ground: Floats,
    zoned: Floats,
    c: Constants,
    candidate: Floats,
    turns: Floats,
    pieces: Floats,
    counts: Counts,
    thread: int,
    history: Floats,
    leaders: Floats,
) -> None:
    """Run one thread's share of some iterations; an iteration ends when all threads have arrived.

    The last thread to arrive finds g*. A waiting thread polls for some microseconds, then yields
    its core between polls, then sleeps, so that it holds no core for long on a busy machine.

    Parameters
    ----------
    first, iterations : int
        The first iteration, and how many.
    shared : Shared
        The same for all threads.
    paths, fitness : (2, m, n, 3), (2, m) float64
        The population is at ``side`` before the first iteration, at the other after it.
    counts : (threads, 16) int64
        See :func:`improve_share`; ``thread`` is this one's row.
    history, leaders : (iterations, HISTORY_FIELDS), (iterations, n, 3) float64
        The record of each iteration; the path of its best.

    The others are those of :func:`improve_share`.
    """
    threads = counts.shape[0]
    for number in range(iterations):
        iteration = first + number
        old = (side + number) % 2
        meeting = read(shared.meetings)
        improve_share(
            p,
            iteration,
            is_two_opt(iteration, two_opt_every),
            shared,
            chunk,
            paths[old],
            fitness[old],
            paths[1 - old],
            fitness[1 - old],
            settled,
            box,
            ground,
            zoned,
            c,
            candidate,
            turns,
            pieces,
            counts[thread],
        )
        if read(shared.ended):
            return
        if fetch_add(shared.arrived, 1) == threads - 1:
            note_iteration(
                fitness[1 - old], paths[1 - old], counts, shared, history[number], leaders[number]
            )
            shared.cursor[0] = 0
            shared.arrived[0] = 0
            fetch_add(shared.meetings, 1)
            continue
        polls = 0
        while read(shared.meetings) == meeting:
            if read(shared.ended):
                return
            polls += 1
            if polls > _YIELDS:
                sleep(_SLEEP_US)
            elif polls > _POLLS:
                yield_core()
