"""Model of the random source, compiled: for test batteries that read many gigabytes.

``python -m pathgene.sim.model.random_stream --seed 1 | dieharder -g 200 -a`` tests the raw bits of
the chip's source: the words of each cycle in the order of the ports, least significant byte first.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from numba import njit

from pathgene.hdl.protocol.random_words import LANES, WORD_BITS
from pathgene.sim.model.random_source import Trivium, check_seed


__all__ = ["RandomStream", "main"]

Words = npt.NDArray[np.uint64]

_WORD = (1 << WORD_BITS) - 1
#: Steps between two writes to standard output: 256 KiB of words, which stay in the cache.
_BLOCK_STEPS = 1 << 14


class RandomStream:
    """A :class:`pathgene.sim.model.random_source.RandomSource` that makes many words per call.

    Parameters
    ----------
    seed : int
        0..2**64 - 1.
    """

    def __init__(self, seed: int) -> None:
        check_seed(seed)
        # Each register in two words, the newest bits in the first.
        self._state = np.array(
            [
                [half for bits in Trivium(seed, lane).state for half in (bits & _WORD, bits >> 64)]
                for lane in range(LANES)
            ],
            dtype=np.uint64,
        )

    def words(self, steps: int) -> Words:
        """Return the words of the next ``steps`` steps: ``(steps, LANES)``."""
        words = np.empty((steps, LANES), dtype=np.uint64)
        _fill(self._state, words)
        return words


@njit(cache=True, nogil=True, inline="always")
def _tap(low: np.uint64, high: np.uint64, shift: np.uint64) -> np.uint64:
    """Return the 64 bits of a register from bit ``shift``, 1..63, upwards."""
    return low >> shift | high << (np.uint64(64) - shift)


@njit(cache=True, nogil=True)
def _fill(state: Words, words: Words) -> None:
    """Step every lane of ``state`` and store the words; see :meth:`Trivium.step`."""
    for lane in range(words.shape[1]):
        a, a_high, b, b_high, c, c_high = state[lane]
        for i in range(words.shape[0]):
            t1 = _tap(a, a_high, np.uint64(2)) ^ _tap(a, a_high, np.uint64(29))
            t2 = _tap(b, b_high, np.uint64(5)) ^ _tap(b, b_high, np.uint64(20))
            t3 = _tap(c, c_high, np.uint64(2)) ^ _tap(c, c_high, np.uint64(47))
            words[i, lane] = t1 ^ t2 ^ t3

            t1 ^= _tap(a, a_high, np.uint64(27)) & _tap(a, a_high, np.uint64(28))
            t2 ^= _tap(b, b_high, np.uint64(18)) & _tap(b, b_high, np.uint64(19))
            t3 ^= _tap(c, c_high, np.uint64(45)) & _tap(c, c_high, np.uint64(46))
            t1 ^= _tap(b, b_high, np.uint64(14))
            t2 ^= _tap(c, c_high, np.uint64(23))
            t3 ^= _tap(a, a_high, np.uint64(5))
            # Bits shifted past a register's end are never tapped, so they need no masking.
            a, a_high, b, b_high, c, c_high = t3, a, t1, b, t2, c
        state[lane, 0], state[lane, 1] = a, a_high
        state[lane, 2], state[lane, 3] = b, b_high
        state[lane, 4], state[lane, 5] = c, c_high


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the raw bits of one seed to standard output until its reader closes it."""
    parser = argparse.ArgumentParser(
        prog="python -m pathgene.sim.model.random_stream",
        description="Write the raw bits of the random source until standard output is closed.",
    )
    parser.add_argument("--seed", type=int, default=0, help="0 to 2**64 - 1 (default 0)")
    try:
        stream = RandomStream(parser.parse_args(arguments).seed)
    except ValueError as error:
        parser.error(str(error))
    output = sys.stdout.buffer
    try:
        while True:
            output.write(stream.words(_BLOCK_STEPS).astype("<u8", copy=False).tobytes())
    except BrokenPipeError:
        # The interpreter flushes once more when it ends, into a closed pipe.
        os.dup2(os.open(os.devnull, os.O_WRONLY), output.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
