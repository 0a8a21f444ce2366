"""The collision checker of a chip: what is sent to it, and what it says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hdl.config import Config
from hdl.protocol import (
    BODY_HEADER_BYTES,
    CRC_BYTES,
    CheckFlag,
    Command,
    PathResult,
    check_paths_request,
    check_reply,
    check_request,
    map_request,
    pack_paths,
    results_request,
    unpack_results,
)
from host.device.link import Link


__all__ = ["Checked", "check_points", "check_slots", "map_frames"]

#: Most cells of the map in one frame.
_FRAME_CELLS = 256
#: Frames of the map that the chip's buffer is to hold at least: the line never waits for answers.
_FRAMES_IN_FLIGHT = 4
#: Paths whose results are asked for in one frame where long ones get lost.
_PATHS_PER_FRAME = 2


@dataclass(frozen=True)
class Checked:
    """What a chip says of paths that it has checked.

    Attributes
    ----------
    verdicts : tuple of PathResult
        What became of each path, in their order.
    cycles : int
        Clocks of the checker, from the first point to the last verdict.
    reads : int
        Addresses that it gave to the memories of the map.
    cells : int
        Cells that it checked, each path's up to the one that hits first.
    """

    verdicts: tuple[PathResult, ...]
    cycles: int
    reads: int
    cells: int


def map_frames(
    config: Config, heights: NDArray[np.integer], x: int, y: int
) -> Iterator[tuple[bytes, tuple[slice, slice]]]:
    """Yield the payload of every MAP for a rectangle, and its rows and columns of the map.

    The cells of a frame share their block of the coarse map where they can: the chip then renews
    fewest of those.

    Parameters
    ----------
    config : Config
    heights : ndarray
        ``(rows, columns)`` integers, altitude steps, row 0 the southernmost.
    x, y : int
        Cell of ``heights[0, 0]``.

    Raises
    ------
    ValueError
        If it is not of that kind, or not on the map.
    """
    heights = np.asarray(heights)
    if heights.ndim != 2 or heights.size == 0 or not np.issubdtype(heights.dtype, np.integer):
        raise ValueError(
            "Heights must be a filled array of two axes of integers, not of shape "
            f"{heights.shape} of {heights.dtype}"
        )
    rows, columns = heights.shape
    edge, top = config.map_size, config.blocked_altitude
    if not (0 <= x <= edge - columns and 0 <= y <= edge - rows):
        raise ValueError(
            f"Heights must lie within 0..{edge - 1}, not {columns} x {rows} cells at ({x}, {y})"
        )
    if heights.min() < 0 or heights.max() > top:
        raise ValueError(f"Heights must be from 0 to {top}, not {heights.min()} to {heights.max()}")

    width, height = _tile(config)
    for south in range(y - y % height, y + rows, height):
        bottom, above = max(south, y), min(south + height, y + rows)
        for west in range(x - x % width, x + columns, width):
            left, right = max(west, x), min(west + width, x + columns)
            header = map_request(config).pack(
                x=left, y=bottom, width=right - left, height=above - bottom
            )
            cells = heights[bottom - y : above - y, left - x : right - x]
            yield header + _packed(config, cells), (slice(bottom, above), slice(left, right))


def _tile(config: Config) -> tuple[int, int]:
    """Return the size of a frame's rectangle: as much of a coarse block as fits."""
    room = config.receive_buffer // _FRAMES_IN_FLIGHT - BODY_HEADER_BYTES - CRC_BYTES
    cells = (room - map_request(config).size) * 8 // config.altitude_bits
    cells = 1 << min(cells, _FRAME_CELLS).bit_length() - 1
    width = min(config.coarse_factor, cells)
    return width, cells // width


def _packed(config: Config, cells: NDArray[np.integer]) -> bytes:
    """Return cells as :func:`hdl.protocol.pack_cells` does, but many at once."""
    bits = cells.reshape(-1, 1).astype(np.uint32) >> np.arange(config.altitude_bits) & 1
    return np.packbits(bits.astype(np.uint8), bitorder="little").tobytes()


def check_points(config: Config, link: Link, points: Sequence[int], *, counting: bool) -> Checked:
    """Have one path checked: packed waypoints, the aircraft first, the goal last."""
    layout = check_request(config)
    path = pack_paths(config, [points])
    forms = [layout.pack(flags=flags) + path for flags in _forms(counting)]
    return _check(config, link, Command.CHECK, forms, 1)


def check_slots(
    config: Config, link: Link, start: int, goal: int, *, slot: int, count: int, counting: bool
) -> Checked:
    """Have the paths of consecutive slots checked, each between the same packed points."""
    layout = check_paths_request(config)
    forms = [
        layout.pack(slot=slot, count=count, flags=flags, start=start, goal=goal)
        for flags in _forms(counting)
    ]
    return _check(config, link, Command.CHECK_PATHS, forms, count)


def _forms(counting: bool) -> tuple[CheckFlag, CheckFlag]:
    flags = CheckFlag.COUNT if counting else CheckFlag(0)
    return flags, flags | CheckFlag.BRIEF


def _check(
    config: Config, link: Link, command: Command, forms: Sequence[bytes], paths: int
) -> Checked:
    size = check_reply(config).size
    reply = link.request(command, forms[0], shorter=forms[1])
    totals, packed = check_reply(config).unpack(reply[:size]), reply[size:]
    if not packed:
        layout = results_request(config)
        requests = [
            (
                Command.RESULTS,
                layout.pack(path=first, count=min(_PATHS_PER_FRAME, paths - first)),
            )
            for first in range(0, paths, _PATHS_PER_FRAME)
        ]
        packed = b"".join(link.transfer(requests))
    return Checked(tuple(unpack_results(config, packed)), **totals)
