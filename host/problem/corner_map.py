"""The terrain on the lattice of corners of the planner core."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.ends import Point
from pathgene.host.problem.finer import finer, on_grid
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zone_raster import blocked_cells
from pathgene.host.problem.zones import Zone


__all__ = ["EASES", "CornerMap", "Ease"]


class Ease(NamedTuple):
    """A rule that lowers corners around start and goal.

    It applies to corners up to ``corners`` from the end in x and y. Each is lowered to the end's
    altitude or to the mean of its cells plus a ``share`` of the excess of the highest cell over the
    mean, whichever is higher.
    """

    corners: int
    share: float


#: Rules for lowering; the first one only lowers the end's own corner.
EASES = {-1: Ease(0, 1.0), 0: Ease(1, 0.5), 1: Ease(2, 0.25), 2: Ease(3, 0.0)}


class CornerMap(ChipMap):
    """A :class:`ChipMap` whose waypoints lie on the corners between cells.

    Corner (i, j) is the corner between the cells i and i + 1 in x, and j and j + 1 in y. A segment
    between corners, rounded to a corner in every step along its longer axis, stays in the four
    cells around these corners, so the chip only needs the highest of the four.

    Parameters
    ----------
    config, problem, box
        As for a :class:`ChipMap`; the box has rows and columns of the smaller nodes.
    parts : int
        Number of parts into which the sides of the terrain's cells are divided: waypoints lie on a
        finer lattice, and gaps that are as narrow as a cell of the terrain stay open.
    """

    def __init__(
        self,
        config: Config,
        problem: Problem,
        box: tuple[slice, slice] | None = None,
        parts: int = 1,
    ) -> None:
        super().__init__(config, finer(problem, parts), box)
        self._is_finer = parts > 1

    def corners(self, ends: Iterable[Point] = (), ease: int = 0) -> NDArray[np.uint16]:
        """Highest of the four cells around each corner, ``(map_size, map_size)`` uint16, [y, x].

        The last row and column, which have no cell beyond them, are blocked.

        Under a clearance, an end lies at the raised surface or hardly above it, so that no path
        could leave it. Therefore the corner nearest to each of ``ends`` is no higher than the end,
        and further corners around it are lowered, more for a greater ``ease``: see :data:`EASES`. A
        blocked cell still counts. The strict rule judges paths by the true surface.
        """
        whole = slice(0, self._config.map_size)
        return self._corners_of(self.heights, whole, whole, ends, ease)

    def corners_in(
        self, rows: slice, columns: slice, ends: Iterable[Point] = (), ease: int = 0
    ) -> NDArray[np.uint16]:
        """Return the part of :meth:`corners` in some rows and columns, from the cells there."""
        size = self._config.map_size
        cells = self.heights_in(
            *(slice(part.start, min(part.stop + 1, size)) for part in (rows, columns))
        )
        return self._corners_of(cells, rows, columns, ends, ease)

    def _corners_of(
        self,
        cells: NDArray[np.uint16],
        rows: slice,
        columns: slice,
        ends: Iterable[Point],
        ease: int,
    ) -> NDArray[np.uint16]:
        """Return the corners of a part; ``cells`` has one more row and column if there is one."""
        corners = np.full(
            (rows.stop - rows.start, columns.stop - columns.start),
            self._config.blocked_altitude,
            dtype=np.uint16,
        )
        # Loads numba, which compiles the kernels.
        from pathgene.host.problem.compiled.corners import corners_of_cells

        corners_of_cells(cells, corners)
        for end in ends:
            self._lower_around(end, EASES[ease], corners, cells, rows, columns)
        return corners

    def _lower_around(
        self,
        end: Point,
        ease: Ease,
        corners: NDArray[np.uint16],
        cells: NDArray[np.uint16],
        rows: slice,
        columns: slice,
    ) -> None:
        from pathgene.host.problem.compiled.corners import lower_corners

        x, y, altitude = self.nearest_corner(end)
        near_rows, near_columns = self._near(end, ease.corners)
        south, west = rows.start, columns.start
        lower_corners(
            corners,
            cells,
            (
                max(near_rows.start - south, 0),
                min(near_rows.stop, rows.stop) - south,
                max(near_columns.start - west, 0),
                min(near_columns.stop, columns.stop) - west,
            ),
            (x - west, y - south, altitude),
            ease.share,
            self._config.blocked_altitude,
        )

    def around(self, end: Point) -> tuple[slice, slice]:
        """Return rows and columns of the corners around an end that easing may lower."""
        return self._near(end, max(ease.corners for ease in EASES.values()))

    def _near(self, end: Point, far: int) -> tuple[slice, slice]:
        """Return rows and columns of the corners up to ``far`` from an end in x and y."""
        x, y, _ = self.nearest_corner(end)
        columns, rows, _ = self.corner_limits
        return (
            slice(max(y - far, 0), min(y + far, rows) + 1),
            slice(max(x - far, 0), min(x + far, columns) + 1),
        )

    def of_problem(self, problem: Problem) -> CornerMap | None:
        """Return the map of another problem over the same terrain, on the same corners and steps.

        None if its start or goal lies outside the box, or its altitude not on these steps.
        """
        (west, south), (east, north) = self.origin_m, self._far_m
        for x, y, z in (problem.start, problem.goal):
            is_inside = west <= x <= east and south <= y <= north
            if not (is_inside and self.base_m <= z <= self.top_m):
                return None
        moved = copy.copy(self)
        # The same grid; its division takes milliseconds.
        moved._problem = on_grid(problem, self._problem.terrain) if self._is_finer else problem
        moved.__dict__.pop("heights", None)
        return moved

    def place(self, point: Point) -> tuple[int, int, int]:
        """Return a point on the lattice in the form of a problem's record.

        x and y have :data:`~pathgene.hdl.protocol.planner.POSITION_FRACTION` bits below the cell,
        the altitude :data:`~pathgene.hdl.protocol.planner.ALTITUDE_FRACTION` below the step. A
        point outside the first or last corner is clamped to it.
        """
        places = []
        for metres, origin_m, scale_m, limit in zip(
            point[:2], self.origin_m, self.scale_m, self.corner_limits[:2], strict=True
        ):
            place = round(((metres - origin_m) / scale_m - 0.5) * (1 << POSITION_FRACTION))
            places.append(min(max(place, 0), limit << POSITION_FRACTION))
        steps = (point[2] - self.base_m) / self.step_m
        return places[0], places[1], math.floor(steps * (1 << ALTITUDE_FRACTION))

    def nearest_corner(self, point: Point) -> tuple[int, int, int]:
        """Return the corner nearest to a point, and the step at or below it."""
        x, y, altitude = self.place(point)
        half = 1 << POSITION_FRACTION - 1
        columns, rows, _ = self.corner_limits
        return (
            min(x + half >> POSITION_FRACTION, columns),
            min(y + half >> POSITION_FRACTION, rows),
            altitude >> ALTITUDE_FRACTION,
        )

    def around_zone(self, zone: Zone) -> tuple[slice, slice]:
        """Return rows and columns of a part of the map that has all corners around a zone."""
        west, south, east, north = zone.footprint.box
        margin_m = self._margin_m
        (first_x, last_x), (first_y, last_y) = (
            (
                min(max(math.floor((low - origin_m - margin_m) / scale_m) - 2, 0), limit),
                min(max(math.ceil((high - origin_m + margin_m) / scale_m) + 2, 0), limit),
            )
            for low, high, origin_m, scale_m, limit in zip(
                (west, south),
                (east, north),
                self.origin_m,
                self.scale_m,
                self.corner_limits[:2],
                strict=True,
            )
        )
        return slice(first_y, last_y + 1), slice(first_x, last_x + 1)

    def beside(self, zone: Zone, rows: slice, columns: slice) -> NDArray[np.bool_]:
        """Return the corners around which a cell meets a zone or its margin, in a part of the map.

        Heights and times of the zone are ignored.
        """
        from pathgene.host.problem.compiled.corners import mark_beside

        wide = slice(rows.start, rows.stop + 1), slice(columns.start, columns.stop + 1)
        nodes = self.nodes_of(*wide)
        blocked = blocked_cells([zone], self._problem.terrain, self._margin_m, nodes)
        corners = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=bool)
        mark_beside(blocked, self.first_nodes_of(*wide), corners)
        return corners

    @property
    def corner_limits(self) -> tuple[int, int, int]:
        """Highest x and y corner between cells of the terrain, and highest step of a waypoint.

        No waypoint is above the ceiling.
        """
        x, y, altitude = self.limits
        below = (self._problem.limits.ceiling_m - self.base_m) / self.step_m
        if below < altitude:
            altitude = max(math.floor(below), 0)
        return max(x - 1, 0), max(y - 1, 0), altitude

    def report(self) -> dict[str, Any]:
        """Return scale, offset and padding of the corners, for the summary's ``hardware.map``."""
        x, y, altitude = self.corner_limits
        size = self._config.map_size
        return super().report() | {
            "offset_m": self.corners_to_metres(np.zeros((1, 3), dtype=np.int64))[0].tolist(),
            "limits": [x, y, altitude],
            "padding_cells": [size - 1 - x, size - 1 - y],
        }

    def corners_to_metres(self, corners: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n, 3) metres of (n, 3) integers x, y, altitude step."""
        half = 0.5 * np.array((*self.scale_m, 0.0))
        metres: NDArray[np.float64] = self.to_metres(corners) + half
        return metres

    @property
    def _far_m(self) -> tuple[float, float]:
        """Metres to the last node of the box in x and y."""
        terrain, (rows, columns) = self._problem.terrain, self.box
        return (columns.stop - 1) * terrain.dx_m, (rows.stop - 1) * terrain.dy_m

    @property
    def _margin_m(self) -> float:
        rules = self._problem.rules
        return 0.0 if rules is None else rules.zone_margin_m
