"""Areas cut along a line, without edges where no area is."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.host.formats.shapes import Ring


__all__ = ["cut"]

Point = tuple[float, float]


def cut(rings: Sequence[Ring], axis: int, bound: float, sign: int) -> list[tuple[Ring, ...]]:
    """Return the areas on one side of a line, each an outer ring and its holes.

    The line is closed between its crossings with the rings, first and second, third and fourth and
    so on, since between them lies the area by the even-odd rule.

    Parameters
    ----------
    rings : sequence of rings
        Outer ring and holes.
    axis : int
        0 for a line along y, 1 for a line along x.
    bound : float
        The coordinate of the line.
    sign : int
        1 for the side of greater coordinates, -1 for the side of smaller ones.
    """
    chains: list[list[Point]] = []
    uncut: list[Ring] = []
    for number, ring in enumerate(rings):
        kept = [sign * (corner[axis] - bound) >= 0 for corner in ring]
        if all(kept):
            if number == 0:
                return [tuple(rings)]
            uncut.append(ring)
        elif any(kept):
            first = kept.index(False)
            chains += _chains((*ring[first:], *ring[:first]), axis, bound, sign)
    areas = [[ring] for ring in _joined(chains, 1 - axis)]
    for hole in uncut:
        around = next((area for area in areas if _holds(area[0], hole[0])), None)
        if around is not None:
            around.append(hole)
    return [tuple(area) for area in areas]


def _chains(ring: Ring, axis: int, bound: float, sign: int) -> list[list[Point]]:
    """Return the chains of a ring on one side; its first corner is not on this side."""
    chains: list[list[Point]] = []
    for start, stop in zip(ring, (*ring[1:], ring[0]), strict=True):
        a, b = sign * (start[axis] - bound), sign * (stop[axis] - bound)
        if (a >= 0) != (b >= 0):
            share = a / (a - b)
            crossing = [start[k] + share * (stop[k] - start[k]) for k in (0, 1)]
            crossing[axis] = bound
            if b >= 0:
                chains.append([])
            chains[-1].append((crossing[0], crossing[1]))
        if b >= 0:
            chains[-1].append(stop)
    return chains


def _joined(chains: Sequence[list[Point]], along: int) -> list[Ring]:
    """Return rings of chains, whose ends are joined in pairs along the line."""
    ends = sorted(
        ((chain[end][along], number, end) for number, chain in enumerate(chains) for end in (0, -1))
    )
    other = {}
    for (_, *one), (_, *two) in zip(ends[::2], ends[1::2], strict=True):
        other[tuple(one)], other[tuple(two)] = tuple(two), tuple(one)
    waiting = dict.fromkeys(range(len(chains)))
    rings: list[Ring] = []
    while waiting:
        first = number = next(iter(waiting))
        entry, corners = 0, []
        while number in waiting:
            del waiting[number]
            corners += chains[number] if entry == 0 else chains[number][::-1]
            number, entry = other[number, -1 if entry == 0 else 0]
        assert number == first
        plain = tuple(
            corner
            for corner, before in zip(corners, (corners[-1], *corners), strict=False)
            if corner != before
        )
        if len(set(plain)) >= 3:
            rings.append(plain)
    return rings


def _holds(ring: Ring, point: Point) -> bool:
    """Return whether a point lies in a ring."""
    x, y = point
    inside = False
    for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if (ya <= y) != (yb <= y):
            inside ^= x < xa + (y - ya) * (xb - xa) / (yb - ya)
    return inside
