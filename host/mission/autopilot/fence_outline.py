"""Outlines of zones with fewer corners, each simplified outwards: it contains the zone.

A step removes one corner. Where the outline bends inwards, the corner is cut off by a straight
edge. Where it bends outwards at both ends of an edge, the two edges beside it are extended until
they meet, and the edge disappears. So a step adds a triangle to the area and takes nothing from it.

No point of a triangle is farther from the edges that it replaces than the corner that is cut off,
or the corner that is new. An edge carries a bound of its own distance from the zone, and the bound
of a new edge is the sum.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.shapes import Ring, wound
from pathgene.host.problem.footprints import Area


__all__ = ["KeptFree", "Outline"]

Floats = NDArray[np.float64]
_Point = tuple[float, float]
_Triangle = tuple[_Point, _Point, _Point]

# Lengths below this, metres, are rounding errors.
_SAME_M = 1e-6
# New edges are measured at points this share of the maximum distance apart.
_FINE = 0.125


class KeptFree:
    """The neighbourhood of a track, which no outline may grow into.

    Parameters
    ----------
    x, y : ndarray
        Points of the track, (k,) float64 metres.
    step_m : float
        Maximum distance of two neighbouring points.
    """

    def __init__(self, x: Floats, y: Floats, step_m: float) -> None:
        self.x, self.y, self._step_m = x, y, step_m

    def near(self, box: tuple[float, float, float, float], distance_m: float) -> KeptFree:
        """Return the points that are nearer to a box than a distance, and some more."""
        west, south, east, north = box
        reach = distance_m + self._step_m
        inside = (self.x >= west - reach) & (self.x <= east + reach)
        inside &= (self.y >= south - reach) & (self.y <= north + reach)
        return KeptFree(self.x[inside], self.y[inside], self._step_m)

    def is_clear_of(self, triangle: _Triangle, distance_m: float) -> bool:
        """Return whether the track keeps a distance from a triangle."""
        xs, ys = zip(*triangle, strict=True)
        close = self.near((min(xs), min(ys), max(xs), max(ys)), distance_m)
        if not len(close.x):
            return True
        least = Area((triangle,)).distance_m(close.x, close.y).min()
        return bool(least >= distance_m + 0.5 * self._step_m)


class Outline:
    """The rings of a zone, which lose corners one by one, the cheapest first.

    Parameters
    ----------
    rings : sequence of Ring
        The outer ring and the holes.
    free : KeptFree
        The track.
    most_m : float
        Maximum distance from the zone that the outline may reach.
    free_m : float
        Distance from the track that added area keeps.
    """

    def __init__(
        self, rings: Sequence[Ring], free: KeptFree, *, most_m: float, free_m: float
    ) -> None:
        self._given = tuple(wound(ring, left=number == 0) for number, ring in enumerate(rings))
        self._places: list[_Point] = [place for ring in self._given for place in ring]
        count = len(self._places)
        self._before, self._after = list(range(-1, count - 1)), list(range(1, count + 1))
        self._ring_of: list[int] = []
        self._left = [len(ring) for ring in self._given]
        for number, length in enumerate(self._left):
            first = len(self._ring_of)
            self._ring_of += [number] * length
            self._before[first], self._after[first + length - 1] = first + length - 1, first
        # Bounds of the distance of the edge after a corner, and numbers of changes near a corner.
        self._off_m, self._changes = [0.0] * count, [0] * count
        self._is_alive = [True] * count
        # Start x and y and end x and y of the edges; NaN for a removed one.
        self._edges = np.array(
            [(*self._places[at], *self._places[self._after[at]]) for at in range(count)]
        )
        self._zone = self._edges.copy()
        low, high = self._edges.min(axis=0).tolist(), self._edges.max(axis=0).tolist()
        self._free = free.near((low[0], low[1], high[0], high[1]), most_m + free_m)
        self._most_m, self._free_m = most_m, free_m
        self.moved_m = 0.0
        self._offers: list[tuple[float, int, int]] = []
        for corner in range(count):
            self._offer(corner)

    @property
    def corners(self) -> int:
        """Number of corners in all rings."""
        return sum(self._left)

    @property
    def next_m(self) -> float:
        """Bound of the outline's distance from the zone after the next step; infinite if none."""
        while self._offers:
            cost, corner, change = self._offers[0]
            if self._is_alive[corner] and change == self._changes[corner]:
                return cost
            heapq.heappop(self._offers)
        return math.inf

    def step(self) -> None:
        """Take the next step, or discard it if it would touch the outline or the track."""
        if self.next_m == math.inf:
            return
        cost, corner, _ = heapq.heappop(self._offers)
        found = self._triangle(corner)
        if found is None:
            return
        triangle, is_cut = found
        if self._is_free(corner, triangle, is_cut=is_cut) and self._free.is_clear_of(
            triangle, self._free_m
        ):
            self.moved_m = max(self.moved_m, cost)
            self._take(corner, triangle, cost, is_cut=is_cut)

    def rings(self) -> tuple[Ring, ...]:
        """Return the present rings, or the given ones if the present do not contain the zone."""
        if self.corners == len(self._places):
            return self._given
        found = []
        for number in range(len(self._left)):
            corner = next(
                at for at, ring in enumerate(self._ring_of) if ring == number and self._is_alive[at]
            )
            ring = []
            for _ in range(self._left[number]):
                ring.append(self._places[corner])
                corner = self._after[corner]
            found.append(tuple(ring))
        return tuple(found) if _contains(found, self._given) else self._given

    def _triangle(self, corner: int) -> tuple[_Triangle, bool] | None:
        """Return the area that the step at a corner adds, and whether it cuts the corner off."""
        if self._left[self._ring_of[corner]] <= 3:
            return None
        a, b, c = self._before[corner], corner, self._after[corner]
        d = self._after[c]
        pa, pb, pc, pd = (self._places[at] for at in (a, b, c, d))
        turn = _cross(pa, pb, pc)
        if turn <= 0 or _height(pa, pc, pb) < _SAME_M:
            return (pa, pb, pc), True
        if _cross(pb, pc, pd) <= 0:
            return None
        ux, uy, vx, vy = pb[0] - pa[0], pb[1] - pa[1], pc[0] - pd[0], pc[1] - pd[1]
        across = uy * vx - ux * vy  # Positive if the two edges meet beyond b and c.
        if across <= 1e-9 * math.hypot(ux, uy) * math.hypot(vx, vy):
            return None
        share = (vx * (pc[1] - pb[1]) - vy * (pc[0] - pb[0])) / across
        return (pb, (pb[0] + share * ux, pb[1] + share * uy), pc), False

    def _offer(self, corner: int) -> None:
        """Offer the step at a corner, if it stays within the maximum distance."""
        self._changes[corner] += 1
        found = self._triangle(corner)
        if found is None:
            return
        (p, q, r), is_cut = found
        before, after = self._before[corner], self._after[corner]
        edges = (before, corner) if is_cut else (before, corner, after)
        # A corner on the line between its neighbours costs nothing.
        off_m = max(self._off_m[edge] for edge in edges)
        cost = _height(p, r, q) + off_m
        if cost > self._most_m > 0 and off_m <= self._most_m:
            cost = min(cost, self._measured_m((p, q, r), off_m, is_cut=is_cut))
        if cost <= max(self._most_m, _SAME_M):
            heapq.heappush(self._offers, (cost, corner, self._changes[corner]))

    def _measured_m(self, triangle: _Triangle, off_m: float, *, is_cut: bool) -> float:
        """Return a closer bound of a triangle's distance from the zone: new edges are measured."""
        p, q, r = triangle
        inner_m = abs(_cross(p, q, r)) / (math.dist(p, q) + math.dist(q, r) + math.dist(r, p))
        if inner_m + off_m > self._most_m:
            return math.inf
        corners = (p, r) if is_cut else (p, q, r)
        step_m = _FINE * self._most_m
        x, y = np.concatenate(
            [
                np.linspace(a, b, math.ceil(math.dist(a, b) / step_m) + 1)
                for a, b in pairwise(corners)
            ]
        ).T
        xa, ya, xb, yb = self._zone.T
        reach = self._most_m
        near = (np.minimum(xa, xb) <= x.max() + reach) & (np.maximum(xa, xb) >= x.min() - reach)
        near &= (np.minimum(ya, yb) <= y.max() + reach) & (np.maximum(ya, yb) >= y.min() - reach)
        xa, ya, xb, yb = self._zone[near].T[:, :, None]
        dx, dy = xb - xa, yb - ya
        square = np.maximum(dx * dx + dy * dy, _SAME_M**2)
        along = np.clip(((x - xa) * dx + (y - ya) * dy) / square, 0, 1)
        apart = np.hypot(x - xa - along * dx, y - ya - along * dy)
        far_m = float(apart.min(axis=0, initial=math.inf).max()) + 0.5 * step_m
        return max(far_m, off_m) + inner_m

    def _is_free(self, corner: int, triangle: _Triangle, *, is_cut: bool) -> bool:
        """Return whether no other edge touches a triangle."""
        p, q, r = triangle
        after = self._after[corner]
        own = {self._before[corner], corner}
        if not is_cut:
            own.add(after)
        xs, ys = zip(*triangle, strict=True)
        xa, ya, xb, yb = self._edges.T
        near = np.minimum(xa, xb) <= max(xs) + _SAME_M
        near &= np.maximum(xa, xb) >= min(xs) - _SAME_M
        near &= np.minimum(ya, yb) <= max(ys) + _SAME_M
        near &= np.maximum(ya, yb) >= min(ys) - _SAME_M
        corners = {corner, after, self._before[corner] if is_cut else corner}
        sides = ((p, r),) if is_cut else ((p, q), (q, r))
        for edge in np.flatnonzero(near).tolist():
            if edge in own:
                continue
            end = self._after[edge]
            for at in (edge, end):
                if at not in corners and _is_within(triangle, self._places[at]):
                    return False
            ends = self._places[edge], self._places[end]
            if any(_crosses(*side, *ends) for side in sides):
                return False
        return True

    def _take(self, corner: int, triangle: _Triangle, cost: float, *, is_cut: bool) -> None:
        """Remove a corner from the outline."""
        a, c = self._before[corner], self._after[corner]
        if is_cut:
            removed = corner
            self._off_m[a] = cost
        else:
            removed = c
            self._places[corner] = triangle[1]
            self._off_m[a] = max(self._off_m[a], cost)
            self._off_m[corner] = max(self._off_m[c], cost)
        before, after = self._before[removed], self._after[removed]
        self._after[before], self._before[after] = after, before
        self._is_alive[removed] = False
        self._left[self._ring_of[removed]] -= 1
        self._edges[removed] = math.nan
        first = self._before[before]
        for edge in (first, before):
            self._edges[edge] = (*self._places[edge], *self._places[self._after[edge]])
        corner = self._before[first]
        for _ in range(5):
            self._offer(corner)
            corner = self._after[corner]


