"""Rings of corners: how they are given, and which nodes of a grid they contain."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.shapes import Ring
from pathgene.host.numeric import numbers
from pathgene.host.problem.loops import drawn_once


__all__ = [
    "EDGE_M",
    "Ring",
    "add_edges",
    "edges",
    "nodes_inside",
    "plain",
    "require_corners",
    "require_near",
    "ring_of",
]

# Nodes this close to an edge are on it: products like 7 * 30.87 are rounded, borders are not.
EDGE_M = 1e-6

#: Maximum number of corners of a ring: each is compared with nodes and points in turn.
MOST_CORNERS = 100_000

#: Maximum coordinate and radius of a zone, metres: farther than any place on Earth.
MOST_M = 1e9


def require_near(kind: str, values: Iterable[float]) -> None:
    """Check that no coordinate or radius of a zone exceeds :data:`MOST_M`.

    Raises
    ------
    InputError
        If one does; the sentence names the ``kind`` of zone.
    """
    for value in values:
        if abs(value) > MOST_M:
            raise InputError(
                f"No-fly {kind}: no coordinate or radius may exceed {MOST_M:g} m, unlike "
                f"{value:g}; give metres in the terrain's local frame."
            )


def require_corners(count: int) -> None:
    """Check that a zone, or a file of zones, has no more than :data:`MOST_CORNERS` on the map.

    Raises
    ------
    InputError
        If it has.
    """
    if count > MOST_CORNERS:
        raise InputError(
            f"{count:,} corners of no-fly zones are more than {MOST_CORNERS:,}; simplify the "
            "outlines, with ogr2ogr -simplify 0.00001 for example."
        )


def plain(corners: Any) -> Any:
    """Return the corners of an array, of numpy for example, as a list of pairs."""
    return corners.tolist() if hasattr(corners, "tolist") else corners


def ring_of(corners: Any) -> Ring:
    """Return ``corners`` as a ring of float64, drawn once, without the closing corner.

    Raises
    ------
    InputError
        If a corner is not two finite numbers, or there are fewer than three.
    """
    try:
        if not isinstance(corners, list | tuple):
            raise ValueError
        require_corners(len(corners))
        ring = tuple(numbers(corner, 2) for corner in corners)
    except ValueError:
        raise InputError(
            "No-fly polygon: every corner must be two finite numbers, x and y."
        ) from None
    if len(ring) > 1 and ring[0] == ring[-1]:
        ring = ring[:-1]
    ring = drawn_once(ring)
    if len(ring) < 3:
        raise InputError(f"No-fly polygon: a ring must have at least 3 corners, not {len(ring)}.")
    require_near("polygon", itertools.chain(*ring))
    return ring


def edges(ring: Ring) -> Iterator[tuple[float, float, float, float]]:
    """Yield the edges of a ring, the closing one included, as x, y, x, y in metres."""
    for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
        yield xa, ya, xb, yb


def nodes_inside(ring: Ring, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the nodes inside a ring, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``.

    The even-odd rule applies; nodes on an edge may go either way.
    """
    crossings = np.zeros((len(y), len(x)), dtype=bool)
    for xa, ya, xb, yb in edges(ring):
        rows = np.flatnonzero((ya <= y) != (yb <= y))
        if len(rows):
            border = xa + (y[rows] - ya) * ((xb - xa) / (yb - ya))
            crossings[rows] ^= x[None, :] < border[:, None]
    return crossings


def add_edges(
    inside: NDArray[np.bool_],
    ring: Ring,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """Set the nodes of ``inside`` that lie on an edge of ``ring``."""
    for xa, ya, xb, yb in edges(ring):
        west, east = np.searchsorted(x, (min(xa, xb) - EDGE_M, max(xa, xb) + EDGE_M))
        south, north = np.searchsorted(y, (min(ya, yb) - EDGE_M, max(ya, yb) + EDGE_M))
        if west == east or south == north:
            continue
        px, py = x[None, west:east] - xa, y[south:north, None] - ya
        ex, ey = xb - xa, yb - ya
        square = ex * ex + ey * ey
        along = np.clip((px * ex + py * ey) / square, 0, 1) if square > 0 else 0.0
        inside[south:north, west:east] |= np.hypot(px - along * ex, py - along * ey) <= EDGE_M
