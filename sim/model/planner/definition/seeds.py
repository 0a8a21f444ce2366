"""First paths of an island: points along its route."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ProblemRecord, seed_waypoints
from pathgene.sim.model.planner.definition.breeder import Waypoint, bits, draw
from pathgene.sim.model.planner.definition.walk import Corner
from pathgene.sim.model.planner.definition.wavefront import Block, Blocks, Surface
from pathgene.sim.model.random_source import RandomSource


__all__ = ["lifted", "seed_path"]


def seed_path(
    config: Config,
    record: ProblemRecord,
    blocks: Blocks,
    surface: Surface,
    route: Sequence[Block],
    source: RandomSource,
) -> list[Waypoint]:
    """Return a path of waypoints at even distances along ``route``.

    Their number and the place of the first are random. Each lies on the lowest corner of its block,
    a random height above the surface: uniform within the box of mutations, shifted right by 0 to 7
    for the whole path. Takes a step of the source, and one for each waypoint of the longest seed.
    """
    fewest, most = seed_waypoints(config.max_waypoints)
    word, _ = source.step()
    count = fewest + draw(word, 0, 8, most - fewest + 1)
    phase, shift = bits(word, 8, 8), bits(word, 16, 3)
    path = []
    for i in range(most):
        word, _ = source.step()
        if i >= count:
            continue
        block = route[((i << 8) + phase) * len(route) // (count << 8)]
        x, y = blocks.lowest[block]
        z = surface.get(block, 0) + (draw(word, 0, 16, config.box_steps) >> shift)
        path.append(_within(record, (x, y), z))
    return path


def lifted(record: ProblemRecord, path: Sequence[Waypoint]) -> list[Waypoint]:
    """Return ``path`` with each waypoint raised by its margin, where that is negative."""
    return [_within(record, (x, y), z - min(margin, 0)) for x, y, z, margin in path]


def _within(record: ProblemRecord, corner: Corner, z: int) -> Waypoint:
    x, y = corner
    return Waypoint(
        min(x, record.x_limit), min(y, record.y_limit), min(max(z, 0), record.altitude_limit)
    )
