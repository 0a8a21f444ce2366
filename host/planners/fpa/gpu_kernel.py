"""The kernel of the flower pollination algorithm on a GPU: iterations of independent runs.

One launch performs several iterations of all runs. The grid is cooperative: all blocks are resident
on the device at once, take work until none is left, and wait for each other before any block reads
the results of another. A block judges several candidates at a time, so that their turns, pieces and
samples occupy all of its threads.

Source: Roberge and Tarbouchi, section 4. They launch one child kernel for each path that 2-opt
tries; here, a block judges the next reversals of a path together and takes the first one that is
better, as sequential 2-opt would.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import cuda, float64, int32, int64

from pathgene.host.evaluation.constants import Course
from pathgene.host.evaluation.kernels import corners_m, cost_of, fitness_of
from pathgene.host.evaluation.laying import (
    LENGTH,
    PIECE_FIELDS,
    STEEP,
    TURN_FIELDS,
    lay_segment,
    lay_turn,
)
from pathgene.host.evaluation.pieces import (
    area_and_fuel,
    judge_slope,
    parts_of,
    piece_hits,
    prepare_burn,
    total_of,
)
from pathgene.host.planners.fpa.steps import choose_step, move, to_beat
from pathgene.host.planners.fpa.two_opt import CUT_SHORT, EVALUATED, is_two_opt, reversed_row


__all__ = [
    "BEST_FITNESS",
    "CUT_SHORT_SO_FAR",
    "EVALUATED_SO_FAR",
    "MEAN_FITNESS",
    "RECORD_FIELDS",
    "pollination_kernel",
    "widest",
]

# Fields of an iteration's record; the best path follows them.
BEST_FITNESS, MEAN_FITNESS, EVALUATED_SO_FAR, CUT_SHORT_SO_FAR = range(4)
RECORD_FIELDS = 4

# Threads that take the parts of a piece in turn.
_WARP = 32
# Fields of a piece's samples, and of a candidate's verdict.
_HITS, _PARTS = range(2)
_BOUND, _PENALTY, _COST, _ROOM, _IS_SAMPLED = range(5)
_VERDICT_FIELDS = 5
# Units per metre of the hits, which are summed while samples are still taken.
_UNITS = 8
# Maximum of a thread's share of a piece, and the maximum that matters: from there the threads of a
# block cannot reach an overflow.
_MOST_UNITS, _MOST_ROOM = float(1 << 21), float(1 << 30)

# Shared memory that a block may use, in bytes, minus some for alignment.
_SHARED_BYTES = 48 * 1024 - 128


def widest(points: int, most: int, threads: int) -> int:
    """Return how many candidates of ``points`` points a block can judge at once, up to ``most``.

    Raises
    ------
    ValueError
        If there is no room for a single candidate.
    """
    rows = 2 * points - 1
    floats = (3 + TURN_FIELDS) * points + PIECE_FIELDS * rows + _VERDICT_FIELDS + 1
    each = 8 * floats + 4 * (2 * rows + 1)
    room = (_SHARED_BYTES - 24 * points - 24 * threads) // each
    if room < 1:
        raise ValueError(f"A path of {points} points has no room in a block's memory")
    return min(room, most)


def pollination_kernel(points: int, width: int, threads: int) -> Callable[..., None]:
    """Return the kernel, not yet compiled, for paths of ``points`` points.

    It is launched cooperatively with any number of blocks of ``threads``. Parameters, for r runs of
    m solutions each:

    first, iterations, two_opt_every : int
        The first iteration, their number, and iterations from one 2-opt to the next, 0 for none.
    share : int
        Solutions that a block takes at a time, 1 to ``width``.
    parameters, constants : (r,) records
        Fields of :class:`~pathgene.host.planners.fpa.steps.Pollination` and of
        :class:`~pathgene.host.evaluation.constants.Constants`.
    boxes : (r, 2, 3) float64, metres
        The airspaces.
    ground, ground_at, zoned, zoned_at : (cells,) float64, (r,) int64
        Concatenated rasters, and the index at which the rasters of each run begin.
    pairs : (k, 2) int32
        First and last waypoints of all reversals, in the order of 2-opt.
    paths, fitness, side : (2, r, m, n, 3), (2, r, m) float64, int
        The population is at ``side`` before the first iteration, at ``1 - side`` after it.
    settled : (r, m) uint8
        1 if the solution has not changed since its last 2-opt.
    best : (r,) int64
        g* of each run.
    counts : (r, 2) int64
        Numbers of candidates evaluated to the end and abandoned early.
    records : (r, k, RECORD_FIELDS + 3 n) float64
        Best and mean fitness, counts and best path of each iteration.
    """
    if threads > _WARP and threads % _WARP != 0:
        raise ValueError(f"{threads} threads are no whole number of warps")
    rows = 2 * points - 1
    numbers = 3 * points
    # Shapes in a block's memory must be constants.
    path_shape, paths_shape = (points, 3), (width, points, 3)
    turns_shape, pieces_shape = (width, points, TURN_FIELDS), (width, rows, PIECE_FIELDS)
    hits_shape, verdicts_shape = (width, 2, rows), (width, _VERDICT_FIELDS)
    lanes = min(_WARP, threads)
    warps = threads // lanes

    @cuda.jit(device=True)
    def judge(
        count: Any,
        candidates: Any,
        incumbents: Any,
        ground: Any,
        zoned: Any,
        c: Any,
        turns: Any,
        pieces: Any,
        hits: Any,
        found: Any,
        verdicts: Any,
    ) -> None:
        """Write the fitness of each candidate or, if it does not beat its incumbent, a bound.

        As in :func:`pathgene.host.evaluation.kernels.fitness_above`, a candidate is not sampled if
        it cannot be better, and sampling stops once the hits already counted rule it out.
        """
        thread = cuda.threadIdx.x
        for item in range(thread, count * points, threads):
            one = item // points
            lay_turn(candidates[one], points, item - one * points, c, turns[one])
        cuda.syncthreads()
        for item in range(thread, count * (points - 1), threads):
            one = item // (points - 1)
            lay_segment(
                candidates[one], points, item - one * (points - 1), c, turns[one], pieces[one]
            )
        cuda.syncthreads()
        for item in range(thread, count * rows, threads):
            one = item // rows
            row = item - one * rows
            judge_slope(c, pieces[one], row)
            prepare_burn(c, pieces[one], row)
            hits[one, _HITS, row] = 0
            hits[one, _PARTS, row] = parts_of(c, pieces[one], row)
        cuda.syncthreads()
        for one in range(thread, count, threads):
            length = total_of(pieces[one], rows, LENGTH)
            area, fuel, beyond = area_and_fuel(c, pieces[one], rows)
            penalty = total_of(pieces[one], rows, STEEP)
            penalty += corners_m(c, turns[one], points, length) + beyond
            if not length > 0.0:
                penalty = math.nan
            cost = cost_of(c, area, fuel)
            bound = fitness_of(penalty, cost)
            incumbent = incumbents[one]
            verdicts[one, _PENALTY] = penalty
            verdicts[one, _COST] = cost
            verdicts[one, _BOUND] = bound
            verdicts[one, _IS_SAMPLED] = 1.0 if bound > incumbent else 0.0
            # Equation (3), solved for the metres of hits at which the candidate equals the
            # incumbent.
            room = 1.0 / incumbent - 1.0 - penalty if incumbent > 0.0 else math.inf
            room = _UNITS * max(room, 0.0) + 1.0
            verdicts[one, _ROOM] = room if room < _MOST_ROOM else math.inf
            found[one] = 0
        cuda.syncthreads()
        # The threads of a warp share the parts of a piece.
        course = Course(ground, zoned, c)
        lane = thread % lanes
        for item in range(thread // lanes, count * rows, warps):
            one = item // rows
            row = item - one * rows
            parts = hits[one, _PARTS, row]
            if (
                verdicts[one, _IS_SAMPLED] != 0.0
                and lane < parts
                and not found[one] > verdicts[one, _ROOM]
            ):
                hit = piece_hits(course, pieces[one], row, parts, lane, lanes)
                if hit > 0:
                    cuda.atomic.add(hits, (one, _HITS, row), hit)
                    units = hit * (_UNITS * pieces[one, row, LENGTH] / parts)
                    cuda.atomic.add(found, one, int32(min(units, _MOST_UNITS)))
        cuda.syncthreads()
        for one in range(thread, count, threads):
            if verdicts[one, _IS_SAMPLED] == 0.0:
                continue
            if found[one] > verdicts[one, _ROOM]:
                # Which pieces were sampled depends on the order of the threads; the outcome does
                # not.
                verdicts[one, _IS_SAMPLED] = 0.0
                verdicts[one, _BOUND] = incumbents[one]
                continue
            hit_m = 0.0
            for row in range(rows):
                if hits[one, _HITS, row] > 0:
                    hit_m += hits[one, _HITS, row] * (
                        pieces[one, row, LENGTH] / hits[one, _PARTS, row]
                    )
            verdicts[one, _BOUND] = fitness_of(
                hit_m + verdicts[one, _PENALTY], verdicts[one, _COST]
            )
        cuda.syncthreads()

    @cuda.jit(device=True)
    def find_best(fitness: Any, most: Any, where: Any, sums: Any) -> None:
        """Reduce to best fitness, its first index and sum, at index 0 of the three arrays."""
        thread = cuda.threadIdx.x
        best, place, total = -1.0, 0, 0.0
        for i in range(thread, fitness.shape[0], threads):
            total += fitness[i]
            if fitness[i] > best:
                best, place = fitness[i], i
        most[thread], where[thread], sums[thread] = best, place, total
        cuda.syncthreads()
        left = threads
        while left > 1:
            half = (left + 1) // 2
            if thread < left - half:
                other = thread + half
                sums[thread] += sums[other]
                if most[other] > most[thread] or (
                    most[other] == most[thread] and where[other] < where[thread]
                ):
                    most[thread], where[thread] = most[other], where[other]
            cuda.syncthreads()
            left = half

    def pollinate(
        first: Any,
        iterations: Any,
        two_opt_every: Any,
        share: Any,
        parameters: Any,
        constants: Any,
        boxes: Any,
        ground: Any,
        ground_at: Any,
        zoned: Any,
        zoned_at: Any,
        pairs: Any,
        paths: Any,
        fitness: Any,
        side: Any,
        settled: Any,
        best: Any,
        counts: Any,
        records: Any,
    ) -> None:
        path = cuda.shared.array(path_shape, float64)
        candidates = cuda.shared.array(paths_shape, float64)
        turns = cuda.shared.array(turns_shape, float64)
        pieces = cuda.shared.array(pieces_shape, float64)
        hits = cuda.shared.array(hits_shape, int32)
        found = cuda.shared.array(width, int32)
        verdicts = cuda.shared.array(verdicts_shape, float64)
        incumbents = cuda.shared.array(width, float64)
        most = cuda.shared.array(threads, float64)
        where = cuda.shared.array(threads, int64)
        sums = cuda.shared.array(threads, float64)
        grid = cuda.cg.this_grid()
        thread, block, blocks = cuda.threadIdx.x, cuda.blockIdx.x, cuda.gridDim.x
        runs, count = fitness.shape[1], fitness.shape[2]
        groups = (count + share - 1) // share

        for slot in range(iterations):
            iteration = first + slot
            old = (side + slot) % 2
            new = 1 - old
            for item in range(block, runs * groups, blocks):
                run = item // groups
                begin = (item - run * groups) * share
                taken = min(share, count - begin)
                p, c = parameters[run], constants[run]
                before, after = paths[old, run], paths[new, run]
                worth, leader, box = fitness[old, run], best[run], boxes[run]
                for one in range(thread, taken, threads):
                    incumbents[one] = to_beat(p, worth[begin + one])
                for d in range(thread, taken * numbers, threads):
                    one = d // numbers
                    place = d - one * numbers
                    row = place // 3
                    axis = place - 3 * row
                    i = begin + one
                    if 0 < row < points - 1:
                        step = choose_step(p, iteration, i, count)
                        candidates[one, row, axis] = move(
                            p, iteration, i, place - 3, step, before, leader, box
                        )
                    else:
                        candidates[one, row, axis] = before[i, row, axis]
                cuda.syncthreads()
                judge(
                    taken,
                    candidates,
                    incumbents,
                    ground[ground_at[run] :],
                    zoned[zoned_at[run] :],
                    c,
                    turns,
                    pieces,
                    hits,
                    found,
                    verdicts,
                )
                for d in range(thread, taken * numbers, threads):
                    one = d // numbers
                    place = d - one * numbers
                    row = place // 3
                    axis = place - 3 * row
                    i = begin + one
                    if verdicts[one, _BOUND] > worth[i]:
                        after[i, row, axis] = candidates[one, row, axis]
                    else:
                        after[i, row, axis] = before[i, row, axis]
                for one in range(thread, taken, threads):
                    i = begin + one
                    value = verdicts[one, _BOUND]
                    fitness[new, run, i] = max(value, worth[i])
                    if value > worth[i]:
                        settled[run, i] = 0
                    kind = EVALUATED if verdicts[one, _IS_SAMPLED] != 0.0 else CUT_SHORT
                    cuda.atomic.add(counts, (run, kind), 1)
                cuda.syncthreads()
            grid.sync()

            if is_two_opt(iteration, two_opt_every):
                for item in range(block, runs * count, blocks):
                    run = item // count
                    i = item - run * count
                    if settled[run, i]:
                        continue
                    p, c = parameters[run], constants[run]
                    value = fitness[new, run, i]
                    for d in range(thread, numbers, threads):
                        path[d // 3, d % 3] = paths[new, run, i, d // 3, d % 3]
                    cuda.syncthreads()
                    at = 0
                    while at < pairs.shape[0]:
                        taken = min(width, pairs.shape[0] - at)
                        for d in range(thread, taken * numbers, threads):
                            one = d // numbers
                            place = d - one * numbers
                            row, axis = place // 3, place % 3
                            source = reversed_row(row, pairs[at + one, 0], pairs[at + one, 1])
                            candidates[one, row, axis] = path[source, axis]
                        for one in range(thread, taken, threads):
                            incumbents[one] = to_beat(p, value)
                        cuda.syncthreads()
                        judge(
                            taken,
                            candidates,
                            incumbents,
                            ground[ground_at[run] :],
                            zoned[zoned_at[run] :],
                            c,
                            turns,
                            pieces,
                            hits,
                            found,
                            verdicts,
                        )
                        won = 0
                        while won < taken and not verdicts[won, _BOUND] > value:
                            won += 1
                        # Reversals after the first better one do not count as tried.
                        for one in range(thread, min(won + 1, taken), threads):
                            kind = EVALUATED if verdicts[one, _IS_SAMPLED] != 0.0 else CUT_SHORT
                            cuda.atomic.add(counts, (run, kind), 1)
                        at += taken
                        if won < taken:
                            value = verdicts[won, _BOUND]
                            at = 0
                            for d in range(thread, numbers, threads):
                                path[d // 3, d % 3] = candidates[won, d // 3, d % 3]
                        cuda.syncthreads()
                    for d in range(thread, numbers, threads):
                        paths[new, run, i, d // 3, d % 3] = path[d // 3, d % 3]
                    if thread == 0:
                        fitness[new, run, i] = value
                        settled[run, i] = 1
                    cuda.syncthreads()
                grid.sync()

            for run in range(block, runs, blocks):
                find_best(fitness[new, run], most, where, sums)
                for d in range(thread, numbers, threads):
                    records[run, slot, RECORD_FIELDS + d] = paths[new, run, where[0], d // 3, d % 3]
                if thread == 0:
                    records[run, slot, BEST_FITNESS] = most[0]
                    records[run, slot, MEAN_FITNESS] = sums[0] / count
                    records[run, slot, EVALUATED_SO_FAR] = counts[run, EVALUATED]
                    records[run, slot, CUT_SHORT_SO_FAR] = counts[run, CUT_SHORT]
                    best[run] = where[0]
                cuda.syncthreads()
            grid.sync()

    return pollinate
