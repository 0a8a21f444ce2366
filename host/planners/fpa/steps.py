"""Steps of the flower pollination algorithm: parameters, Levy flights, local steps.

A step of a coordinate depends only on the seed, the iteration, the solution and the coordinate, so
that any number of threads, or a GPU, takes the same steps.

Source: *roberge*, section 3.3, equations (4) and (5), table 3. They leave some points open; here,
Levy steps follow Mantegna with exponent 1.5, one per coordinate, times 0.1; epsilon is uniform in
[0, 1] times a bound that falls linearly over the iterations; the two partners of a solution differ,
and one of them may be the solution itself.
"""

import math
from typing import NamedTuple

import numpy as np

from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.jit import inlined


__all__ = [
    "Pollination",
    "choose_step",
    "epsilon_bound",
    "global_step",
    "levy_step",
    "local_step",
    "mantegna",
    "move",
    "philox",
    "to_beat",
    "uniform",
    "words",
]


Words = tuple[np.uint64, np.uint64, np.uint64, np.uint64]

_ROUNDS = 10
_MULTIPLIERS = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_KEY_STEPS = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_WORD = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
# A uniform number has 52 bits, so that half a step is exact, too.
_DROPPED = np.uint64(12)
_STEP = 2.0**-52


@inlined
def philox(
    c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, k0: np.uint64, k1: np.uint64
) -> Words:
    """Return four random words of 32 bits for a counter of four and a key of two; all uint64."""
    for _ in range(_ROUNDS):
        low = _MULTIPLIERS[0] * c0
        high = _MULTIPLIERS[1] * c2
        c0, c1, c2, c3 = (
            (high >> _HALF) ^ c1 ^ k0,
            high & _WORD,
            (low >> _HALF) ^ c3 ^ k1,
            low & _WORD,
        )
        k0 = (k0 + _KEY_STEPS[0]) & _WORD
        k1 = (k1 + _KEY_STEPS[1]) & _WORD
    return c0, c1, c2, c3


@inlined
def words(seed: np.uint64, iteration: int, solution: int, number: int) -> Words:
    """Return the words of draw ``number`` for a solution in an iteration; each 0..2**32 - 1.

    ``number`` and ``solution`` are below 2**32, ``iteration`` and ``seed`` below 2**64.
    """
    step = np.uint64(iteration)
    return philox(
        np.uint64(number),
        np.uint64(solution),
        step & _WORD,
        step >> _HALF,
        seed & _WORD,
        seed >> _HALF,
    )


@inlined
def uniform(high: np.uint64, low: np.uint64) -> float:
    """Return a number strictly between 0 and 1 made from two words."""
    bits = ((np.uint64(high) << _HALF) | np.uint64(low)) >> _DROPPED
    return (np.float64(bits) + 0.5) * _STEP


LEVY_EXPONENT = 1.5
LEVY_SCALE = 0.1
# Deviation of Mantegna's numerator; the deviation of the denominator is 1.
_LEVY_DEVIATION = (
    math.gamma(1 + LEVY_EXPONENT)
    * math.sin(math.pi * LEVY_EXPONENT / 2)
    / (math.gamma((1 + LEVY_EXPONENT) / 2) * LEVY_EXPONENT * 2 ** ((LEVY_EXPONENT - 1) / 2))
) ** (1 / LEVY_EXPONENT)

# Draws of a solution in an iteration: its kind of step, epsilon, then one for each coordinate.
_KIND, _EPSILON, _COORDINATES = 0, 1, 2


class Pollination(NamedTuple):
    """The parameters of table 3 that a step depends on, and the seed.

    ``switch`` is the probability of a global step; epsilon's bound goes from ``first_epsilon`` in
    iteration 1 to ``last_epsilon`` in iteration ``iterations``. If ``give_up`` is 0 instead of 1,
    candidates that cannot be better are still evaluated to the end.
    """

    seed: np.uint64
    iterations: int
    switch: float
    first_epsilon: float
    last_epsilon: float
    give_up: int = 1


@inlined
def mantegna(a: float, b: float) -> float:
    """A Levy-stable step of exponent 1.5 from two uniform numbers between 0 and 1.

    The Box-Muller transform yields two normal numbers u and v; the step is ``u / |v|**(1 / 1.5)``.
    """
    radius = math.sqrt(-2.0 * math.log(a))
    u = _LEVY_DEVIATION * radius * math.cos(2.0 * math.pi * b)
    v = radius * math.sin(2.0 * math.pi * b)
    step: float = u / math.pow(abs(v), 1.0 / LEVY_EXPONENT)
    return step


@inlined
def levy_step(seed: np.uint64, iteration: int, solution: int, coordinate: int) -> float:
    """Return the Levy step of one coordinate of a solution in an iteration."""
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
    p: Pollination, iteration: int, solution: int, count: int
) -> tuple[bool, int, int, float]:
    """Choose a solution's kind of step (True: global), and a local step's partners and epsilon."""
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
    """Return one coordinate of a solution's candidate, clipped to the airspace.

    Parameters
    ----------
    iteration, solution : int
        Numbers of the step and its solution.
    coordinate : int
        From 0, three per free waypoint: row ``1 + coordinate // 3`` of the path.
    step : tuple
        Result of :func:`choose_step`.
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
def to_beat(p: Pollination, fitness: float) -> float:
    """Return the fitness that a candidate must exceed to be evaluated to the end; 0 accepts all."""
    return fitness if p.give_up else 0.0
