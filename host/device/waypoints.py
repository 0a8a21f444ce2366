"""Waypoints as the chip packs them into integers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config


__all__ = ["pack_waypoints", "unpack_waypoints"]


def pack_waypoints(config: Config, cells: NDArray[np.integer]) -> list[int]:
    """Pack ``cells``, (n, 3) integers x, y, altitude step, in the chip's format."""
    bits = config.coordinate_bits
    columns = np.asarray(cells, dtype=np.int64).T
    packed: list[int] = (columns[0] | columns[1] << bits | columns[2] << 2 * bits).tolist()
    return packed


def unpack_waypoints(config: Config, path: Sequence[int]) -> NDArray[np.int64]:
    """Return the (n, 3) cells of a packed path, the inverse of :func:`pack_waypoints`."""
    bits = config.coordinate_bits
    packed = np.asarray(path, dtype=np.int64)
    mask = (1 << bits) - 1
    return np.stack((packed & mask, packed >> bits & mask, packed >> 2 * bits), axis=-1)
