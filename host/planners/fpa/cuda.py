"""The flower pollination algorithm on an NVIDIA GPU: one run, or many at once.

Rounding differs from a CPU's: the compiler contracts products and sums, and the sine differs. A
fitness agrees to about 1e-9, except for samples on the border between two cells; a decision between
two closer values may differ.

Source: Roberge and Tarbouchi, section 4.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import config, cuda
from numba.cuda.cudadrv.driver import CudaAPIError
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.host.evaluation.constants import Floats
from pathgene.host.planners.fpa.engines import Leader, Setup, never
from pathgene.host.planners.fpa.gpu_kernel import (
    BEST_FITNESS,
    CUT_SHORT_SO_FAR,
    EVALUATED_SO_FAR,
    MEAN_FITNESS,
    RECORD_FIELDS,
    pollination_kernel,
    widest,
)


__all__ = ["GpuEngine", "is_available", "joined", "reported", "table"]


def table(rows: Sequence[NamedTuple]) -> NDArray[Any]:
    """Return named tuples of one class as records, (r,)."""
    kinds = {float: np.float64, int: np.int64}
    fields = [(name, kinds.get(kind, kind)) for name, kind in type(rows[0]).__annotations__.items()]
    return np.array([tuple(row) for row in rows], dtype=np.dtype(fields, align=True))


def joined(rasters: Sequence[Floats]) -> tuple[Floats, NDArray[np.int64]]:
    """Return distinct flat rasters concatenated, and the index of each raster, (r,)."""
    places: dict[int | bytes, int] = {}  # Compared by identity, then by digest.
    kept = []
    begins = []
    end = 0
    for raster in rasters:
        if id(raster) not in places:
            digest = hashlib.blake2b(raster.tobytes()).digest()
            if digest not in places:
                places[digest] = end
                kept.append(raster)
                end += raster.size
            places[id(raster)] = places[digest]
        begins.append(places[id(raster)])
    return np.concatenate(kept), np.array(begins, dtype=np.int64)


Paths = NDArray[np.float64]

#: Threads of a block, and the maximum number of candidates that it judges at once: all reversals of
#: 6 waypoints.
THREADS, WIDTH = 128, 15
# Registers of a thread: the fastest of 64, 96 and 128. With the 177 that the compiler would choose,
# a multiprocessor of an H200 holds two blocks; with 128 it holds four, and its shared memory has
# room for them.
_REGISTERS = 96


def is_available() -> bool:
    """Return whether there is a GPU with a working driver."""
    return bool(cuda.is_available())


@cache
def _compiled_kernel(points: int, width: int, threads: int) -> Any:
    kernel = pollination_kernel(points, width, threads)
    # Numba's simulator has no registers.
    return cuda.jit(kernel) if config.ENABLE_CUDASIM else cuda.jit(kernel, max_registers=_REGISTERS)


@contextlib.contextmanager
def reported() -> Iterator[None]:
    """Raise errors of the driver as JobError."""
    try:
        yield
    except CudaAPIError as error:
        raise JobError(
            f"The GPU failed ({error}); if it has too little memory, plan fewer problems at "
            "once, or a smaller population."
        ) from None


class GpuEngine:
    """Runs on one NVIDIA GPU; see :class:`pathgene.host.planners.fpa.engines.Engine`.

    Parameters
    ----------
    setups : sequence of Setup
        Runs with the same numbers of solutions, points and iterations.
    two_opt_every : int
        Iterations from one 2-opt to the next; 0 for none.
    stride : int
        Maximum number of iterations between two transfers to the host.
    threads, width : int
        Threads of a block, and maximum number of candidates that it judges at once.
    blocks : int, optional
        Maximum number of blocks; by default as many as the device holds at once.

    Raises
    ------
    JobError
        From the constructor and each method, if the GPU fails or has too little memory.
    """

    @reported()
    def __init__(
        self,
        setups: Sequence[Setup],
        two_opt_every: int,
        *,
        stride: int,
        threads: int = THREADS,
        width: int = WIDTH,
        blocks: int | None = None,
    ) -> None:
        paths = np.stack([setup.paths for setup in setups])
        fitness = np.stack([setup.fitness for setup in setups])
        runs, count, points, _ = paths.shape
        courses = [setup.evaluator.course for setup in setups]
        width = widest(points, width, threads)
        # A single waypoint cannot be reversed.
        self._two_opt_every = two_opt_every if points > 3 else 0
        self._side = 0
        send = cuda.to_device
        self._problems = (
            send(table([setup.parameters for setup in setups])),
            send(table([course.c for course in courses])),
            send(np.stack([setup.box for setup in setups])),
            *map(send, joined([course.ground for course in courses])),
            *map(send, joined([course.zoned for course in courses])),
            send(np.array([*itertools.combinations(range(1, points - 1), 2)] or [(0, 0)], "i4")),
        )
        self._paths = send(np.stack((paths, paths)))
        self._fitness = send(np.stack((fitness, fitness)))
        self._settled = send(np.zeros((runs, count), dtype=np.uint8))
        self._best = send(fitness.argmax(axis=1))
        self._counts = send(np.zeros((runs, 2), dtype=np.int64))
        self._records = send(np.zeros((runs, stride, RECORD_FIELDS + 3 * points)))
        kernel = _compiled_kernel(points, width, threads).specialize(*self._arguments(1, 0, 1))
        if blocks is None:
            (compiled,) = kernel.overloads.values()
            blocks = int(compiled.max_cooperative_grid_blocks(threads))
        blocks = min(runs * count, blocks)
        self._share = max(1, min(width, runs * count // blocks))
        with warnings.catch_warnings():
            # Numba warns about a small population, which leaves most of the GPU idle; the user
            # knows that.
            warnings.filterwarnings("ignore", message=".*Grid size")
            self._kernel = kernel[blocks, threads]

    def _arguments(self, first: int, iterations: int, share: int) -> tuple[Any, ...]:
        return (
            first,
            iterations,
            self._two_opt_every,
            share,
            *self._problems,
            self._paths,
            self._fitness,
            self._side,
            self._settled,
            self._best,
            self._counts,
            self._records,
        )

    @reported()
    def advance(
        self, first: int, count: int, should_stop: Callable[[], bool] = never
    ) -> Sequence[Sequence[Leader]]:
        """See :class:`pathgene.host.planners.fpa.engines.Engine`; ``count`` is at most the stride.

        Launched iterations run to their end, whatever ``should_stop`` returns.
        """
        self._kernel(*self._arguments(first, count, self._share))
        self._side = (self._side + count) % 2
        records = self._records.copy_to_host()[:, :count]
        return [
            [
                Leader(
                    path,
                    numbers[BEST_FITNESS],
                    numbers[MEAN_FITNESS],
                    int(numbers[EVALUATED_SO_FAR]),
                    int(numbers[CUT_SHORT_SO_FAR]),
                )
                for numbers, path in zip(
                    record[:, :RECORD_FIELDS].tolist(),
                    record[:, RECORD_FIELDS:].reshape(count, -1, 3),
                    strict=True,
                )
            ]
            for record in records
        ]

    @reported()
    def populations(self) -> tuple[Paths, NDArray[np.float64]]:
        """See :class:`pathgene.host.planners.fpa.engines.Engine`."""
        return self._paths[self._side].copy_to_host(), self._fitness[self._side].copy_to_host()

    def close(self) -> None:
        """See :class:`pathgene.host.planners.fpa.engines.Engine`."""
