"""Definition of the collision check of *allaire two-tier*, which every build must reproduce.

It goes cell by cell and is written for readability. :mod:`pathgene.sim.model.checker_kernels` gives
the same verdicts on thousands of paths at once.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from pathgene.hdl.config import CheckerBuild, Config


__all__ = [
    "Heights",
    "Point",
    "TerrainModel",
    "Verdict",
    "check_path",
    "check_points",
    "paper_cycles",
    "segment_cells",
    "to_coarse",
    "walk",
]

Heights = npt.NDArray[np.uint16]
#: x and y in cells, and the altitude in steps.
Point = tuple[int, int, int]

#: Cycles of the paper's circuit (table 2): to capture a path, and between two segments.
_CAPTURE_CYCLES = 4
_SWITCH_CYCLES = 3


class TerrainModel:
    """The ground on the chip: the detailed map, and the highest cell of each of its blocks.

    The chip's memory is undefined until it has been written. Here every cell is initially blocked,
    so that no path can cross cells that were not uploaded.

    Attributes
    ----------
    heights : ndarray
        ``(map_size, map_size)`` uint16 altitude steps, [y, x], row 0 the south; read only.
    coarse : ndarray
        Maxima of blocks of ``coarse_factor`` x ``coarse_factor`` cells, with the same type and
        axes.
    observer : callable, optional
        Called with x, y, columns and rows of each rectangle after it is written.
    """

    observer: Callable[[int, int, int, int], object] | None = None

    def __init__(self, config: Config) -> None:
        self._config = config
        self._factor = config.coarse_factor
        edge = config.map_size
        self._heights = np.full((edge, edge), config.blocked_altitude, dtype=np.uint16)
        edge //= self._factor
        self._coarse = np.full((edge, edge), config.blocked_altitude, dtype=np.uint16)
        self.heights = _read_only(self._heights)
        self.coarse = _read_only(self._coarse)

    def write(self, x: int, y: int, block: npt.ArrayLike) -> None:
        """Write a rectangle of altitudes, ``(rows, columns)``, whose south-west cell is (x, y).

        Raises
        ------
        ValueError
            If ``block`` is empty, does not have two axes, contains numbers that are not integers or
            not altitudes, or leaves the map.
        """
        cells = np.asarray(block)
        if cells.ndim != 2 or cells.size == 0 or not np.issubdtype(cells.dtype, np.integer):
            raise ValueError(
                f"A block must be a filled array of two axes of integers, not of shape "
                f"{cells.shape} of {cells.dtype}"
            )
        rows, columns = cells.shape
        edge, top = self._config.map_size, self._config.blocked_altitude
        if not (0 <= x <= edge - columns and 0 <= y <= edge - rows):
            raise ValueError(
                f"A block must lie within 0..{edge - 1}, not {columns} x {rows} cells at ({x}, {y})"
            )
        if cells.min() < 0 or cells.max() > top:
            raise ValueError(
                f"An altitude must be from 0 to {top}, not {cells.min()} to {cells.max()}"
            )
        self._heights[y : y + rows, x : x + columns] = cells
        self._renew_coarse(x, y, columns, rows)
        if self.observer is not None:
            self.observer(x, y, columns, rows)

    def block(self, x: int, y: int, shape: npt.NDArray[np.bool_]) -> None:
        """Block the cells of a rectangle, ``(rows, columns)``, that are true in ``shape``."""
        rows, columns = shape.shape
        self._heights[y : y + rows, x : x + columns][shape] = self._config.blocked_altitude
        self._renew_coarse(x, y, columns, rows)

    def _renew_coarse(self, x: int, y: int, columns: int, rows: int) -> None:
        # Whole blocks, so that a maximum can decrease with its cell.
        factor = self._factor
        south, west = y // factor, x // factor
        north, east = (y + rows - 1) // factor + 1, (x + columns - 1) // factor + 1
        touched = self._heights[south * factor : north * factor, west * factor : east * factor]
        blocks = touched.reshape(north - south, factor, east - west, factor)
        self._coarse[south:north, west:east] = blocks.max(axis=(1, 3))


@dataclass(frozen=True)
class Verdict:
    """Verdict on one path.

    Attributes
    ----------
    clear : bool
        The opposite of ``collision``, because every check ends: the paper's flag "over".
    segment : int
        First colliding segment; 0 is the segment from the aircraft, and also means that none
        collides.
    x, y : int
        First colliding cell of that segment, in cells of its map; 0 if none collides.
    coarse : bool
        True if that map is the coarse map.
    cells : int
        Number of cells from the path's first to the colliding cell, including both, or of the whole
        path. Both end cells of every segment count. Counting colliding cells does not change this.
    entries : tuple of (int, int, int)
        For each segment with colliding cells, in order: its number, and its numbers of colliding
        cells of terrain and of blocked ground. Empty unless they are counted.
    """

    collision: bool
    clear: bool
    segment: int
    x: int
    y: int
    coarse: bool
    cells: int
    entries: tuple[tuple[int, int, int], ...] = ()


def segment_cells(start: Point, stop: Point) -> int:
    """Return how many cells a segment has: one more than its longer side."""
    return max(abs(stop[0] - start[0]), abs(stop[1] - start[1])) + 1


def walk(start: Point, stop: Point) -> Iterator[tuple[int, int, Fraction]]:
    """Yield x, y and the exact altitude of every cell of a segment, from its start to its stop.

    Cell k of n = ``segment_cells(start, stop) - 1`` lies k/n of the way; halves are rounded up. A
    segment and its reverse may therefore have different cells. A segment within one cell has the
    altitude of its lower end.
    """
    (x, y, z), n = start, segment_cells(start, stop) - 1
    dx, dy, dz = stop[0] - x, stop[1] - y, stop[2] - z
    if n == 0:
        yield x, y, Fraction(min(z, z + dz))
        return
    for k in range(n + 1):
        across, along = (2 * k * dx + n) // (2 * n), (2 * k * dy + n) // (2 * n)
        yield x + across, y + along, z + Fraction(k * dz, n)


def to_coarse(config: Config, point: Point) -> Point:
    """Return the coarse cell that a point lies in, at the point's own altitude."""
    x, y, z = point
    return x // config.coarse_factor, y // config.coarse_factor, z


