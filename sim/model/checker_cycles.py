"""Cycles and reads of the collision checker, as its own counters give them."""

from __future__ import annotations

from collections.abc import Sequence

from hdl.config import CheckerBuild, Config
from sim.model.checker import Point, TerrainModel
from sim.model.checker_cycles_parallel import parallel_cycles
from sim.model.checker_cycles_two_tier import two_tier_cycles


__all__ = ["batch_cycles"]


def batch_cycles(
    config: Config, terrain: TerrainModel, paths: Sequence[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return ``cycles`` and ``reads`` of each path's verdict, exactly.

    The paths are queued: the checker is offered a point in every cycle, and its verdicts and counts
    are taken at once. A batch of one is a path alone.

    ``cycles`` begin with the cycle in which the path's first point is taken or, if that is later,
    with the cycle after that in which the previous verdict was offered; they end with the cycle in
    which the path's own is. ``reads`` are the addresses that the memories were given for it.

    Raises
    ------
    ValueError
        As :func:`sim.model.checker.check_path` does.
    """
    cycles = two_tier_cycles if config.checker is CheckerBuild.TWO_TIER else parallel_cycles
    return cycles(config, terrain, paths, count)
