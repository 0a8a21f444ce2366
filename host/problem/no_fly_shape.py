"""A no-fly zone as the shape that the planner core draws on its map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from pathgene.hdl.protocol.planner import BEND_BITS, EDGE_BITS, EDGES, NoFlyShape
from pathgene.host.problem.compiled.corners import extent, least_values
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.zones import Zone


__all__ = ["no_fly_shape"]

_MOST_BEND = (1 << BEND_BITS) - 1
_MOST_FALL = (1 << EDGE_BITS - 1) - 1


def no_fly_shape(
    grid: CornerMap, zone: Zone, inside: NDArray[np.bool_] | None = None
) -> NoFlyShape | None:
    """Return a shape that contains every corner of ``grid`` with a neighbouring cell in ``zone``.

    The margin of the rules belongs to the zone; its heights and times are ignored. The shape is a
    disc for a circle, and for a polygon the convex hull of these corners, reduced to 8 edges if the
    hull has more. It is None if there is no such corner. ``inside`` are these corners in the part
    :meth:`CornerMap.around_zone` of the map, if they are known.
    """
    rows, columns = grid.around_zone(zone)
    if inside is None:
        inside = grid.beside(zone, rows, columns)
    west, south, east, north = extent(inside)
    if east < west:
        return None
    bend = 0, 0
    if zone.footprint.disc is not None:
        # Squared distance from the centre, (u - centre)**2, each axis in units of its cell side.
        centre = [
            (at - origin_m) / side_m - 0.5 - (first + place)
            for at, origin_m, side_m, first, place in zip(
                zone.footprint.disc[:2],
                grid.origin_m,
                grid.scale_m,
                (columns.start, rows.start),
                (west, south),
                strict=True,
            )
        ]
        widest_m = max(grid.scale_m)
        weights = [(side_m / widest_m) * (side_m / widest_m) for side_m in grid.scale_m]
        farthest = max(abs(weight * at) for weight, at in zip(weights, centre, strict=True))
        scale = min(_MOST_BEND, _MOST_FALL / (2 * max(farthest, 1e-9)))
        bend = max(round(scale * weights[0]), 1), max(round(scale * weights[1]), 1)
        falls = np.array(
            [
                [
                    min(max(round(2 * each * at), -_MOST_FALL), _MOST_FALL)
                    for each, at in zip(bend, centre, strict=True)
                ]
            ],
            dtype=np.int64,
        )
    else:
        y, x = np.nonzero(inside)
        falls = _inward(np.column_stack((x - west, y - south)))
    # Every corner of the zone is on the inner side; the outermost is just inside.
    least = np.full(len(falls), np.iinfo(np.int64).max)
    least_values(inside, (west, south), falls, bend, least)
    return NoFlyShape(
        first_x=columns.start + west,
        first_y=rows.start + south,
        last_x=columns.start + east,
        last_y=rows.start + north,
        edges=tuple(
            (-low, east, north)
            for low, (east, north) in zip(least.tolist(), falls.tolist(), strict=True)
        ),
        bend_x=bend[0],
        bend_y=bend[1],
    )


def _inward(places: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the inward normals, as falls, of edges of the hull of ``places``, (n, 2).

    At most 8 edges are chosen greedily: each excludes the most remaining corners of the box.
    """
    if not np.ptp(places, axis=0).all():
        # A row of corners is a box.
        return np.empty((0, 2), dtype=np.int64)
    hull = places[ConvexHull(places).vertices]
    along = np.roll(hull, -1, axis=0) - hull
    # The vertices of the hull go round to the left.
    inward = np.column_stack((-along[:, 1], along[:, 0]))
    longest = np.abs(inward).max(axis=1, keepdims=True)
    falls: NDArray[np.int64] = np.rint(inward / longest * _MOST_FALL).astype(np.int64)
    box = np.indices(places.max(axis=0) + 1).reshape(2, -1).T
    is_outside = box @ falls.T < (places @ falls.T).min(axis=0)
    chosen: list[int] = []
    while len(chosen) < EDGES and is_outside.any():
        chosen.append(int(is_outside.sum(axis=0).argmax()))
        is_outside &= ~is_outside[:, chosen[-1:]]
    return falls[chosen]
