"""Compiled random words of the chip: :class:`pathgene.sim.model.random_source.RandomSource`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pathgene.hdl.protocol.random_words import LANES, WARM_UP_STEPS
from pathgene.sim.model.compiled import compiled, inlined
from pathgene.sim.model.random_source import check_seed


__all__ = ["WORD", "Words", "draw", "field", "source", "step", "tap"]

#: ``(LANES, 7)`` uint64: registers a, b and c of each lane as low and high halves, then its current
#: word.
Words = npt.NDArray[np.uint64]

#: Places of a lane.
_A_LOW, _A_HIGH, _B_LOW, _B_HIGH, _C_LOW, _C_HIGH, WORD = range(7)
_A_MASK, _B_MASK, _C_MASK = ((1 << width - 64) - 1 for width in (93, 84, 111))


def source(seed: int) -> Words:
    """Return the source of ``seed``, warmed up.

    Raises
    ------
    ValueError
        If ``seed`` is not from 0 to 2**64 - 1.
    """
    check_seed(seed)
    words = np.zeros((LANES, 7), dtype=np.uint64)
    for lane in range(LANES):
        words[lane, _A_LOW] = seed
        words[lane, _B_LOW] = lane
        words[lane, _C_HIGH] = 0b111 << 111 - 3 - 64
    for _ in range(WARM_UP_STEPS):
        step(words)
    return words


@compiled
def step(words: Words) -> None:
    """Advance every lane by 64 bits."""
    for lane in range(len(words)):
        one = words[lane]
        a, b, c = one[_A_LOW], one[_B_LOW], one[_C_LOW]
        a_up, b_up, c_up = one[_A_HIGH], one[_B_HIGH], one[_C_HIGH]
        t1 = tap(a, a_up, 2) ^ tap(a, a_up, 29)
        t2 = tap(b, b_up, 5) ^ tap(b, b_up, 20)
        t3 = tap(c, c_up, 2) ^ tap(c, c_up, 47)
        one[WORD] = t1 ^ t2 ^ t3
        one[_B_LOW] = t1 ^ (tap(a, a_up, 27) & tap(a, a_up, 28)) ^ tap(b, b_up, 14)
        one[_C_LOW] = t2 ^ (tap(b, b_up, 18) & tap(b, b_up, 19)) ^ tap(c, c_up, 23)
        one[_A_LOW] = t3 ^ (tap(c, c_up, 45) & tap(c, c_up, 46)) ^ tap(a, a_up, 5)
        one[_A_HIGH] = a & np.uint64(_A_MASK)
        one[_B_HIGH] = b & np.uint64(_B_MASK)
        one[_C_HIGH] = c & np.uint64(_C_MASK)


@inlined
def tap(low: np.uint64, high: np.uint64, bit: int) -> np.uint64:
    """Return 64 bits of a register, starting at ``bit``."""
    return low >> np.uint64(bit) | high << np.uint64(64 - bit)


@inlined
def field(words: Words, lane: int, low: int, width: int) -> int:
    """Return bits ``low`` to ``low + width - 1``, at most 62, of a lane's word."""
    return int(np.int64(words[lane, WORD] >> np.uint64(low) & np.uint64((1 << width) - 1)))


@inlined
def draw(words: Words, lane: int, low: int, width: int, limit: int) -> int:
    """Return a draw below ``limit`` from bits of a lane's word: ``bits * limit >> width``."""
    return field(words, lane, low, width) * limit >> width