def check_points(config: Config, points: Sequence[Sequence[int]]) -> None:
    """Refuse ``points`` that are not a path of ``config``: at least aircraft and goal.

    Raises
    ------
    ValueError
        If there are too few or too many points, or one of them is off the map.
    """
    most = config.max_waypoints + 2
    if not 2 <= len(points) <= most:
        raise ValueError(f"A path must have from 2 to {most} points, not {len(points)}")
    edge, top = config.map_size - 1, config.blocked_altitude
    for x, y, z in points:
        if not (0 <= x <= edge and 0 <= y <= edge and 0 <= z <= top):
            raise ValueError(
                f"A point must lie within 0..{edge}, 0..{edge}, 0..{top}, not ({x}, {y}, {z})"
            )


def check_path(
    config: Config, terrain: TerrainModel, points: Sequence[Point], count: bool = False
) -> Verdict:
    """Check a path against the ground, as the build named by ``config.checker`` does.

    The two-tier build compares all segments after the first two with the coarse map; their ends
    then have coarse cells and their own altitudes. The parallel build compares every segment with
    the detailed map. A cell collides if the path is not above its ground.

    Parameters
    ----------
    points : sequence of (int, int, int)
        Aircraft, waypoints, goal: cells and altitude steps.
    count : bool
        Walk the whole path and count colliding cells, instead of stopping at the first.

    Raises
    ------
    ValueError
        If ``config`` has no checker, or ``points`` is not a path of it: see :func:`check_points`.
    """
    if config.checker is CheckerBuild.NONE:
        raise ValueError(f"Config.checker must name a build, not {config.checker.value!r}")
    check_points(config, points)
    first: tuple[int, int, int, bool] | None = None
    cells = 0
    entries = []
    for segment, (start, stop) in enumerate(itertools.pairwise(points)):
        coarse = config.checker is CheckerBuild.TWO_TIER and segment >= config.DETAILED_SEGMENTS
        ground = terrain.heights
        if coarse:
            ground = terrain.coarse
            start, stop = to_coarse(config, start), to_coarse(config, stop)
        below_terrain = in_nofly = 0
        for x, y, altitude in walk(start, stop):
            if first is None:
                cells += 1
            height = int(ground[y, x])
            if altitude > height:
                continue
            first = first or (segment, x, y, coarse)
            if not count:
                return Verdict(True, False, *first, cells)
            if height == config.blocked_altitude:
                in_nofly += 1
            else:
                below_terrain += 1
        if below_terrain or in_nofly:
            entries.append((segment, below_terrain, in_nofly))
    if first is None:
        return Verdict(False, True, 0, 0, 0, False, cells)
    return Verdict(True, False, *first, cells, tuple(entries))


def paper_cycles(cells: int, segments: int) -> int:
    """Return the cycles of the paper's circuit for a path (*allaire two-tier*, table 2).

    There are four to capture the path, one for each cell, and three between two segments. The
    table's three for the return to idle are not part of its total, and are left out here.

    Parameters
    ----------
    cells : int
        Cells compared: :attr:`Verdict.cells`.
    """
    return _CAPTURE_CYCLES + cells + _SWITCH_CYCLES * (segments - 1)


def _read_only(array: Heights) -> Heights:
    view = array.view()
    view.flags.writeable = False
    return view
