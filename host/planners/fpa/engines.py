"""Engines of the flower pollination algorithm: its iterations on one core or on all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.kernels import scratch
from pathgene.host.planners.fpa.kernels import (
    HISTORY_FIELDS,
    LINE,
    Populations,
    Record,
    Search,
    WorkSpace,
    pollinate_share,
    shared_state,
)
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.planners.fpa.two_opt import Counts


__all__ = ["CpuEngine", "Engine", "Leader", "Setup", "never"]

Paths = NDArray[np.float64]

# Solutions that a thread takes at a time, few enough that no thread waits long for another's 2-opt.
_CHUNK = 4
# Seconds between two checks of whether to stop.
_LOOK_S = 0.05


class Leader(NamedTuple):
    """The state after one iteration.

    ``path`` is the best solution, (n, 3) in metres, ``fitness`` its fitness, and ``mean`` the mean
    fitness. By then, ``evaluated`` candidates were evaluated to the end and ``cut_short`` were
    abandoned earlier; an engine may report the counts as of the end of the call.
    """

    path: Paths
    fitness: float
    mean: float
    evaluated: int
    cut_short: int


def never() -> bool:
    """Return False: nothing stops the engine."""
    return False


class Setup(NamedTuple):
    """The first population of a run, and the inputs of its search.

    Parameters
    ----------
    paths, fitness : (m, n, 3), (m,) float64
        The first population, including the ends, and its fitness.
    """

    evaluator: Evaluator
    parameters: Pollination
    box: Paths
    paths: Paths
    fitness: NDArray[np.float64]


class Engine(Protocol):
    """Takes the populations of its runs through iterations."""

    def advance(
        self, first: int, count: int, should_stop: Callable[[], bool] = never
    ) -> Sequence[Sequence[Leader]]:
        """Run iterations ``first``, from 1, to ``first + count - 1``.

        Return the result of each iteration, for each run. There are fewer once ``should_stop``,
        which is called occasionally, returns True; after that, only :meth:`populations` and
        :meth:`close` may be called.
        """

    def populations(self) -> tuple[Paths, NDArray[np.float64]]:
        """The current paths (r, m, n, 3) of r runs in metres, and their fitness (r, m)."""

    def close(self) -> None:
        """Release threads and memory."""


class CpuEngine:
    """One run on CPU threads; the result does not depend on their number.

    In an iteration each thread takes a few solutions at a time until none is left. A thread that
    finishes early releases its core until the next iteration. The caller waits for the threads and
    can stop them within about the time of one 2-opt.

    Parameters
    ----------
    setup : Setup
        The first population and the inputs of the search.
    two_opt_every : int
        Iterations from one 2-opt to the next; 0 for none.
    threads : int
        1 or more.
    """

    def __init__(self, setup: Setup, two_opt_every: int, threads: int) -> None:
        evaluator, parameters, box, paths, fitness = setup
        solutions, points, _ = paths.shape
        self._search = Search(parameters, two_opt_every, _CHUNK, box, evaluator.course)
        self._populations = Populations(
            np.stack((paths, paths)),
            np.stack((fitness, fitness)),
            np.zeros(solutions, dtype=np.uint8),
        )
        self._side = 0
        self._shared = shared_state(int(np.argmax(fitness)))
        self._spaces = [WorkSpace(np.empty((points, 3)), scratch(points)) for _ in range(threads)]
        self._counts: Counts = np.zeros((threads, LINE), dtype=np.int64)
        self._pool = ThreadPoolExecutor(threads, "pollinate")
        # Compiles the kernels.
        self._share(0, 1, 0, Record(np.empty((0, HISTORY_FIELDS)), np.empty((0, points, 3))))

    def advance(
        self, first: int, count: int, should_stop: Callable[[], bool] = never
    ) -> Sequence[Sequence[Leader]]:
        """See :class:`Engine`."""
        history = np.empty((count, HISTORY_FIELDS))
        leaders = np.empty((count, *self._populations.paths.shape[2:]))
        before = int(self._shared.meetings[0])
        try:
            shares = [
                self._pool.submit(self._share, thread, first, count, Record(history, leaders))
                for thread in range(len(self._counts))
            ]
            while wait(shares, _LOOK_S, FIRST_EXCEPTION).not_done:
                if should_stop() or any(share.done() and share.exception() for share in shares):
                    self._shared.ended[0] = 1
            for share in shares:
                share.result()
        except BaseException:
            # No thread waits for another thread that will not arrive.
            self._shared.ended[0] = 1
            raise
        done = int(self._shared.meetings[0]) - before
        self._side = (self._side + done) % 2
        return [
            [
                Leader(path, best, mean, int(evaluated), int(cut_short))
                for path, (best, mean, evaluated, cut_short) in zip(
                    leaders[:done], history[:done].tolist(), strict=True
                )
            ]
        ]

    def _share(self, thread: int, first: int, count: int, record: Record) -> None:
        pollinate_share(
            self._search,
            self._shared,
            self._populations,
            self._side,
            first,
            count,
            thread,
            self._spaces[thread],
            self._counts,
            record,
        )

    def populations(self) -> tuple[Paths, NDArray[np.float64]]:
        """See :class:`Engine`."""
        paths, fitness, _ = self._populations
        return paths[self._side][None].copy(), fitness[self._side][None].copy()

    def close(self) -> None:
        """See :class:`Engine`."""
        self._pool.shutdown()