def _contains(rings: Sequence[Ring], given: Sequence[Ring]) -> bool:
    """Return whether rings contain the given ones, and do not cross themselves."""
    outlines = np.array([side for ring in rings for side in _sides(ring)])
    inner = np.array([side for ring in given for side in _sides(ring)])
    area = Area(tuple(rings))
    if area.distance_m(inner[:, 0], inner[:, 1]).max() > 10 * _SAME_M:
        return False
    return not any(_crosses_any(side, others) for side in outlines for others in (outlines, inner))


def _sides(ring: Ring) -> list[tuple[float, float, float, float]]:
    return [(*a, *b) for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)]


def _crosses_any(side: Floats, others: Floats) -> bool:
    """Return whether a line crosses one of several lines, well within both."""
    limit = 10 * _SAME_M
    apart = np.ones(len(others), bool)
    for lines, points in ((side[:, None], others.T), (others.T, side[:, None])):
        first, second = _beside_m(lines, *points[:2]), _beside_m(lines, *points[2:])
        apart &= (np.minimum(first, second) < -limit) & (np.maximum(first, second) > limit)
    return bool(apart.any())


def _beside_m(lines: Floats, x: Floats, y: Floats) -> Floats:
    """Return by how far points lie to the left of lines, (4, n)."""
    xa, ya, xb, yb = lines
    length = np.maximum(np.hypot(xb - xa, yb - ya), _SAME_M)
    beside: Floats = ((xb - xa) * (y - ya) - (yb - ya) * (x - xa)) / length
    return beside


def _cross(a: _Point, b: _Point, c: _Point) -> float:
    """Return twice the area of a triangle, positive if its corners turn to the left."""
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def _height(a: _Point, b: _Point, point: _Point) -> float:
    """Return the distance of a point from a line between two points."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    share = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.hypot(point[0] - a[0] - share * dx, point[1] - a[1] - share * dy)


def _is_within(triangle: _Triangle, point: _Point) -> bool:
    """Return whether a point is in a triangle or on its border."""
    p, q, r = triangle
    if min(_height(p, q, point), _height(q, r, point), _height(r, p, point)) <= _SAME_M:
        return True
    turns = [_cross(p, q, point), _cross(q, r, point), _cross(r, p, point)]
    return min(turns) > 0 or max(turns) < 0


def _crosses(a: _Point, b: _Point, c: _Point, d: _Point) -> bool:
    """Return whether two lines cross within both."""
    return _cross(a, b, c) * _cross(a, b, d) < 0 and _cross(c, d, a) * _cross(c, d, b) < 0
