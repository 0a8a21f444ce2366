"""Paths and cells of the map as bytes on the link."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pathgene.hdl.config import Config


__all__ = ["pack_cells", "pack_paths", "unpack_cells", "unpack_paths"]


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
