"""Random ground and paths that are the same with every release of Python and NumPy.

All draws use :meth:`random.Random.random`, the only method that promises the same numbers for a
seed in every release.
"""

from __future__ import annotations

import json
import random
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config


__all__ = ["below", "checksum", "ground", "point", "population", "shuffled", "waypoint"]

Point = tuple[int, int, int]


def below(rng: random.Random, limit: int) -> int:
    """Draw an integer of 0..limit - 1."""
    return int(rng.random() * limit)


def shuffled(rng: random.Random, count: int) -> list[int]:
    """Draw a permutation of 0..count - 1."""
    return sorted(range(count), key=[rng.random() for _ in range(count)].__getitem__)


def ground(config: Config, seed: int, *, peaks: float, blocked: float) -> NDArray[np.int64]:
    """Draw a map ``[y, x]`` of altitude steps: low rough ground, peaks and blocked cells.

    ``peaks`` and ``blocked`` are the shares of peaks and blocked cells.
    """
    rng = random.Random(seed)
    top = config.blocked_altitude
    cells = []
    for _ in range(config.map_size**2):
        kind = rng.random()
        if kind < peaks:
            cells.append(top // 2 + below(rng, top // 2))
        elif kind < peaks + blocked:
            cells.append(top)
        else:
            cells.append(below(rng, top // 4 + 1))
    return np.array(cells).reshape(config.map_size, config.map_size)


def point(rng: random.Random, config: Config, near: Point | None = None) -> Point:
    """Draw a point of a path above most of the ground, within two cells of ``near`` if given."""
    edge, top = config.map_size - 1, config.blocked_altitude
    x, y = below(rng, edge + 1), below(rng, edge + 1)
    if near is not None:
        x, y = (min(max(at - 2 + below(rng, 5), 0), edge) for at in near[:2])
    return x, y, top // 4 + below(rng, top - top // 4)


def waypoint(config: Config, at: Point) -> int:
    """Pack a point as the chip stores it."""
    bits = config.coordinate_bits
    return at[0] | at[1] << bits | at[2] << 2 * bits


def population(rng: random.Random, config: Config) -> list[list[int]]:
    """Draw a path of packed waypoints for every slot, of all lengths."""
    least, most = config.MIN_WAYPOINTS, config.max_waypoints
    return [
        [waypoint(config, point(rng, config)) for _ in range(least + below(rng, most - least + 1))]
        for _ in range(config.population)
    ]


def checksum(value: Any) -> int:
    """Return the CRC-32 of plain JSON data."""
    return zlib.crc32(json.dumps(value).encode())
