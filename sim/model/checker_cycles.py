"""Cycles and reads of the collision checker, as its own counters give them."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.model.checker import Point, TerrainModel
from pathgene.sim.model.checker_cycles_parallel import parallel_cycles
from pathgene.sim.model.checker_cycles_two_tier import two_tier_cycles


__all__ = ["batch_cycles"]


def batch_cycles(
    config: Config, terrain: TerrainModel, paths: Sequence[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return ``cycles`` and ``reads`` of each path's verdict, exactly.

    The paths are queued: the checker is offered a point in every cycle, and its verdicts and counts
    are taken at once. A batch of one is a single path.

    ``cycles`` begin with the one in which the path's first point is taken or, if that is later,
    with the one after the previous verdict was offered; they end with the one in which the path's
    own verdict is offered. ``reads`` are the addresses given to the memories for the path.

    Raises
    ------
    ValueError
        See :func:`pathgene.sim.model.checker.check_path`.
    """
    cycles = two_tier_cycles if config.checker is CheckerBuild.TWO_TIER else parallel_cycles
    return cycles(config, terrain, paths, count)
