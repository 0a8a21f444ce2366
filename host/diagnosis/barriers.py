"""Barriers: closed rings of forbidden places around the start or the goal.

Every obstacle is cut into convex pieces: the squares of forbidden nodes, the edges of zones with
their margin, and everything outside the map. Two pieces that touch are linked by a short line
inside both. A ring of links that crosses the straight line from start to goal an odd number of
times encloses exactly one of the two, so no path connects them. The reverse holds too, provided
that the pieces cover all forbidden places.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from pathgene.host.problem.ends import Point
from pathgene.host.terrain import Terrain


__all__ = ["Barrier", "Ring", "nearest_points"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

_EIGHT = np.ones((3, 3), dtype=bool)
_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
# Length of a link of length 0: the search for short rings needs positive lengths.
_LEAST_M = 1e-3
# Number of places where rings are searched for; the shortest ring is reported.
_MOST_SEARCHES = 8


@dataclass(frozen=True)
class Ring:
    """A closed ring around start or goal.

    Parameters
    ----------
    lines : tuple of (n, 2) float64, metres
        The ring as lines; several lines, or an open one, if the edge of the map closes it.
    zones : tuple of int
        Indices of the zones in it, in rising order.
    nodes : (k, 2) int64
        Rows and columns of the forbidden nodes in it.
    edge_of_map : bool
        The edge of the map is a part of it.
    place : (float, float)
        Point of the ring on, or next to, the straight line from start to goal.
    """

    lines: tuple[Floats, ...]
    zones: tuple[int, ...]
    nodes: Ints
    edge_of_map: bool
    place: tuple[float, float]


def nearest_points(one: Floats, other: Floats) -> tuple[Floats, Floats]:
    """Return the nearest points of pairs of segments, (n, 2) each.

    Parameters
    ----------
    one, other : (n, 4) float64
        Both ends of each segment, x and y.
    """
    a, b, c, d = one[:, :2], one[:, 2:4], other[:, :2], other[:, 2:4]
    pairs = [
        (a, _onto(a, c, d)),
        (b, _onto(b, c, d)),
        (_onto(c, a, b), c),
        (_onto(d, a, b), d),
    ]
    along, across = b - a, d - c
    turn = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = ((c - a)[:, 0] * across[:, 1] - (c - a)[:, 1] * across[:, 0]) / turn
        t = ((c - a)[:, 0] * along[:, 1] - (c - a)[:, 1] * along[:, 0]) / turn
        meet = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    first, second = pairs[0]
    least = np.hypot(*(first - second).T)
    for p, q in pairs[1:]:
        away = np.hypot(*(p - q).T)
        nearer = away < least
        first, second = np.where(nearer[:, None], p, first), np.where(nearer[:, None], q, second)
        least = np.minimum(least, away)
    crossing = a + np.where(meet, s, 0.0)[:, None] * along
    return np.where(meet[:, None], crossing, first), np.where(meet[:, None], crossing, second)


def _onto(points: Floats, start: Floats, stop: Floats) -> Floats:
    """Return the points of segments nearest to points."""
    way = stop - start
    square = np.maximum((way * way).sum(axis=1), 1e-300)
    share = np.clip(((points - start) * way).sum(axis=1) / square, 0.0, 1.0)
    on: Floats = start + share[:, None] * way
    return on


class Barrier:
    """The forbidden pieces of a map, and the rings that they close between start and goal.

    Parameters
    ----------
    start, goal : (float, float, float)
        The ends; their altitudes are ignored.
    forbidden : (ny, nx) bool
        Nodes whose square no path may touch.
    pieces : (n, 5) float64
        Capsules, as from :meth:`pathgene.host.problem.footprints.Footprint.capsules`.
    owners : (n,) int64
        Number of the zone of each capsule.
    diagonal : bool
        Nodes that touch at a corner are linked.
    edges_m : (float, float, float, float)
        Widths of the strips along the west, east, south and north edges of the map that count as
        outside. They hold neither end.
    """

    def __init__(
        self,
        terrain: Terrain,
        start: Point,
        goal: Point,
        forbidden: Flags,
        pieces: Floats,
        owners: Ints,
        *,
        diagonal: bool = True,
        edges_m: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
    ) -> None:
        self._terrain = terrain
        self._ends = np.array([start[:2], goal[:2]])
        self._pieces, self._owners = pieces, owners
        # A node surrounded by forbidden nodes adds no ring that its neighbours do not already
        # close.
        kept = forbidden & ~ndimage.binary_erosion(forbidden, _EIGHT, border_value=0)
        self._nodes = np.argwhere(kept)
        count = len(self._nodes)
        self._number = np.full(terrain.shape, -1, dtype=np.int64)
        self._number[kept] = np.arange(count)
        self._outside = count + len(pieces)
        middles = 0.5 * (pieces[:, :2] + pieces[:, 2:4])
        self._places = np.concatenate(
            (self._nodes[:, ::-1] * (terrain.dx_m, terrain.dy_m), middles)
        )
        self._links: list[tuple[Ints, Ints, Flags, Floats]] = []
        self._ways: dict[tuple[int, int, bool], list[Floats]] = {}
        self._link_nodes(kept, _STEPS if diagonal else _STEPS[:2])
        self._link_zones(count)
        self._link_zones_to_nodes(count)
        self._link_outside(count, edges_m)
        self._graph, self._odd = self._doubled()

    @property
    def closed(self) -> bool:
        """True if there is no path from start to goal."""
        return bool(self._odd.any())

    def ring(self) -> Ring:
        """Return a short ring that separates start and goal; there must be one."""
        count = self._outside + 1
        tails = np.concatenate([a[odd] for a, _, odd, _ in self._links])
        sources = np.unique(tails[self._odd[tails]])
        step = max(1, len(sources) // _MOST_SEARCHES)
        sources = sources[step // 2 :: step][:_MOST_SEARCHES]
        lengths, before = dijkstra(self._graph, indices=sources, return_predecessors=True)
        best = int(np.argmin(lengths[np.arange(len(sources)), sources + count]))
        at = int(sources[best] + count)
        states = [at]
        while at != sources[best]:
            at = int(before[best, at])
            states.append(at)
        return self._described(states)

    def _described(self, states: list[int]) -> Ring:
        """Return the ring through states of the doubled graph."""
        count = self._outside + 1
        vertices = [state % count for state in states]
        lines: list[list[Floats]] = [[]]
        place, nearest = (0.0, 0.0), np.inf
        for (one, u), (other, v) in itertools.pairwise(zip(states, vertices, strict=True)):
            odd = (one < count) != (other < count)
            way = self._ways.get((u, v, odd))
            if way is None:
                way = self._ways.get((v, u, odd), [])[::-1]
            ends = [[] if w == self._outside else [self._places[w]] for w in (u, v)]
            points = [*ends[0], *way, *ends[1]]
            if u == self._outside:
                lines.append([])
            lines[-1] += points
            if odd and len(points) > 1:
                parts = np.array(points)
                on, line = nearest_points(
                    np.hstack((parts[:-1], parts[1:])),
                    np.broadcast_to(self._ends.ravel(), (len(parts) - 1, 4)),
                )
                away = np.hypot(*(on - line).T)
                if away.min() < nearest:
                    nearest = float(away.min())
                    x, y = on[int(np.argmin(away))].tolist()
                    place = x, y
        if self._outside in vertices:
            # The last line leads back to the beginning of the first.
            lines = [lines[-1] + lines[0], *lines[1:-1]]
        drawn = [np.array(line) for line in lines if len(line) > 1]
        nodes = sorted({v for v in vertices if v < len(self._nodes)})
        zones = {
            int(self._owners[v - len(self._nodes)])
            for v in vertices
            if len(self._nodes) <= v < self._outside
        }
        return Ring(
            tuple(drawn),
            tuple(sorted(zones)),
            self._nodes[nodes],
            self._outside in vertices,
            place,
        )

    def _crosses(self, p: Floats, q: Floats) -> Flags:
        """Return which lines, (n, 2) to (n, 2), cross the line from start to goal."""
        start, way = self._ends[0], self._ends[1] - self._ends[0]

        def side(points: Floats) -> Floats:
            away: Floats = points - start
            cross: Floats = way[0] * away[:, 1] - way[1] * away[:, 0]
            return cross

        left_p, left_q = side(p), side(q)
        with np.errstate(divide="ignore", invalid="ignore"):
            on = p + (left_p / (left_p - left_q))[:, None] * (q - p)
            share = ((on - start) @ way) / (way @ way)
            found: Flags = ((left_p > 0) != (left_q > 0)) & (share > 0) & (share < 1)
        return found

    def _add(self, tails: Ints, heads: Ints, ways: Sequence[Floats]) -> None:
        """Add links along ``ways``, sequences of points (n, 2), including their ends."""
        odd = np.zeros(len(tails), dtype=bool)
        length = np.full(len(tails), _LEAST_M)
        for p, q in itertools.pairwise(ways):
            odd ^= self._crosses(p, q)
            length += np.hypot(*(q - p).T)
        self._links.append((tails, heads, odd, length))
        if len(ways) > 2:
            for i, key in enumerate(zip(tails.tolist(), heads.tolist(), odd.tolist(), strict=True)):
                self._ways[key] = [way[i] for way in ways[1:-1]]

    def _link_nodes(self, kept: Flags, steps: Sequence[tuple[int, int]]) -> None:
        rows, columns = kept.shape
        for up, east in steps:
            low = self._number[: rows - up, max(0, -east) : columns - max(0, east)]
            high = self._number[up:, max(0, east) : columns - max(0, -east)]
            both = (low >= 0) & (high >= 0)
            tails, heads = low[both], high[both]
            self._add(tails, heads, (self._places[tails], self._places[heads]))

    def _link_zones(self, first: int) -> None:
        pieces = self._pieces
        low = np.minimum(pieces[:, :2], pieces[:, 2:4]) - pieces[:, 4:]
        high = np.maximum(pieces[:, :2], pieces[:, 2:4]) + pieces[:, 4:]
        pairs = [np.empty((0, 2), dtype=np.int64)]
        for i in range(len(pieces) - 1):
            near = (low[i + 1 :] <= high[i]) & (high[i + 1 :] >= low[i])
            others = np.flatnonzero(near.all(axis=1)) + i + 1
            pairs.append(np.column_stack((np.full(len(others), i), others)))
        one, other = np.concatenate(pairs).T
        p, q = nearest_points(pieces[one, :4], pieces[other, :4])
        touch = np.hypot(*(p - q).T) <= pieces[one, 4] + pieces[other, 4]
        one, other, p, q = one[touch], other[touch], p[touch], q[touch]
        places = self._places
        self._add(one + first, other + first, (places[one + first], p, q, places[other + first]))

    def _link_zones_to_nodes(self, first: int) -> None:
        rows, columns = self._terrain.shape
        side = np.array([self._terrain.dx_m, self._terrain.dy_m])
        for number, piece in enumerate(self._pieces):
            ends, radius = piece[:4].reshape(2, 2), piece[4]
            low = np.floor((ends.min(axis=0) - radius) / side).astype(np.int64)
            high = np.ceil((ends.max(axis=0) + radius) / side).astype(np.int64) + 1
            (left, south), (right, north) = np.clip(low, 0, (columns, rows)), np.maximum(high, 0)
            window = self._number[south:north, left:right]
            heads = window[window >= 0]
            if not len(heads):
                continue
            centres = self._places[heads]
            p = _onto(centres, *(np.broadcast_to(end, centres.shape) for end in ends))
            q = np.clip(p, centres - 0.5 * side, centres + 0.5 * side)
            touch = np.hypot(*(p - q).T) <= radius
            heads, centres, p, q = heads[touch], centres[touch], p[touch], q[touch]
            tails = np.full(len(heads), first + number)
            self._add(tails, heads, (self._places[tails], p, q, centres))

    def _link_outside(self, first: int, edges_m: tuple[float, float, float, float]) -> None:
        terrain = self._terrain
        centres = self._places[:first]
        ends = self._pieces[:, :4].reshape(-1, 2, 2)
        radius = self._pieces[:, 4]
        borders = (
            (0, 0.0, 1.0),
            (0, terrain.width_m, -1.0),
            (1, 0.0, 1.0),
            (1, terrain.height_m, -1.0),
        )
        for (axis, border, sign), strip_m in zip(borders, edges_m, strict=True):
            half = 0.5 * (terrain.dx_m, terrain.dy_m)[axis]
            out = np.flatnonzero(sign * (centres[:, axis] - border) < half + strip_m)
            self._add_outside(out, axis, border, centres[out])
            which = np.argmin(sign * ends[:, :, axis], axis=1)
            end = ends[np.arange(len(ends)), which]
            out = np.flatnonzero(sign * (end[:, axis] - border) < radius + strip_m)
            self._add_outside(out + first, axis, border, end[out])

    def _add_outside(self, tails: Ints, axis: int, border: float, points: Floats) -> None:
        """Link pieces to the outside, straight across a border from a point of each piece."""
        corner = points.copy()
        corner[:, axis] = border
        outside = np.full(len(tails), self._outside)
        self._add(tails, outside, (self._places[tails], points, corner, corner))

    def _doubled(self) -> tuple[csr_array, Flags]:
        """Return the graph of the pieces for both parities of crossings, and the odd pieces."""
        count = self._outside + 1
        tails, heads, odd, lengths = (
            np.concatenate(parts) for parts in zip(*self._links, strict=True)
        )
        twin = np.where(odd, count, 0)
        one = np.concatenate((tails, tails + count))
        other = np.concatenate((heads + twin, heads + count - twin))
        # If several links join two states, the shortest counts; a matrix would add them.
        order = np.lexsort((np.concatenate((lengths, lengths)), other, one))
        one, other = one[order], other[order]
        lengths = np.concatenate((lengths, lengths))[order]
        fresh = np.ones(len(one), dtype=bool)
        fresh[1:] = (one[1:] != one[:-1]) | (other[1:] != other[:-1])
        one, other, lengths = one[fresh], other[fresh], lengths[fresh]
        graph = csr_array((lengths, (one, other)), shape=(2 * count, 2 * count))
        graph = graph.maximum(graph.T)
        _, part = connected_components(graph, directed=False)
        return graph, part[:count] == part[count:]
