"""Compiled model of the random source, for test batteries that read many gigabytes.

``python -m pathgene.sim.model.random_stream --seed 1 | dieharder -g 200 -a`` tests the raw bits of
the chip's source: the words of each cycle in the order of the ports, least significant byte first.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

import numpy as np

from pathgene.hdl.protocol.random_words import LANES
from pathgene.sim.model.compiled import compiled
from pathgene.sim.model.planner.random_words import Words, source, tap


__all__ = ["RandomStream", "main"]

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
        self._state = source(seed)

    def words(self, steps: int) -> Words:
        """Return the words of the next ``steps`` steps: ``(steps, LANES)``."""
        words = np.empty((steps, LANES), dtype=np.uint64)
        _fill(self._state, words)
        return words


@compiled
def _fill(state: Words, words: Words) -> None:
    """Step every lane of ``state`` for each row of ``words``, as ``step``, and store the words."""
    for lane in range(len(state)):
        a, a_high, b, b_high, c, c_high, _ = state[lane]
        for i in range(len(words)):
            t1 = tap(a, a_high, 2) ^ tap(a, a_high, 29)
            t2 = tap(b, b_high, 5) ^ tap(b, b_high, 20)
            t3 = tap(c, c_high, 2) ^ tap(c, c_high, 47)
            words[i, lane] = t1 ^ t2 ^ t3

            t1 ^= tap(a, a_high, 27) & tap(a, a_high, 28) ^ tap(b, b_high, 14)
            t2 ^= tap(b, b_high, 18) & tap(b, b_high, 19) ^ tap(c, c_high, 23)
            t3 ^= tap(c, c_high, 45) & tap(c, c_high, 46) ^ tap(a, a_high, 5)
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
        # The interpreter flushes again at exit, into a closed pipe.
        os.dup2(os.open(os.devnull, os.O_WRONLY), output.fileno())
        return 0


if __name__ == "__main__":
    sys.exit(main())
