"""Counter-based random numbers: the generator Philox4x32-10.

The generator has no state, so a draw does not depend on its thread, on the number of threads, or on
other draws. It uses plain integers and is compiled for CPU and CUDA alike.

Source: Salmon, Moraes, Dror and Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3".
"""

import numpy as np

from pathgene.host.evaluation.jit import inlined


__all__ = ["philox", "uniform", "words"]

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
    c0: np.uint64,
    c1: np.uint64,
    c2: np.uint64,
    c3: np.uint64,
    k0: np.uint64,
    k1: np.uint64,
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
