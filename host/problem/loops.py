"""Outlines that cross themselves or are drawn twice, divided into loops that do not.

By the even-odd rule, ground that an outline encloses twice would be outside. A zone forbids it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.features import Position
from pathgene.host.formats.shapes import Ring


__all__ = ["Untangled", "drawn_once", "is_inside", "untangled"]

Floats = NDArray[np.float64]

# Share of an edge within which a crossing is at its end, and sine of the angle below which two
# edges are parallel.
_END, _PARALLEL = 1e-9, 1e-12
# Loops that are compared with each other.
_MANY_LOOPS = 100
# Pairs of edges that are compared; and pairs whose boxes meet, in all or for each corner, of which
# boundaries of countries have a few.
_MOST_PAIRS, _MOST_MEETING, _MOST_EACH = 100_000_000, 200_000, 10
# Share of the area of an outline's box below which a loop is a spike.
_NO_SHARE = 1e-12


class _CrossingsError(Exception):
    """The edges of an outline meet too often to be divided into loops."""


class Untangled(NamedTuple):
    """Areas that together are the ground inside an outline.

    Parameters
    ----------
    areas : tuple of (ring, ...)
        Outer ring and holes of each area.
    is_tangled : bool
        The outline crosses itself, or encloses ground twice.
    """

    areas: tuple[tuple[Ring, ...], ...]
    is_tangled: bool = False


def drawn_once(ring: Ring) -> Ring:
    """Return a ring that is repeated corner by corner once."""
    for times in (2, 3):
        count, rest = divmod(len(ring), times)
        if count >= 3 and not rest and ring == ring[:count] * times:
            return ring[:count]
    # The closing corner may stand between two rounds.
    count = len(ring) // 2
    if (
        len(ring) % 2
        and count >= 3
        and ring[count] == ring[0]
        and ring[:count] == ring[count + 1 :]
    ):
        return ring[:count]
    return ring


def untangled(outer: Ring, holes: Sequence[Ring] = ()) -> Untangled:
    """Return the areas of an outline with holes, whose edges are straight.

    An outline that does not cross itself stays as it is. Otherwise all ground within any loop is
    inside, except a loop of opposite turn within another one, such as a hole that is joined
    to the outline by a cut. A hole that is the outline itself is no hole. An outline of very many
    loops has no holes, and one with millions of crossings counts as its box.
    """
    corners = frozenset(outer)
    own = [hole for hole in holes if frozenset(hole) != corners]
    try:
        found, crosses = _with_crossings(outer)
    except _CrossingsError:
        return Untangled(((_box(outer),),), True)
    loops = list(_loops(found))
    different = {frozenset(loop): loop for loop in loops}
    if len(different) > _MANY_LOOPS:
        # Their holes would take long to find, and count as inside.
        return Untangled(tuple((loop,) for loop in different.values()), True)
    areas = list(_areas(different.values()))
    is_tangled = crosses or len(different) < len(loops) or _overlap(areas)
    if not is_tangled:
        return Untangled(((outer, *own),), len(own) < len(holes))
    rings = [(*area, *(hole for hole in own if _holds(area[0], hole))) for area in areas]
    return Untangled(tuple(rings), True)


def _with_crossings(ring: Ring) -> tuple[list[Position], bool]:
    """Return a ring with a corner at each crossing and touch, and whether there is a crossing."""
    start = np.array(ring, dtype=np.float64).reshape(-1, 2)
    ahead = np.roll(start, -1, axis=0) - start
    more: dict[int, list[tuple[float, Position]]] = {}
    crosses = False
    pairs = 0
    for one, other in _meeting(start, ahead):
        pairs += len(one)
        if pairs > max(_MOST_MEETING, _MOST_EACH * len(ring)):
            raise _CrossingsError
        d, e, apart = ahead[one], ahead[other], start[other] - start[one]
        across = _cross(d, e)
        is_parallel = np.abs(across) <= _PARALLEL * np.hypot(*d.T) * np.hypot(*e.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            t, u = _cross(apart, e) / across, _cross(apart, d) / across
        is_on = _is_on(t) & _is_on(u) & ~is_parallel
        for k in np.flatnonzero(is_on & ~(_is_end(t) & _is_end(u))).tolist():
            i, j, at, along = int(one[k]), int(other[k]), float(t[k]), float(u[k])
            first, second = _end(ring, i, at), _end(ring, j, along)
            if first is None and second is None:
                crosses = True
                x, y = start[i] + at * ahead[i]
                first = second = (float(x), float(y))
                more.setdefault(i, []).append((at, first))
                more.setdefault(j, []).append((along, second))
            elif first is None and second is not None:
                more.setdefault(i, []).append((at, second))
            elif second is None and first is not None:
                more.setdefault(j, []).append((along, first))
        for k in np.flatnonzero(is_parallel).tolist():
            for i, j in ((int(one[k]), int(other[k])), (int(other[k]), int(one[k]))):
                for corner in (ring[j], ring[(j + 1) % len(ring)]):
                    share = _share(start[i], ahead[i], corner)
                    if share is not None:
                        more.setdefault(i, []).append((share, corner))
    found: list[Position] = []
    for number, corner in enumerate(ring):
        for _, each in [(0.0, corner), *sorted(more.get(number, ()))]:
            if not found or found[-1] != each:
                found.append(each)
    return found, crosses


def _meeting(start: Floats, ahead: Floats) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Yield the pairs of edges whose boxes meet."""
    low, high = np.minimum(start, start + ahead), np.maximum(start, start + ahead)
    # Along the longer side of the box, fewer edges lie beside each other.
    along = int(np.argmax(np.ptp(start, axis=0)))
    order = np.argsort(low[:, along], kind="stable")
    first, last = low[order, along], high[order, along]
    active = np.arange(len(order))
    pairs = 0
    for step in range(1, len(order)):
        # Edges that begin beyond the end of another one are followed by such edges only.
        active = active[: np.searchsorted(active, len(order) - step)]
        active = active[first[active + step] <= last[active]]
        pairs += len(active)
        if not len(active):
            return
        if pairs > _MOST_PAIRS:
            raise _CrossingsError
        one, other = order[active], order[active + step]
        across = 1 - along
        near = (low[one, across] <= high[other, across]) & (low[other, across] <= high[one, across])
        if near.any():
            yield one[near], other[near]


