"""Compiled collision check of whole batches of paths.

The integers are the same as in :func:`pathgene.sim.model.checker.check_path`, but without a
division per cell: x and y advance by the remainders of their sides (*Bresenham*), the altitude by
its rise times the length.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.model.checker import Heights, Point, TerrainModel, Verdict, check_points
from pathgene.sim.model.compiled import compiled


__all__ = ["Batch", "Verdicts", "check_batch", "check_paths"]

Integers = npt.NDArray[np.int64]

#: Columns of the kernel's verdicts.
_COLLISION, _SEGMENT, _X, _Y, _COARSE, _CELLS = range(6)
#: A segment number that no segment reaches.
_NEVER = np.iinfo(np.int64).max


@dataclass(frozen=True)
class Batch:
    """Concatenated paths.

    Parameters
    ----------
    points : ndarray
        ``(points, 3)`` int64: x, y, altitude step. All must be on the map; this is not checked.
    bounds : ndarray
        ``(paths + 1,)`` int64: first point of each path, and end of the last one. Each path has two
        or more points.
    """

    points: Integers
    bounds: Integers

    @classmethod
    def of(cls, config: Config, paths: Iterable[Sequence[Point]]) -> Batch:
        """Return the batch of ``paths``.

        Raises
        ------
        ValueError
            If one of them is not a path of ``config``: see
            :func:`pathgene.sim.model.checker.check_points`.
        """
        listed = [np.asarray(path, dtype=np.int64) for path in paths]
        for path in listed:
            check_points(config, path.tolist())
        empty = np.empty((0, 3), dtype=np.int64)
        bounds = np.cumsum([0, *map(len, listed)], dtype=np.int64)
        return cls(np.concatenate([empty, *listed]), bounds)

    def __len__(self) -> int:
        return len(self.bounds) - 1


@dataclass(frozen=True)
class Verdicts:
    """Verdicts on the paths of a batch: the members of :class:`Verdict`, one row per path.

    Attributes
    ----------
    collision, coarse : ndarray of bool
    segment, x, y, cells : ndarray of int64
    colliding : ndarray of int64, or None
        ``(segments, 2)``: colliding cells of terrain and blocked cells of every segment of the
        batch, path after path; None unless they were counted.
    """

    collision: npt.NDArray[np.bool_]
    segment: Integers
    x: Integers
    y: Integers
    coarse: npt.NDArray[np.bool_]
    cells: Integers
    colliding: Integers | None


def check_batch(
    config: Config, terrain: TerrainModel, batch: Batch, count: bool = False
) -> Verdicts:
    """Check every path of a batch, as :func:`pathgene.sim.model.checker.check_path` does.

    Raises
    ------
    ValueError
        If ``config`` has no checker.
    """
    if config.checker is CheckerBuild.NONE:
        raise ValueError(f"Config.checker must name a build, not {config.checker.value!r}")
    is_tiered = config.checker is CheckerBuild.TWO_TIER
    found = np.zeros((len(batch), 6), dtype=np.int64)
    segments = len(batch.points) - len(batch) if count else 0
    colliding = np.zeros((segments, 2), dtype=np.int64)
    _check(
        terrain.heights,
        terrain.coarse,
        (config.coarse_factor - 1).bit_length(),
        config.DETAILED_SEGMENTS if is_tiered else _NEVER,
        config.blocked_altitude,
        count,
        batch.points,
        batch.bounds,
        found,
        colliding,
    )
    return Verdicts(
        collision=found[:, _COLLISION] != 0,
        segment=found[:, _SEGMENT],
        x=found[:, _X],
        y=found[:, _Y],
        coarse=found[:, _COARSE] != 0,
        cells=found[:, _CELLS],
        colliding=colliding if count else None,
    )


def check_paths(
    config: Config, terrain: TerrainModel, paths: Sequence[Sequence[Point]], count: bool = False
) -> list[Verdict]:
    """Return the verdict of :func:`pathgene.sim.model.checker.check_path` on each of ``paths``.

    Raises
    ------
    ValueError
        If ``config`` has no checker, or a path has too few or too many points, or one off the map.
    """
    batch = Batch.of(config, paths)
    found = check_batch(config, terrain, batch, count)
    verdicts = []
    for path in range(len(batch)):
        collision = bool(found.collision[path])
        entries: tuple[tuple[int, int, int], ...] = ()
        if found.colliding is not None:
            # Each path, including the earlier ones, has one segment fewer than points.
            rows = found.colliding[batch.bounds[path] - path : batch.bounds[path + 1] - path - 1]
            entries = tuple(
                (segment, int(below), int(inside))
                for segment, (below, inside) in enumerate(rows)
                if below or inside
            )
        verdicts.append(
            Verdict(
                collision=collision,
                clear=not collision,
                segment=int(found.segment[path]),
                x=int(found.x[path]),
                y=int(found.y[path]),
                coarse=bool(found.coarse[path]),
                cells=int(found.cells[path]),
                entries=entries,
            )
        )
    return verdicts


@compiled
def _check(
    heights: Heights,
    maxima: Heights,
    coarse_shift: int,
    detailed_segments: int,
    blocked: int,
    count: bool,
    points: Integers,
    bounds: Integers,
    found: Integers,
    colliding: Integers,
) -> None:
    """Fill a row of ``found`` for each path, and one of ``colliding`` for each segment."""
    for path in range(len(bounds) - 1):
        first = bounds[path]
        verdict = found[path]
        for at in range(first, bounds[path + 1] - 1):
            segment = at - first
            ground, shift = heights, 0
            if segment >= detailed_segments:
                ground, shift = maxima, coarse_shift
            x, y, z = points[at, 0] >> shift, points[at, 1] >> shift, points[at, 2]
            dx = (points[at + 1, 0] >> shift) - x
            dy = (points[at + 1, 1] >> shift) - y
            dz = points[at + 1, 2] - z
            length = max(abs(dx), abs(dy))
            if length == 0:
                z, dz = min(z, z + dz), 0
            # Altitudes are multiples of 1/scale; the remainders of x and y, of 1/(2 scale).
            scale = max(length, 1)
            altitude = z * scale
            across = along = scale
            for _ in range(length + 1):
                if not verdict[_COLLISION]:
                    verdict[_CELLS] += 1
                height = np.int64(ground[y, x])
                if altitude <= height * scale:
                    if not verdict[_COLLISION]:
                        verdict[_COLLISION] = 1
                        verdict[_SEGMENT], verdict[_X], verdict[_Y] = segment, x, y
                        verdict[_COARSE] = segment >= detailed_segments
                    if not count:
                        break
                    colliding[at - path, 1 if height == blocked else 0] += 1
                altitude += dz
                across += 2 * dx
                along += 2 * dy
                # Neither moves by more than one cell at a time.
                if across >= 2 * scale:
                    across -= 2 * scale
                    x += 1
                elif across < 0:
                    across += 2 * scale
                    x -= 1
                if along >= 2 * scale:
                    along -= 2 * scale
                    y += 1
                elif along < 0:
                    along += 2 * scale
                    y -= 1
            if verdict[_COLLISION] and not count:
                break
