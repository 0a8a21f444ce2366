"""Iterations of the flower pollination algorithm on a CPU, compiled: scalar code, no allocation.

A thread processes whole solutions. An iteration reads only the previous population, and a random
number is a function of seed, iteration, solution and draw, so the result does not depend on the
number of threads. A candidate replaces its solution if it is strictly better.

Source: *roberge*, sections 3.3 and 3.4. :mod:`pathgene.host.planners.fpa.gpu_kernel` is the same
for a GPU.
"""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from pathgene.host.evaluation.constants import Course, Flags, Floats, Scratch
from pathgene.host.evaluation.jit import compiled
from pathgene.host.evaluation.kernels import fitness_above
from pathgene.host.planners.fpa.steps import Pollination, choose_step, move, to_beat
from pathgene.host.planners.fpa.two_opt import (
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
    "Populations",
    "Record",
    "Search",
    "Shared",
    "WorkSpace",
    "fetch_add",
    "improve_share",
    "pollinate_share",
    "read",
    "shared_state",
    "sleep",
    "yield_core",
]


@intrinsic
def fetch_add(_context: Any, _counter: Any, _amount: Any) -> Any:
    """Add ``amount`` to the first of ``counter``, (n,) int64, atomically; return its old value.

    For kernels on the CPU only. A thread that sees the sum also sees everything written before it.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        counter = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", counter.data, arguments[1], "seq_cst")

    return types.int64(types.Array(types.int64, 1, "C"), types.int64), generate


@intrinsic
def read(_context: Any, _counter: Any) -> Any:
    """Return the current first element of ``counter``, (n,) int64, which other threads change."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        counter = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.load_atomic(counter.data, "seq_cst", 8)

    return types.int64(types.Array(types.int64, 1, "C")), generate


@intrinsic
def yield_core(_context: Any) -> Any:
    """Yield the core to a waiting thread: POSIX ``sched_yield``."""
    return types.int32(), _call("sched_yield")


@intrinsic
def sleep(_context: Any, _microseconds: Any) -> Any:
    """Sleep for a number of microseconds, 0 to 999,999: POSIX ``usleep``."""
    return types.int32(types.uint32), _call("usleep", ir.IntType(32))


def _call(name: str, *of: ir.Type) -> Any:
    """Return a code generator for a call to a function of the C library, by its name."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), of)
        function = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
        return builder.call(function, arguments)

    return generate


# Counters of different threads are one cache line apart, in words.
LINE = 16

# Fields of the record of an iteration; the path of the best is recorded with them.
BEST_FITNESS, MEAN_FITNESS, EVALUATED_SO_FAR, CUT_SHORT_SO_FAR = range(4)
HISTORY_FIELDS = 4

# Polls at a barrier before a thread yields its core between polls (a few microseconds), and before
# it sleeps (a few hundred).
_POLLS, _YIELDS = 500, 700
_SLEEP_US = np.uint32(50)


class Search(NamedTuple):
    """Parameters of a run.

    Parameters
    ----------
    two_opt_every : int
        Iterations from one 2-opt to the next; 0 for none.
    chunk : int
        Solutions that a thread takes at a time; a thread whose 2-opt ends early takes another
        chunk.
    box : (2, 3) float64, metres
        Lowest and highest corner of the airspace.
    """

    p: Pollination
    two_opt_every: int
    chunk: int
    box: Floats
    course: Course


class Populations(NamedTuple):
    """The populations before and after an iteration, which swap places in the next iteration.

    Parameters
    ----------
    paths, fitness : (2, m, n, 3), (2, m) float64
        Paths in metres, and their fitness.
    settled : (m,) uint8
        1 if the solution has not changed since its last 2-opt, so that another 2-opt would change
        nothing.
    """

    paths: Floats
    fitness: Floats
    settled: Flags


class WorkSpace(NamedTuple):
    """Work space of one thread: a candidate, (n, 3) float64, and its evaluation."""

    candidate: Floats
    scratch: Scratch


class Record(NamedTuple):
    """Record of each iteration, (iterations, HISTORY_FIELDS), and its best path, (..., n, 3)."""

    history: Floats
    leaders: Floats


class Shared(NamedTuple):
    """State that the threads of a run share in order to synchronize after each iteration.

    Each field is an array of one cache line. ``cursor`` is the next solution that no thread has
    taken, ``arrived`` the number of threads that wait, ``meetings`` the number of completed
    iterations, ``best`` the best solution, g*. Once ``ended`` is 1, all threads leave.
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
    search: Search,
    shared: Shared,
    populations: Populations,
    side: int,
    iteration: int,
    space: WorkSpace,
    counts: Counts,
) -> None:
    """Take solutions through one iteration until none is left; several threads may run it at once.

    Parameters
    ----------
    search, shared : Search, Shared
        Parameters and state of the run, the same for all threads.
    populations : Populations
        The population before the iteration is at ``side``, the one after it at ``1 - side``.
    iteration : int
        From 1.
    counts : (at least 2,) int64
        Counters :data:`EVALUATED` and :data:`CUT_SHORT`, which are incremented; one array for each
        thread.
    """
    p, two_opt_every, chunk, box, course = search
    candidate, scratch = space
    old, old_fitness = populations.paths[side], populations.fitness[side]
    new, new_fitness = populations.paths[1 - side], populations.fitness[1 - side]
    settled = populations.settled
    two_opt = is_two_opt(iteration, two_opt_every)
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
            incumbent = to_beat(p, old_fitness[i])
            value, exact = fitness_above(candidate, n, course, scratch, incumbent)
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
                    p, new[i], new_fitness[i], candidate, course, scratch, counts
                )
                settled[i] = 1


@compiled
def note_iteration(
    fitness: Floats, paths: Floats, counts: Counts, shared: Shared, history: Floats, leader: Floats
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
    search: Search,
    shared: Shared,
    populations: Populations,
    side: int,
    first: int,
    iterations: int,
    thread: int,
    space: WorkSpace,
    counts: Counts,
    record: Record,
) -> None:
    """Run one thread's share of some iterations; an iteration ends when all threads have arrived.

    The last thread to arrive finds g*. A waiting thread polls for some microseconds, then yields
    its core between polls, then sleeps, so that it does not occupy a core for long on a busy
    machine.

    Parameters
    ----------
    search, shared : Search, Shared
        Parameters and state of the run, the same for all threads.
    populations : Populations
        The population before the first iteration is at ``side``.
    first, iterations : int
        Number of the first iteration, and number of iterations.
    thread : int
        Number of this thread, from 0.
    counts : (threads, LINE) int64
        A row for each thread; see :func:`improve_share`.
    record : Record
        The record of each iteration, written by the last thread to arrive.
    """
    threads = counts.shape[0]
    for number in range(iterations):
        old = (side + number) % 2
        meeting = read(shared.meetings)
        improve_share(search, shared, populations, old, first + number, space, counts[thread])
        if read(shared.ended):
            return
        if fetch_add(shared.arrived, 1) == threads - 1:
            note_iteration(
                populations.fitness[1 - old],
                populations.paths[1 - old],
                counts,
                shared,
                record.history[number],
                record.leaders[number],
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