def _cross(a: Floats, b: Floats) -> Floats:
    crossed: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return crossed


def _is_on(share: Floats) -> NDArray[np.bool_]:
    return (share >= -_END) & (share <= 1 + _END)


def _is_end(share: Floats) -> NDArray[np.bool_]:
    return (share <= _END) | (share >= 1 - _END)


def _end(ring: Ring, edge: int, share: float) -> Position | None:
    """Return the end of an edge that a share of it is; None for a place between."""
    if share <= _END:
        return ring[edge]
    return ring[(edge + 1) % len(ring)] if share >= 1 - _END else None


def _share(start: Floats, ahead: Floats, corner: Position) -> float | None:
    """Return the share of an edge at which a corner lies between its ends, or None."""
    away = np.array(corner) - start
    square = float(ahead @ ahead)
    if square == 0.0 or abs(float(_cross(ahead, away))) > _END * square:
        return None
    share = float(ahead @ away) / square
    return share if _END < share < 1 - _END else None


def _loops(ring: Iterable[Position]) -> Iterator[Ring]:
    """Yield the loops of a ring between returns to a corner, without spikes."""
    corners = list(ring)
    spread = np.ptp(np.array(corners), axis=0)
    least = _NO_SHARE * float(spread[0] * spread[1])
    stack: list[Position] = []
    at: dict[Position, int] = {}
    for corner in [*corners, corners[0]]:
        if corner in at:
            loop = tuple(stack[at[corner] :])
            for each in loop[1:]:
                del at[each]
            del stack[at[corner] + 1 :]
            if len(loop) > 2 and abs(_area(loop)) > least:
                yield loop
        else:
            at[corner] = len(stack)
            stack.append(corner)


def _area(ring: Ring) -> float:
    """Return the area of a ring, positive if it turns to the left."""
    # Next to the first corner, where rounding is small.
    x0, y0 = ring[0]
    moved = [(x - x0, y - y0) for x, y in ring[1:]]
    return 0.5 * sum(xa * yb - xb * ya for (xa, ya), (xb, yb) in itertools.pairwise(moved))


def _box(ring: Ring) -> Ring:
    (west, south), (east, north) = np.min(ring, axis=0).tolist(), np.max(ring, axis=0).tolist()
    return ((west, south), (east, south), (east, north), (west, north))


def _areas(loops: Iterable[Ring]) -> Iterator[tuple[Ring, ...]]:
    """Yield loops with the loops of opposite turn inside them, which are holes."""
    sizes = [(_area(loop), loop) for loop in loops]
    sizes.sort(key=lambda each: -abs(each[0]))
    areas: list[tuple[float, list[Ring]]] = []
    for area, loop in sizes:
        around = [each for each in areas if _holds(each[1][0], loop)]
        # The smallest one.
        if around and around[-1][0] * area < 0:
            around[-1][1].append(loop)
        else:
            areas.append((area, [loop]))
    for _, rings in areas:
        yield tuple(rings)


def _overlap(areas: Sequence[tuple[Ring, ...]]) -> bool:
    """Return whether one of several areas lies inside another one."""
    return any(
        _holds(one[0], other[0]) and not any(_holds(hole, other[0]) for hole in one[1:])
        for one in areas
        for other in areas
        if one is not other
    )


def _holds(ring: Ring, other: Ring) -> bool:
    """Return whether a ring holds all corners of another one that are not its own."""
    own = set(ring)
    points = np.array([corner for corner in other if corner not in own]).reshape(-1, 2)
    if not len(points):
        # They have all corners in common, so the middle of an edge decides.
        points = np.array(other)
        points = 0.5 * (points + np.roll(points, -1, axis=0))
    return bool(is_inside(ring, points).all())


def is_inside(ring: Ring, points: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 2) lie inside a ring, by the even-odd rule."""
    x, y = points.T
    inside = np.zeros(len(points), dtype=bool)
    for (xa, ya), (xb, yb) in zip(ring, (*ring[1:], ring[0]), strict=True):
        if ya != yb:
            crossed = (ya <= y) != (yb <= y)
            inside ^= crossed & (x < xa + (y - ya) * ((xb - xa) / (yb - ya)))
    return inside
