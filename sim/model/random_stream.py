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
from pathgene.sim.model.planner.random_words import WORD, Words, source, step


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
    """Store the words of one step in each row of ``words``."""
    for row in range(len(words)):
        step(state)
        for lane in range(len(state)):
            words[row, lane] = state[lane, WORD]


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
