"""Files of ``pathgene feasible``: maps and paths in cells and altitude steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.host.device.chip_map import padded_map
from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.formats.csv import read_csv
from pathgene.host.inputs import opened
from pathgene.host.terrain.untrusted import UNREADABLE, read_array


__all__ = ["read_map", "read_points"]


def read_map(file: Path, config: Config) -> NDArray[np.uint16]:
    """Return the heights of a ``.npy`` file on the whole map of a chip.

    See :func:`pathgene.host.device.chip_map.padded_map`.

    Raises
    ------
    InputError
        If the file cannot be read, or is not a filled array ``[y, x]`` of integer altitudes that
        fits the map.
    """
    try:
        with reading("map", file), opened(file) as binary:
            heights = read_array(file, binary, None, "cut it to the part that the path is in")
    except UNREADABLE:
        raise InputError(
            f"{file}: cannot be read as a numpy array; write it with numpy.save."
        ) from None
    if heights.ndim != 2 or heights.size == 0 or not np.issubdtype(heights.dtype, np.integer):
        raise InputError(
            f"{file}: a map must be a filled array [y, x] of integers, not of shape "
            f"{heights.shape} of {heights.dtype}."
        )
    edge, top = config.map_size, config.blocked_altitude
    if max(heights.shape) > edge:
        raise InputError(
            f"{file}: the map has {heights.shape[1]} x {heights.shape[0]} cells, but the board's "
            f"has {edge} x {edge}; cut it, or give a simulated board a larger map_size."
        )
    if heights.min() < 0 or heights.max() > top:
        raise InputError(
            f"{file}: altitudes must be from 0 to {top}, not {heights.min()} to {heights.max()}."
        )
    return padded_map(heights, config)


def read_points(file: Path, config: Config) -> NDArray[np.int64]:
    """Return the points of a path, (n, 3) int64 cells and altitude steps, the aircraft first.

    Raises
    ------
    InputError
        If the file is not a CSV with the header ``x,y,z``, a number in it is not whole, a point is
        outside the map of ``config``, or the path has more waypoints than the chip holds.
    """
    points = read_csv(file)
    most = config.max_waypoints
    if len(points) - 2 > most:
        raise InputError(
            f"{file}: the path has {len(points) - 2} waypoints between the aircraft and the goal, "
            f"but the board holds {most}; leave some out, or give a simulated board a larger "
            "max_waypoints."
        )
    highest = (config.map_size - 1, config.map_size - 1, config.blocked_altitude)
    for number, point in enumerate(points, start=1):
        text = ",".join(f"{value:g}" for value in point)
        if (point != np.floor(point)).any():
            raise InputError(
                f"{file}: point {number} must be whole cells and altitude steps, not {text}."
            )
        if (point < 0).any() or (point > highest).any():
            raise InputError(
                f"{file}: point {number} must be from 0,0,0 to "
                f"{','.join(map(str, highest))}, not {text}."
            )
    return points.astype(np.int64)
