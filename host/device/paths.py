"""Paths on a chip: waypoints packed into integers, and checks by the collision checker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import CheckFlag, Command
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_reply,
    check_request,
    results_request,
)
from pathgene.hdl.protocol.paths import PathResult, pack_paths, unpack_results
from pathgene.host.device.link import Link


__all__ = ["CheckReport", "check_points", "check_slots", "pack_waypoints", "unpack_waypoints"]


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


#: Number of paths whose results are requested in one frame after a long reply is lost.
_PATHS_PER_FRAME = 2


@dataclass(frozen=True)
class CheckReport:
    """Results of the paths that a chip has checked.

    Attributes
    ----------
    verdicts : tuple of PathResult
        Result of each path, in the order of the paths.
    cycles : int
        Cycles of the checker, from the first point to the last verdict.
    reads : int
        Addresses sent to the memories of the map.
    cells : int
        Cells checked; on each path, cells up to its first collision.
    """

    verdicts: tuple[PathResult, ...]
    cycles: int
    reads: int
    cells: int


def check_points(
    config: Config, link: Link, points: Sequence[int], *, counting: bool
) -> CheckReport:
    """Check one path of packed waypoints, from the aircraft to the goal."""
    layout = check_request(config)
    path = pack_paths(config, [points])
    forms = [layout.pack(flags=flags) + path for flags in _forms(counting)]
    return _check(config, link, Command.CHECK, forms, 1)


def check_slots(
    config: Config, link: Link, start: int, goal: int, *, slot: int, count: int, counting: bool
) -> CheckReport:
    """Check the paths of consecutive slots, each between the same packed start and goal."""
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
) -> CheckReport:
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
    return CheckReport(tuple(unpack_results(config, packed)), **totals)
