"""Cycles and reads of the two-tier build, path by path, without a simulation of each cycle."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.queue_depths import count_depth
from pathgene.sim.model.checker import Point, TerrainModel, check_path, segment_cells, to_coarse


__all__ = ["two_tier_cycles"]


def two_tier_cycles(
    config: Config, terrain: TerrainModel, paths: Iterable[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return the cycles and the reads in the verdict of every path of a queue.

    The source always has the next point and verdicts are taken at once; the chip is idle before
    the first path. A queue of one path is a path by itself.

    The model follows each segment through the stages of the walker, by the cycles in which it
    enters and leaves them. The walk stops in the cycle in which a hit leaves the comparison.

    Parameters
    ----------
    config : Config
        Sizes of the two-tier build.
    terrain : TerrainModel
    paths : iterable of sequences of (int, int, int)
    count : bool
        Count mode.
    """
    answer = config.memory_latency + 3  # Cycles from a visit to its step.
    places = count_depth(config)
    freed: list[int] = []  # First cycle in which the place of each counted segment is free again.
    results = []
    taken = 0  # Clock in which the latest point was taken.
    measured = 0  # In which the latest segment left the first stage of the set-up,
    passed = 0  # the second stage,
    ended = 0  # and the walker.
    verdict = 0  # In which the latest verdict was offered.
    for path in paths:
        outcome = check_path(config, terrain, path, count)
        counted = {segment for segment, _, _ in outcome.entries}
        began = taken = taken + 1
        hit: int | None = None  # Clock of the step that ends the walk.
        reads = 0
        for number, (start, stop) in enumerate(itertools.pairwise(path)):
            taken = max(taken + 1, measured)
            measured = max(taken + 1, passed)
            if number >= config.DETAILED_SEGMENTS:
                start, stop = to_coarse(config, start), to_coarse(config, stop)
            cells = segment_cells(start, stop)
            free = max(measured + 1, ended)
            if count and len(freed) >= places:
                free = max(free, freed[-places])
            if hit is not None and free >= hit:
                passed = max(measured, passed, hit) + 1
                continue
            passed, ended = free, free + cells
            if outcome.collision and not count and outcome.segment == number:
                hit = passed + (outcome.cells - reads) + answer
            if hit is not None and ended >= hit:
                cells -= ended - hit
                ended = hit + 1  # Nothing is taken in the cycle of the step.
            reads += cells
            if count:
                freed.append(ended + answer + (2 if number in counted else 1))
        offered = (ended + answer if hit is None else hit) + 1
        results.append((offered - max(began, verdict + 1) + 1, reads))
        verdict = offered
    return results
