"""The flower pollination algorithm on a GPU: the iterations of :mod:`host.planners.fpa.kernels`.

A thread block has one solution. Its threads share the waypoints, the pieces between them and their
samples. A launch is one iteration, 2-opt included; the block that ends last finds g*. Launches
follow each other in the stream, and the host only fetches the history.

Rounding differs from a CPU's: the compiler contracts products and sums, the sine differs, and a
thread computes the place of its sample directly, where a CPU steps from one to the next. A fitness
agrees to about 1e-9, except for samples on the border between two cells; a decision between two
closer values may differ.

Source: Roberge and Tarbouchi, section 4. They launch one child kernel for each path that 2-opt
tries; here the block that runs the operator evaluates these paths.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numba import cuda, float64, int32, int64
from numpy.typing import NDArray

from host.evaluation import Evaluator
from host.evaluation.kernels import corners_m, cost_of, fitness_of
from host.evaluation.laying import LENGTH, PIECE_FIELDS, STEEP, TURN_FIELDS, lay_segment, lay_turn
from host.evaluation.pieces import (
    area_and_fuel,
    judge_slope,
    parts_of,
    piece_part,
    prepare_burn,
    total_of,
)
from host.planners.fpa.engines import Leader, never
from host.planners.fpa.steps import Pollination, choose_step, move, to_beat
from host.planners.fpa.two_opt import CUT_SHORT, EVALUATED, is_two_opt, reversed_row


__all__ = ["GpuEngine", "is_available", "iteration_kernel"]

Paths = NDArray[np.float64]

#: Threads of a block: a few samples of a path for each.
THREADS = 128

# Places of the state that blocks share, of a block's verdict, and of a line of the history.
_ARRIVED, _BEST = 0, 1
_VALUE, _STEEP_M, _CORNERS_M, _COST, _IS_LAST = range(5)
_BEST_FITNESS, _MEAN_FITNESS = 0, 1


def is_available() -> bool:
    """Return whether there is a GPU with a driver that works."""
    return bool(cuda.is_available())


@cache
def iteration_kernel(points: int, threads: int = THREADS) -> Callable[..., None]:
    """Return the kernel of an iteration, not compiled, for paths of ``points`` in all.

    It is launched with one block of ``threads`` for each solution. Its parameters are those of
    :func:`host.planners.fpa.kernels.improve_share`, without ``cursor`` and ``chunk``, ``counts``
    (m, 2) with a row for each block, and

    state : (2,) int64
        Blocks that are done, 0 between launches, and g*, which it changes.
    slot : int
        Row of the iteration's results in:
    history, leaders : (k, 2), (k, n, 3) float64
        Best and mean fitness; path of the best.
    """
    rows = 2 * points - 1
    numbers = 3 * points
    # Shapes in a block's memory must be constants.
    path_shape, turns_shape = (points, 3), (points, TURN_FIELDS)
    pieces_shape, hits_shape = (rows + 1, PIECE_FIELDS), (3, rows)

    @cuda.jit(device=True)
    def block_fitness(
        path: Any,
        incumbent: Any,
        ground: Any,
        zoned: Any,
        c: Any,
        turns: Any,
        pieces: Any,
        hits: Any,
        verdict: Any,
    ) -> Any:
        """Compute ``fitness_above`` with all threads of a block; all get the same result."""
        thread = cuda.threadIdx.x
        for i in range(thread, points, threads):
            lay_turn(path, points, i, c, turns)
        for row in range(thread, rows, threads):
            hits[0, row] = 0
            hits[1, row] = 0
        cuda.syncthreads()
        for i in range(thread, points - 1, threads):
            lay_segment(path, points, i, c, turns, pieces)
        cuda.syncthreads()
        for row in range(thread, rows, threads):
            judge_slope(c, pieces, row)
            prepare_burn(c, pieces, row)
            hits[2, row] = parts_of(c, pieces, row)
        cuda.syncthreads()
        if thread == 0:
            length = total_of(pieces, rows, LENGTH)
            area, fuel, beyond = area_and_fuel(c, pieces, rows)
            verdict[_STEEP_M] = total_of(pieces, rows, STEEP)
            verdict[_CORNERS_M] = corners_m(c, turns, points, length) + beyond
            verdict[_COST] = cost_of(c, area, fuel)
            verdict[_VALUE] = fitness_of(
                verdict[_STEEP_M] + verdict[_CORNERS_M] if length > 0.0 else -1.0, verdict[_COST]
            )
        cuda.syncthreads()
        if not verdict[_VALUE] > incumbent:
            return verdict[_VALUE], False
        # Thread t takes samples t, t + threads and so on of all pieces in a row.
        mine = thread
        before = 0
        row = 0
        while row < rows:
            parts = hits[2, row]
            if mine < before + parts:
                under, zone = piece_part(ground, zoned, c, pieces, row, mine - before, parts)
                if under:
                    cuda.atomic.add(hits, (0, row), 1)
                if zone:
                    cuda.atomic.add(hits, (1, row), 1)
                mine += threads
            else:
                before += parts
                row += 1
        cuda.syncthreads()
        if thread == 0:
            under_m = 0.0
            nofly_m = 0.0
            for row in range(rows):
                if hits[2, row] > 0:
                    part_m = pieces[row, LENGTH] / hits[2, row]
                    under_m += hits[0, row] * part_m
                    nofly_m += hits[1, row] * part_m
            verdict[_VALUE] = fitness_of(
                under_m + nofly_m + verdict[_STEEP_M] + verdict[_CORNERS_M], verdict[_COST]
            )
        cuda.syncthreads()
        return verdict[_VALUE], True

    @cuda.jit(device=True)
    def find_best(fitness: Any, most: Any, where: Any, sums: Any) -> None:
        """Reduce three arrays to the best fitness, its first place and the sum, in their row 0."""
        thread = cuda.threadIdx.x
        best, place, total = -1.0, 0, 0.0
        for i in range(thread, fitness.shape[0], threads):
            total += fitness[i]
            if fitness[i] > best:
                best, place = fitness[i], i
        most[thread], where[thread], sums[thread] = best, place, total
        cuda.syncthreads()
        if thread == 0:
            for other in range(1, threads):
                sums[0] += sums[other]
                if most[other] > most[0] or (most[other] == most[0] and where[other] < where[0]):
                    most[0], where[0] = most[other], where[other]
        cuda.syncthreads()

    def iterate(
        p: Any,
        iteration: Any,
        two_opt: Any,
        old: Any,
        old_fitness: Any,
        new: Any,
        new_fitness: Any,
        settled: Any,
        box: Any,
        ground: Any,
        zoned: Any,
        c: Any,
        counts: Any,
        state: Any,
        slot: Any,
        history: Any,
        leaders: Any,
    ) -> None:
        path = cuda.shared.array(path_shape, float64)
        candidate = cuda.shared.array(path_shape, float64)
        turns = cuda.shared.array(turns_shape, float64)
        pieces = cuda.shared.array(pieces_shape, float64)
        hits = cuda.shared.array(hits_shape, int32)
        verdict = cuda.shared.array(5, float64)
        most = cuda.shared.array(threads, float64)
        where = cuda.shared.array(threads, int64)
        sums = cuda.shared.array(threads, float64)
        thread = cuda.threadIdx.x
        i = cuda.blockIdx.x
        fitness = old_fitness[i]
        is_settled = settled[i]

        for d in range(thread, numbers, threads):
            path[d // 3, d % 3] = old[i, d // 3, d % 3]
            candidate[d // 3, d % 3] = old[i, d // 3, d % 3]
        cuda.syncthreads()
        step = choose_step(p, iteration, i, old.shape[0])
        for d in range(thread, numbers - 6, threads):
            candidate[1 + d // 3, d % 3] = move(p, iteration, i, d, step, old, state[_BEST], box)
        cuda.syncthreads()
        value, exact = block_fitness(
            candidate, to_beat(p, fitness), ground, zoned, c, turns, pieces, hits, verdict
        )
        if thread == 0:
            counts[i, EVALUATED if exact else CUT_SHORT] += 1
        if value > fitness:
            for d in range(thread, numbers, threads):
                path[d // 3, d % 3] = candidate[d // 3, d % 3]
            fitness = value
            is_settled = 0
        cuda.syncthreads()

        if two_opt and not is_settled:
            first = 1
            while first < points - 2:
                improved = False
                last = first + 1
                while last < points - 1 and not improved:
                    for d in range(thread, numbers, threads):
                        candidate[d // 3, d % 3] = path[reversed_row(d // 3, first, last), d % 3]
                    cuda.syncthreads()
                    value, exact = block_fitness(
                        candidate,
                        to_beat(p, fitness),
                        ground,
                        zoned,
                        c,
                        turns,
                        pieces,
                        hits,
                        verdict,
                    )
                    if thread == 0:
                        counts[i, EVALUATED if exact else CUT_SHORT] += 1
                    improved = value > fitness
                    last += 1
                if improved:
                    for d in range(thread, numbers, threads):
                        path[d // 3, d % 3] = candidate[d // 3, d % 3]
                    fitness = value
                first = 1 if improved else first + 1
                cuda.syncthreads()
            is_settled = 1

        for d in range(thread, numbers, threads):
            new[i, d // 3, d % 3] = path[d // 3, d % 3]
        if thread == 0:
            new_fitness[i] = fitness
            settled[i] = is_settled
        # The writes of a block are visible to all before the block counts as done.
        cuda.threadfence()
        cuda.syncthreads()
        if thread == 0:
            done = cuda.atomic.add(state, _ARRIVED, 1) + 1
            verdict[_IS_LAST] = 1.0 if done == new_fitness.shape[0] else 0.0
        cuda.syncthreads()
        if verdict[_IS_LAST] == 0.0:
            return
        # No block has read the new population before, so no cache holds an old one.
        cuda.threadfence()
        find_best(new_fitness, most, where, sums)
        for d in range(thread, numbers, threads):
            leaders[slot, d // 3, d % 3] = new[where[0], d // 3, d % 3]
        if thread == 0:
            history[slot, _BEST_FITNESS] = most[0]
            history[slot, _MEAN_FITNESS] = sums[0] / new_fitness.shape[0]
            state[_BEST] = where[0]
            state[_ARRIVED] = 0

    return iterate


@cache
def _compiled_kernel(points: int, threads: int) -> Any:
    return cuda.jit(iteration_kernel(points, threads))


class GpuEngine:
    """One NVIDIA GPU; see :class:`host.planners.fpa.engines.Engine`.

    Parameters
    ----------
    evaluator, parameters, two_opt_every, box, paths, fitness
        As for :class:`host.planners.fpa.engines.CpuEngine`.
    stride : int
        Iterations between two transfers to the host.
    threads : int
        Threads of a block.

    """

    def __init__(
        self,
        evaluator: Evaluator,
        parameters: Pollination,
        two_opt_every: int,
        box: Paths,
        paths: Paths,
        fitness: NDArray[np.float64],
        *,
        stride: int,
        threads: int = THREADS,
    ) -> None:
        self._parameters = parameters
        self._two_opt_every = two_opt_every
        count, points, _ = paths.shape
        self._kernel = _compiled_kernel(points, threads)[count, threads]
        ground, zoned, self._constants = evaluator.kernel_arguments
        to_device = cuda.to_device
        self._old = to_device(paths), to_device(fitness)
        self._new = to_device(paths), to_device(fitness)
        self._problem = to_device(box), to_device(ground), to_device(zoned)
        self._settled = to_device(np.zeros(count, dtype=np.uint8))
        self._counts = to_device(np.zeros((count, 2), dtype=np.int64))
        self._state = to_device(np.array([0, int(np.argmax(fitness))]))
        self._history = to_device(np.zeros((stride, 2)))
        self._leaders = to_device(np.zeros((stride, points, 3)))

    def advance(
        self,
        first: int,
        count: int,
        should_stop: Callable[[], bool] = never,
    ) -> Sequence[Leader]:
        """See :class:`host.planners.fpa.engines.Engine`; ``count`` is at most the stride.

        Launched iterations run to their end, whatever ``should_stop`` returns.
        """
        for slot in range(count):
            iteration = first + slot
            self._kernel(
                self._parameters,
                iteration,
                is_two_opt(iteration, self._two_opt_every),
                *self._old,
                *self._new,
                self._settled,
                *self._problem,
                self._constants,
                self._counts,
                self._state,
                slot,
                self._history,
                self._leaders,
            )
            self._old, self._new = self._new, self._old
        history, leaders = self._history.copy_to_host(), self._leaders.copy_to_host()
        evaluated, cut_short = self._counts.copy_to_host().sum(axis=0).tolist()
        return [
            Leader(path, float(best), float(mean), evaluated, cut_short)
            for path, (best, mean) in zip(leaders[:count], history, strict=False)
        ]

    def population(self) -> tuple[Paths, NDArray[np.float64]]:
        """See :class:`host.planners.fpa.engines.Engine`."""
        return self._old[0].copy_to_host(), self._old[1].copy_to_host()

    def close(self) -> None:
        """See :class:`host.planners.fpa.engines.Engine`."""
