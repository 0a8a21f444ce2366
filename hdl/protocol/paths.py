"""Paths, cells and results of checks as bytes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.messages import entry_record, hit_record, path_record


__all__ = [
    "PathResult",
    "pack_cells",
    "pack_paths",
    "pack_results",
    "unpack_cells",
    "unpack_paths",
    "unpack_results",
]


def pack_paths(config: Config, paths: Iterable[Sequence[int]]) -> bytes:
    """Return the bytes of ``paths``, each a list of packed waypoints."""
    size, last = config.waypoint_bytes, 1 << config.waypoint_bits
    parts = []
    for path in paths:
        parts += [waypoint.to_bytes(size, "little") for waypoint in path[:-1]]
        parts.append((path[-1] | last).to_bytes(size, "little"))
    return b"".join(parts)


def unpack_paths(config: Config, payload: bytes) -> list[list[int]]:
    """Return the paths in ``payload``, the inverse of :func:`pack_paths`.

    Raises
    ------
    ValueError
        If the payload ends inside a waypoint or a path, or if the length of a path is out of range.
    """
    size, bits = config.waypoint_bytes, config.waypoint_bits
    if len(payload) % size:
        raise ValueError(f"Paths must be whole waypoints of {size} bytes, not {len(payload)} bytes")
    paths: list[list[int]] = []
    path: list[int] = []
    for at in range(0, len(payload), size):
        word = int.from_bytes(payload[at : at + size], "little")
        path.append(word & ((1 << bits) - 1))
        if word >> bits & 1:
            if not config.MIN_WAYPOINTS <= len(path) <= config.max_waypoints:
                raise ValueError(
                    f"Path must have {config.MIN_WAYPOINTS} to {config.max_waypoints} waypoints, "
                    f"not {len(path)}"
                )
            paths.append(path)
            path = []
    if path:
        raise ValueError("Paths must end with a waypoint marked last")
    return paths


def pack_cells(config: Config, altitudes: Sequence[int]) -> bytes:
    """Return the bytes of the cells ``altitudes``, ``altitude_bits`` each."""
    bits = config.altitude_bits
    packed = 0
    for altitude in reversed(altitudes):
        packed = packed << bits | altitude
    return packed.to_bytes((len(altitudes) * bits + 7) // 8, "little")


def unpack_cells(config: Config, payload: bytes) -> list[int]:
    """Return the whole cells in ``payload``; the bits after the last whole cell are padding."""
    bits = config.altitude_bits
    packed = int.from_bytes(payload, "little")
    mask = (1 << bits) - 1
    return [packed >> bits * i & mask for i in range(8 * len(payload) // bits)]


@dataclass(frozen=True)
class PathResult:
    """Result of one path.

    Attributes
    ----------
    collision : bool
        True if the path collides; if not, ``entries`` is empty and all other attributes are None.
    segment : int or None
        First colliding segment; 0 is the segment from the aircraft.
    cell : tuple of int, or None
        The x and y of the first colliding cell, in cells of its map.
    coarse : bool or None
        True if that cell belongs to the coarse map.
    cells : int or None
        Cells checked, up to and including this cell.
    entries : tuple of (int, int, int)
        For each segment with colliding cells, if the check counts them: number of the segment,
        colliding cells of terrain, blocked cells.
    """

    collision: bool = False
    segment: int | None = None
    cell: tuple[int, int] | None = None
    coarse: bool | None = None
    cells: int | None = None
    entries: tuple[tuple[int, int, int], ...] = ()


def pack_results(config: Config, results: Iterable[PathResult]) -> bytes:
    """Return the bytes of ``results``."""
    path, hit, entry = path_record(config), hit_record(config), entry_record(config)
    parts = []
    for result in results:
        parts.append(path.pack(collision=result.collision, entries=len(result.entries)))
        if result.collision:
            assert result.segment is not None
            assert result.cell is not None
            assert result.coarse is not None
            assert result.cells is not None
            x, y = result.cell
            parts.append(
                hit.pack(segment=result.segment, coarse=result.coarse, x=x, y=y, cells=result.cells)
            )
        for segment, terrain, nofly in result.entries:
            parts.append(entry.pack(segment=segment, terrain=terrain, nofly=nofly))
    return b"".join(parts)


def unpack_results(config: Config, payload: bytes) -> list[PathResult]:
    """Return the results in ``payload``, the inverse of :func:`pack_results`.

    Raises
    ------
    ValueError
        If the payload ends inside a result.
    """
    path, hit, entry = path_record(config), hit_record(config), entry_record(config)
    at = 0

    def take(size: int) -> bytes:
        nonlocal at
        if at + size > len(payload):
            raise ValueError(f"Results must be whole, not end after {len(payload)} bytes")
        at += size
        return payload[at - size : at]

    results = []
    while at < len(payload):
        record = path.unpack(take(path.size))
        where = hit.unpack(take(hit.size)) if record["collision"] else None
        entries = []
        for _ in range(record["entries"]):
            values = entry.unpack(take(entry.size))
            entries.append((values["segment"], values["terrain"], values["nofly"]))
        if where is None:
            results.append(PathResult(entries=tuple(entries)))
        else:
            results.append(
                PathResult(
                    collision=True,
                    segment=where["segment"],
                    cell=(where["x"], where["y"]),
                    coarse=bool(where["coarse"]),
                    cells=where["cells"],
                    entries=tuple(entries),
                )
            )
    return results
