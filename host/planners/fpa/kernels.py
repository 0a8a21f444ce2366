"""One iteration of the flower pollination algorithm, compiled: scalar functions, no allocation.

The same source serves a CPU core, where a thread runs whole solutions, and CUDA, where the threads
of a block share one. All is synchronous: an iteration reads the population before it alone, and a
random number is a function of seed, iteration, solution and draw, so that the result does not
depend on the number of threads.

Source: Roberge and Tarbouchi, sections 3.3 and 3.4, equations (4) and (5), table 3. Settled where
they are silent: Levy steps after Mantegna with exponent 1.5, one per coordinate, times 0.1; epsilon
is uniform in [0, 1] times a bound that falls linearly over the iterations; a flower's partners are
two different ones, which may be itself; a candidate replaces its solution if it is strictly better.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from host.evaluation.constants import Constants, Flags, Floats
from host.evaluation.jit import compiled, inlined
from host.evaluation.kernels import fitness_above
from host.planners.fpa.atomic import fetch_add, read, sleep, yield_core
from host.planners.fpa.philox import uniform, words


__all__ = [
    "BEST_FITNESS",
    "CUT_SHORT",
    "CUT_SHORT_SO_FAR",
    "EVALUATED",
    "EVALUATED_SO_FAR",
    "HISTORY_FIELDS",
    "LINE",
    "MEAN_FITNESS",
    "Counts",
    "Pollination",
    "Shared",
    "choose_step",
    "epsilon_bound",
    "global_step",
    "improve_share",
    "is_two_opt",
    "levy_step",
    "local_step",
    "mantegna",
    "move",
    "pollinate_share",
    "reversed_row",
    "shared_state",
    "to_beat",
    "untangle",
]

Counts = NDArray[np.int64]

LEVY_EXPONENT = 1.5
LEVY_SCALE = 0.1
# Deviation of Mantegna's numerator; that of the denominator is 1.
_LEVY_DEVIATION = (
    math.gamma(1 + LEVY_EXPONENT)
    * math.sin(math.pi * LEVY_EXPONENT / 2)
    / (math.gamma((1 + LEVY_EXPONENT) / 2) * LEVY_EXPONENT * 2 ** ((LEVY_EXPONENT - 1) / 2))
) ** (1 / LEVY_EXPONENT)

# Counters of different threads are as far apart as lines of a cache, in words.
LINE = 16

# Counters: candidates evaluated to the end, and those given up once they could not be better.
EVALUATED, CUT_SHORT = 0, 1

# What is told of an iteration, besides the path of the best.
BEST_FITNESS, MEAN_FITNESS, EVALUATED_SO_FAR, CUT_SHORT_SO_FAR = range(4)
HISTORY_FIELDS = 4

# Looks of a thread at a meeting point before it yields its core between two, some microseconds;
# and before it sleeps, some hundred.
_LOOKS, _YIELDS = 500, 700
_SLEEP_US = np.uint32(50)

# Draws of a solution in an iteration: its kind of step, epsilon, then one for each coordinate.
_KIND, _EPSILON, _COORDINATES = 0, 1, 2


class Pollination(NamedTuple):
    """The parameters of table 3 that a step depends on, and the seed.

    ``switch`` is the probability of a global step; epsilon's bound goes from ``first_epsilon`` in
    iteration 1 to ``last_epsilon`` in iteration ``iterations``. Where ``give_up`` is 0, not 1,
    candidates that cannot be better are evaluated to the end all the same.
    """

    seed: np.uint64
    iterations: int
    switch: float
    first_epsilon: float
    last_epsilon: float
    give_up: int = 1


class Shared(NamedTuple):
    """What the threads of a run share to meet after each iteration; arrays of one line of a cache.

    ``cursor`` is the next solution that no thread has taken, ``arrived`` the threads that wait for
    the others, ``meetings`` how often they have met: the iterations that are complete. ``best`` is
    the best solution, g*. Where ``ended`` is 1, all leave as soon as they can.
    """

    cursor: Counts
    arrived: Counts
    meetings: Counts
    best: Counts
    ended: Counts


def shared_state(best: int) -> Shared:
    """What threads share before the first iteration."""
    shared = Shared(*np.zeros((5, LINE), dtype=np.int64))
    shared.best[0] = best
    return shared


@inlined
def is_two_opt(iteration: int, every: int) -> bool:
    """Whether the 2-opt operator follows an iteration; ``every`` is 0 for never."""
    return every > 0 and iteration % every == 0


@inlined
def mantegna(a: float, b: float) -> float:
    """A Levy-stable step of exponent 1.5 from two uniform numbers between 0 and 1.

    Box and Muller make two normal numbers u and v of them; the step is ``u / |v|**(1 / 1.5)``.
    """
    radius = math.sqrt(-2.0 * math.log(a))
    u = _LEVY_DEVIATION * radius * math.cos(2.0 * math.pi * b)
    v = radius * math.sin(2.0 * math.pi * b)
    step: float = u / math.pow(abs(v), 1.0 / LEVY_EXPONENT)
    return step


@inlined
def levy_step(seed: np.uint64, iteration: int, solution: int, coordinate: int) -> float:
    """The Levy step of one coordinate of a solution in an iteration."""
    w = words(seed, iteration, solution, _COORDINATES + coordinate)
    return mantegna(uniform(w[0], w[1]), uniform(w[2], w[3]))


@inlined
def global_step(x: float, best: float, levy: float) -> float:
    """Equation (4) for one coordinate."""
    return x + LEVY_SCALE * levy * (x - best)


@inlined
def local_step(x: float, one: float, other: float, epsilon: float) -> float:
    """Equation (5) for one coordinate."""
    return x + epsilon * (one - other)


@inlined
def epsilon_bound(p: Pollination, iteration: int) -> float:
    """Largest epsilon of ``iteration``, 1 to ``p.iterations``."""
    if p.iterations < 2:
        return p.first_epsilon
    share = (iteration - 1) / (p.iterations - 1)
    return p.first_epsilon + share * (p.last_epsilon - p.first_epsilon)


@inlined
def choose_step(
    p: Pollination,
    iteration: int,
    solution: int,
    count: int,
) -> tuple[bool, int, int, float]:
    """Whether a solution's step is global, and for a local one its two partners and epsilon."""
    w = words(p.seed, iteration, solution, _KIND)
    one = int(np.int64(w[2] * np.uint64(count) >> np.uint64(32)))
    other = int(np.int64(w[3] * np.uint64(count - 1) >> np.uint64(32)))
    if other >= one:
        other += 1
    v = words(p.seed, iteration, solution, _EPSILON)
    epsilon = epsilon_bound(p, iteration) * uniform(v[0], v[1])
    return uniform(w[0], w[1]) < p.switch, one, other, epsilon


