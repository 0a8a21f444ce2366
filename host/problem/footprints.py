"""Footprints of zones: the shape of a zone as seen from above, a disc or an area within rings."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from pathgene.host.formats.shapes import wound
from pathgene.host.problem.rings import Ring, add_edges, edges, nodes_inside


__all__ = ["Area", "Disc", "Footprint"]

# Pairs of an edge and a point that are compared at a time, which bounds the memory.
_PAIRS = 1 << 20

_Floats = NDArray[np.float64]
_Flags = NDArray[np.bool_]


class Footprint(ABC):
    """Geometry of a zone on the ground, metres in the terrain's local frame.

    A footprint has either a ``disc`` or ``rings``. Files and pictures that represent circles in a
    special way use ``disc``; everything else works with any footprint.
    """

    @property
    @abstractmethod
    def disc(self) -> tuple[float, float, float] | None:
        """Centre x and y and radius of a disc; None for an area."""

    @property
    @abstractmethod
    def rings(self) -> tuple[Ring, ...]:
        """Outer ring and holes of an area; empty for a disc."""

    @property
    @abstractmethod
    def middle(self) -> tuple[float, float]:
        """Position of the zone's name on a map."""

    @property
    @abstractmethod
    def box(self) -> tuple[float, float, float, float]:
        """Lowest x, lowest y, highest x and highest y."""

    @property
    def wound_rings(self) -> tuple[Ring, ...]:
        """The rings with the outer one counter-clockwise and holes clockwise, as in RFC 7946."""
        return tuple(wound(ring, left=number == 0) for number, ring in enumerate(self.rings))

    @abstractmethod
    def outline(self, corners: int, *, around: bool = False) -> tuple[Ring, ...]:
        """Return the rings; for a disc, the inscribed regular polygon, or the one ``around`` it."""

    @abstractmethod
    def capsules(self, margin_m: float) -> _Floats:
        """Return the border, widened by a margin, as capsules (n, 5): x, y, x, y and the radius."""

    @abstractmethod
    def covers(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""

    @abstractmethod
    def contains(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the points inside, (k,) bool; points on an edge of an area may go either way."""

    @abstractmethod
    def distance_m(self, x: _Floats, y: _Floats) -> _Floats:
        """Return the distances of points from the border, (k,) float64, negative inside."""

    @abstractmethod
    def least_distance_m(self, x: float, y: float) -> float:
        """Return a lower bound of a point's distance, computed without looping over edges."""


@dataclass(frozen=True)
class Disc(Footprint):
    """A closed disc around (``x_m``, ``y_m``)."""

    x_m: float
    y_m: float
    radius_m: float

    @property
    def disc(self) -> tuple[float, float, float]:
        """Centre x and y and radius."""
        return self.x_m, self.y_m, self.radius_m

    @property
    def rings(self) -> tuple[Ring, ...]:
        """No rings."""
        return ()

    @property
    def middle(self) -> tuple[float, float]:
        """The centre."""
        return self.x_m, self.y_m

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Lowest x, lowest y, highest x and highest y."""
        x, y, radius = self.disc
        return x - radius, y - radius, x + radius, y + radius

    def outline(self, corners: int, *, around: bool = False) -> tuple[Ring, ...]:
        """Return the inscribed regular polygon, or the one ``around`` the disc."""
        angles = np.linspace(0, 2 * np.pi, corners, endpoint=False)
        radius = self.radius_m / math.cos(math.pi / corners) if around else self.radius_m
        x, y = self.x_m + radius * np.cos(angles), self.y_m + radius * np.sin(angles)
        return (tuple(zip(x.tolist(), y.tolist(), strict=True)),)

    def capsules(self, margin_m: float) -> _Floats:
        """Return the centre, twice, and the radius with the margin, (1, 5)."""
        return np.array([[self.x_m, self.y_m, self.x_m, self.y_m, self.radius_m + margin_m]])

    def covers(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""
        return self.contains(x[None, :], y[:, None])

    def contains(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the points inside, bool in the shape to which ``x`` and ``y`` broadcast."""
        inside: _Flags = np.hypot(x - self.x_m, y - self.y_m) <= self.radius_m
        return inside

    def distance_m(self, x: _Floats, y: _Floats) -> _Floats:
        """Return the distances of points from the border, (k,) float64, negative inside."""
        distance: _Floats = np.hypot(x - self.x_m, y - self.y_m) - self.radius_m
        return distance

    def least_distance_m(self, x: float, y: float) -> float:
        """Return the distance of a point from the border, negative inside."""
        return math.hypot(self.x_m - x, self.y_m - y) - self.radius_m


@dataclass(frozen=True)
class Area(Footprint):
    """The area within the first ring of ``corners``, minus the holes, by the even-odd rule."""

    corners: tuple[Ring, ...]

    @property
    def disc(self) -> None:
        """None, since an area has rings."""
        return

    @property
    def rings(self) -> tuple[Ring, ...]:
        """Outer ring and holes."""
        return self.corners

    @property
    def middle(self) -> tuple[float, float]:
        """Mean of the corners of the outer ring."""
        x, y = np.mean(self.rings[0], axis=0).tolist()
        return x, y

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Lowest x, lowest y, highest x and highest y."""
        x, y = zip(*chain(*self.rings), strict=True)
        return min(x), min(y), max(x), max(y)

    def outline(self, corners: int, *, around: bool = False) -> tuple[Ring, ...]:
        """Return the rings themselves."""
        return self.rings

    def capsules(self, margin_m: float) -> _Floats:
        """Return the edges of all rings, each with the margin, (n, 5)."""
        sides = self._edges()
        return np.column_stack((sides, np.full(len(sides), margin_m)))

    def covers(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``.

        Nodes within a micrometre of an edge are inside.
        """
        inside = np.zeros((len(y), len(x)), dtype=bool)
        for ring in self.rings:
            inside ^= nodes_inside(ring, x, y)
        for ring in self.rings:
            add_edges(inside, ring, x, y)
        return inside

    def contains(self, x: _Floats, y: _Floats) -> _Flags:
        """Return the points inside, (k,) bool; points on an edge may go either way."""
        crossings = np.zeros(len(x), dtype=np.intp)
        sides = self._edges()
        most = max(_PAIRS // max(len(x), 1), 1)
        for first in range(0, len(sides), most):
            xa, ya, xb, yb = sides[first : first + most].T
            edge, point = np.nonzero((ya[:, None] <= y) != (yb[:, None] <= y))
            slope = (xb[edge] - xa[edge]) / (yb[edge] - ya[edge])
            border = xa[edge] + (y[point] - ya[edge]) * slope
            crossings += np.bincount(point[x[point] < border], minlength=len(x))
        inside: _Flags = crossings % 2 == 1
        return inside

    def distance_m(self, x: _Floats, y: _Floats) -> _Floats:
        """Return the distances of points from the border, (k,) float64, negative inside."""
        nearest = np.full(len(x), math.inf)
        for xa, ya, xb, yb in self._edges().tolist():
            dx, dy = xb - xa, yb - ya
            square = dx * dx + dy * dy
            along = np.clip(((x - xa) * dx + (y - ya) * dy) / square, 0, 1) if square else 0.0
            nearest = np.minimum(nearest, np.hypot(x - xa - along * dx, y - ya - along * dy))
        return np.where(self.contains(x, y), -nearest, nearest)

    def least_distance_m(self, x: float, y: float) -> float:
        """Return the distance of a point from the box, 0 inside."""
        west, south, east, north = self.box
        return float(np.hypot(max(west - x, x - east, 0.0), max(south - y, y - north, 0.0)))

    def _edges(self) -> _Floats:
        """Return the edges of all rings, (n, 4): x, y, x, y."""
        return np.array([edge for ring in self.rings for edge in edges(ring)])
