"""Where the iterations of the flower pollination algorithm run: one core, or all of them."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from host.evaluation import Evaluator
from host.evaluation.kernels import scratch
from host.planners.fpa.kernels import Counts, Pollination, improve_share


__all__ = ["CpuEngine", "Engine", "Leader", "is_two_opt"]

Paths = NDArray[np.float64]

# Solutions a thread takes at a time: few enough that no thread waits long for another's 2-opt.
_CHUNK = 4
# Counters of a thread are as far apart as cache lines.
_COUNTERS = 16


class Leader(NamedTuple):
    """The state after one iteration: best solution (n, 3) in metres, its fitness, and the mean."""

    path: Paths
    fitness: float
    mean: float


class Engine(Protocol):
    """Runs iterations over a population that it keeps.

    Attributes
    ----------
    stride : int
        Iterations that are best asked for at once.
    """

    stride: int

    def advance(self, first: int, count: int) -> Sequence[Leader]:
        """Run iterations ``first``, from 1, to ``first + count - 1``."""

    def population(self) -> tuple[Paths, NDArray[np.float64]]:
        """All paths (m, n, 3) in metres and their fitness (m,), after the last iteration."""

    def counts(self) -> tuple[int, int]:
        """Candidates evaluated to the end so far, and those given up before."""

    def close(self) -> None:
        """Let go of threads and memory."""


def is_two_opt(iteration: int, every: int) -> bool:
    """Whether the 2-opt operator follows an iteration; ``every`` is 0 for never."""
    return every > 0 and iteration % every == 0


class CpuEngine:
    """One or several threads of the processor; the result is the same for any number of them.

    In an iteration each thread takes a few solutions at a time until none is left. Who is done
    early sleeps until the next.

    Parameters
    ----------
    evaluator : Evaluator
        The worth of paths.
    parameters : Pollination
        Of the steps.
    two_opt_every : int
        Iterations from one 2-opt to the next; 0 for none.
    box : (2, 3) float64, metres
        The airspace.
    paths, fitness : (m, n, 3), (m,) float64
        The first population, ends included, and its worth.
    threads : int
        1 or more.
    """

    stride = 1

    def __init__(
        self, evaluator: Evaluator, parameters: Pollination, two_opt_every: int, box: Paths,
        paths: Paths, fitness: NDArray[np.float64], threads: int,
    ) -> None:
        self._parameters = parameters
        self._two_opt_every = two_opt_every
        self._box = box
        self._arguments = evaluator.kernel_arguments
        self._paths, self._fitness = paths.copy(), fitness.copy()
        self._next_paths, self._next_fitness = paths.copy(), fitness.copy()
        self._best = int(np.argmax(fitness))
        self._settled = np.zeros(len(paths), dtype=np.uint8)
        self._cursor = np.zeros(1, dtype=np.int64)
        points = paths.shape[1]
        self._scratch = [(np.empty((points, 3)), *scratch(points)) for _ in range(threads)]
        self._counts: Counts = np.zeros((threads, _COUNTERS), dtype=np.int64)
        self._helpers = ThreadPoolExecutor(threads - 1, "pollinate") if threads > 1 else None

    def advance(self, first: int, count: int) -> Sequence[Leader]:
        """See :class:`Engine`."""
        return [self._iterate(iteration) for iteration in range(first, first + count)]

    def population(self) -> tuple[Paths, NDArray[np.float64]]:
        """See :class:`Engine`."""
        return self._paths.copy(), self._fitness.copy()

    def counts(self) -> tuple[int, int]:
        """See :class:`Engine`."""
        evaluated, cut_short, *_ = self._counts.sum(axis=0).tolist()
        return evaluated, cut_short

    def close(self) -> None:
        """See :class:`Engine`."""
        if self._helpers is not None:
            self._helpers.shutdown()

    def _iterate(self, iteration: int) -> Leader:
        self._cursor[0] = 0

        def share(thread: int) -> None:
            improve_share(
                self._parameters, iteration, is_two_opt(iteration, self._two_opt_every),
                self._cursor, _CHUNK, self._paths, self._fitness, self._best, self._next_paths,
                self._next_fitness, self._settled, self._box, *self._arguments,
                *self._scratch[thread], self._counts[thread])

        helping = [] if self._helpers is None else [
            self._helpers.submit(share, thread) for thread in range(1, len(self._counts))]
        share(0)
        for help_ in helping:
            help_.result()
        self._paths, self._next_paths = self._next_paths, self._paths
        self._fitness, self._next_fitness = self._next_fitness, self._fitness
        self._best = int(np.argmax(self._fitness))
        return Leader(self._paths[self._best].copy(), float(self._fitness[self._best]),
                      float(self._fitness.mean()))