@inlined
def move(
    p: Pollination,
    iteration: int,
    solution: int,
    coordinate: int,
    step: tuple[bool, int, int, float],
    paths: Floats,
    best: int,
    box: Floats,
) -> float:
    """One coordinate of a solution's candidate, clipped to the airspace.

    Parameters
    ----------
    p : Pollination
    iteration, solution : int
        Which step of whom.
    coordinate : int
        From 0, three to a free waypoint: row ``1 + coordinate // 3`` of the path.
    step : tuple
        Of :func:`choose_step`.
    paths : (m, n, 3) float64, metres
        The population before the iteration.
    best : int
        Its best solution, g*.
    box : (2, 3) float64, metres
        Lowest and highest corner of the airspace.
    """
    is_global, one, other, epsilon = step
    row, axis = 1 + coordinate // 3, coordinate % 3
    x: float = paths[solution, row, axis]
    if is_global:
        levy = levy_step(p.seed, iteration, solution, coordinate)
        x = global_step(x, paths[best, row, axis], levy)
    else:
        x = local_step(x, paths[one, row, axis], paths[other, row, axis], epsilon)
    clipped: float = min(max(x, box[0, axis]), box[1, axis])
    return clipped


@inlined
def reversed_row(row: int, first: int, last: int) -> int:
    """Where row ``row`` comes from when rows ``first`` to ``last`` are flown backwards."""
    return first + last - row if first <= row <= last else row


@inlined
def copy_path(source: Floats, target: Floats) -> None:
    """Copy a path; both (n, 3)."""
    for row in range(source.shape[0]):
        for axis in range(3):
            target[row, axis] = source[row, axis]


@inlined
def to_beat(p: Pollination, fitness: float) -> float:
    """What a candidate is measured against until it is given up; nothing is below 0."""
    return fitness if p.give_up else 0.0


@compiled
def untangle(
    p: Pollination,
    path: Floats,
    fitness: float,
    candidate: Floats,
    ground: Floats,
    zoned: Floats,
    c: Constants,
    turns: Floats,
    pieces: Floats,
    counts: Counts,
) -> float:
    """Run the 2-opt operator on ``path`` (n, 3) until no reversal is better; return its fitness.

    Reversals of the waypoints ``i`` to ``j`` are tried in the order of i, then j; the first that is
    better replaces the path, and the search starts again. Start and goal stay. It ends because the
    fitness rises and the orders of the waypoints are finitely many. Section 3.4.
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
            value, exact = fitness_above(
                candidate, n, ground, zoned, c, to_beat(p, fitness), turns, pieces
            )
            counts[EVALUATED if exact else CUT_SHORT] += 1
            if value > fitness:
                copy_path(candidate, path)
                fitness = value
                improved = True
                break
        first = 1 if improved else first + 1
    return fitness


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
    """Take solutions through one iteration until none is left; several threads may do so at once.

    Parameters
    ----------
    p, iteration, box
        As for :func:`move`.
    two_opt : bool
        Whether the 2-opt operator follows.
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
    """Find g* and write what is told of an iteration; by one thread, in the same order always."""
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
    """One thread's share of some iterations; each of them ends when all threads are there.

    The last to arrive looks for g*. Who waits looks for some microseconds, then yields its core
    between two looks, then sleeps: it is never in the way for long on a machine that is busy.

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
        What is told of each iteration; the path of its best.

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
        looks = 0
        while read(shared.meetings) == meeting:
            if read(shared.ended):
                return
            looks += 1
            if looks > _YIELDS:
                sleep(_SLEEP_US)
            elif looks > _LOOKS:
                yield_core()
