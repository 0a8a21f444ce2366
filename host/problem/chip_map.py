"""The terrain on the chip's map: metres to cells and altitude steps, and back."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.host.errors import InputError
from pathgene.host.problem.problem import Problem


__all__ = ["ChipMap"]

#: Altitude steps are multiples of this, in metres, so that every step decodes exactly.
_STEP_QUANTUM_M = 1 / 64
#: Significant bits of the scale of a compressed axis, which leaves 13 bits for exact multiples.
_SCALE_BITS = 40
#: Room above the highest ground: at least this, or this share of the relief if that is more.
_HEADROOM_M = 150.0
_HEADROOM_SHARE = 0.1


class ChipMap:
    """The terrain of a problem, or a box of it, on the square map of a chip.

    If the box fits, each node is a cell and the rest of the map is blocked; an axis with more
    nodes than the map has cells is compressed so that its ends lie on the map's first and last
    cells. Altitudes are counted in steps, from below the lowest ground to :attr:`top_m`, somewhat
    above the highest.

    Parameters
    ----------
    config : Config
        Sizes of the chip.
    problem : Problem
        Terrain, no-fly zones, start and goal. Under the rules of safe flight, the map has the
        raised surface of the search.
    box : (slice, slice), optional
        Rows and columns of the terrain's nodes on the map; all by default.

    Attributes
    ----------
    box : (slice, slice)
        Rows and columns of the nodes.
    origin_m : tuple of float
        Metres to cell 0 in x and y, which is the first node of the box.
    scale_m : tuple of float
        Metres per cell in x and y. For a compressed axis it is rounded down to 40 bits, so that no
        cell decodes to a point off the terrain.
    base_m, step_m : float
        Altitude of step 0, and height of a step: both are multiples of 1/64 m, so decoding is
        exact.
    limits : tuple of int
        Highest x and y cell in the box, and highest altitude step of a waypoint.
    heights : ndarray
        ``(map_size, map_size)`` uint16, [y, x], row 0 the south: the step at or above the highest
        node whose nearest cell this is. Cells without a node, voids and no-fly zones have
        ``config.blocked_altitude``.

    Raises
    ------
    InputError
        If the start or the goal lies above :attr:`top_m`.
    """

    def __init__(
        self, config: Config, problem: Problem, box: tuple[slice, slice] | None = None
    ) -> None:
        terrain = problem.surface
        self._config = config
        self._problem = problem
        rows, columns = (slice(0, nodes) for nodes in terrain.shape) if box is None else box
        self.box = rows, columns
        self.origin_m = (columns.start * terrain.dx_m, rows.start * terrain.dy_m)
        ny, nx = rows.stop - rows.start, columns.stop - columns.start
        elevation = terrain.elevation[self.box]
        size = config.map_size
        self.scale_m = (
            _scale(nx, terrain.dx_m, size),
            _scale(ny, terrain.dy_m, size),
        )
        lowest = min(float(np.nanmin(elevation)), problem.start[2], problem.goal[2])
        highest = float(np.nanmax(elevation))
        headroom_m = max(_HEADROOM_M, _HEADROOM_SHARE * (highest - lowest))
        self.base_m = float(math.floor(lowest))
        steps = config.blocked_altitude - 1
        span_m = highest + headroom_m - self.base_m
        self.step_m = math.ceil(span_m / steps / _STEP_QUANTUM_M) * _STEP_QUANTUM_M
        self.limits = (min(nx, size) - 1, min(ny, size) - 1, steps)
        for name, (_, _, z) in (("start", problem.start), ("goal", problem.goal)):
            if z > self.top_m:
                raise InputError(
                    f"The {name}'s altitude of {z:g} m is above the {self.top_m:g} m that the "
                    "chip's map can hold over this terrain; lower it."
                )

    @property
    def is_whole(self) -> bool:
        """True if the box is the whole terrain."""
        rows, columns = self.box
        whole = self._problem.terrain.shape
        return (rows.stop - rows.start, columns.stop - columns.start) == whole

    @property
    def top_m(self) -> float:
        """Highest altitude of a waypoint, metres."""
        return self.base_m + self.limits[2] * self.step_m

    def to_metres(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n, 3) metres of ``cells``, (n, 3) integers x, y, altitude step."""
        scale = np.array((*self.scale_m, self.step_m))
        metres: NDArray[np.float64] = np.asarray(cells, dtype=np.float64) * scale
        metres += (*self.origin_m, self.base_m)
        return metres

    def to_cells(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the (n, 3) cells of ``points``, (n, 3) metres within the map.

        x and y go to the nearest cell, halves up; the altitude is rounded down.

        Raises
        ------
        InputError
            If a point is outside the map, below its base or above :attr:`top_m`.
        """
        points = np.asarray(points, dtype=np.float64)
        across = np.floor((points[:, :2] - self.origin_m) / self.scale_m + 0.5)
        up = np.floor((points[:, 2:] - self.base_m) / self.step_m)
        # The difference may have been rounded up to a step that lies above the point.
        up -= self.base_m + up * self.step_m > points[:, 2:]
        cells = np.concatenate((across, up), axis=1)
        outside = ~((cells >= 0) & (cells <= self.limits)).all(axis=1)
        if outside.any():
            x, y, z = points[int(np.argmax(outside))]
            first, last = self.to_metres(np.array([(0, 0, 0), self.limits])).tolist()
            raise InputError(
                f"The point {x:g},{y:g},{z:g} is outside the chip's map, which reaches from "
                f"{first[0]:g},{first[1]:g},{first[2]:g} to {last[0]:g},{last[1]:g},{last[2]:g} m."
            )
        return cells.astype(np.int64)

    def report(self) -> dict[str, Any]:
        """Return scale, offset and padding, for the summary's ``hardware.map``."""
        size = self._config.map_size
        return {
            "size": size,
            "scale_m": [*self.scale_m, self.step_m],
            "offset_m": [*self.origin_m, self.base_m],
            "top_m": self.top_m,
            "limits": list(self.limits),
            "padding_cells": [size - 1 - self.limits[0], size - 1 - self.limits[1]],
        }

    @functools.cached_property
    def heights(self) -> NDArray[np.uint16]:
        """Altitude steps of the cells, computed when first needed."""
        size = self._config.map_size
        return self.heights_in(slice(0, size), slice(0, size))

    def heights_in(self, rows: slice, columns: slice) -> NDArray[np.uint16]:
        """Return the part of :attr:`heights` in some rows and columns of the map."""
        blocked = self._config.blocked_altitude
        heights = np.full(
            (rows.stop - rows.start, columns.stop - columns.start), blocked, dtype=np.uint16
        )
        nodes = self.nodes_of(rows, columns)
        if any(places.start >= places.stop for places in nodes):
            return heights
        # Loads numba, which compiles the kernels.
        from pathgene.host.problem.compiled.corners import cell_heights

        elevation, is_blocked = self._problem.search_part(*nodes)
        cell_heights(
            np.ascontiguousarray(elevation),
            np.ascontiguousarray(is_blocked),
            self.first_nodes_of(rows, columns),
            (self.base_m, self.step_m, blocked),
            heights,
        )
        return heights

    def nodes_of(self, rows: slice, columns: slice) -> tuple[slice, slice]:
        """Return rows and columns of the nodes whose nearest cells lie in a part of the map."""
        by_row, by_column = self._first_nodes
        (south, north), (west, east) = (
            (
                nodes.start + int(first[min(cells.start, len(first) - 1)]),
                nodes.start + int(first[min(cells.stop, len(first) - 1)]),
            )
            for nodes, first, cells in zip(
                self.box, (by_row, by_column), (rows, columns), strict=True
            )
        )
        return slice(south, north), slice(west, east)

    def first_nodes_of(
        self, rows: slice, columns: slice
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the first node of each row and column of cells of a part, and the end.

        Nodes are counted from the first of :meth:`nodes_of`. Cells without a node are left out.
        """
        by_row, by_column = (
            first[cells.start : cells.stop + 1] - first[cells.start]
            for first, cells in zip(self._first_nodes, (rows, columns), strict=True)
        )
        return by_row, by_column

    @functools.cached_property
    def _first_nodes(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First node of each row and column of cells, by nearest cell, and the end.

        Nodes are counted from the first of the box.
        """
        terrain = self._problem.terrain
        ny, nx = (nodes.stop - nodes.start for nodes in self.box)
        return (
            _first_nodes(ny, terrain.dy_m, self.scale_m[1]),
            _first_nodes(nx, terrain.dx_m, self.scale_m[0]),
        )


def _scale(nodes: int, spacing_m: float, size: int) -> float:
    if nodes <= size:
        return spacing_m
    mantissa, exponent = math.frexp((nodes - 1) * spacing_m / (size - 1))
    return math.ldexp(math.floor(math.ldexp(mantissa, _SCALE_BITS)), exponent - _SCALE_BITS)


def _first_nodes(nodes: int, spacing_m: float, scale_m: float) -> NDArray[np.int64]:
    """Return, for each cell of an axis, the first node whose nearest cell it is, and the end."""
    nearest = np.floor(np.arange(nodes) * spacing_m / scale_m + 0.5).astype(np.int64)
    return np.append(np.flatnonzero(np.diff(nearest, prepend=-1)), nodes)
