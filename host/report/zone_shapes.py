"""Shapes and texts of no-fly zones in a picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle as CirclePatch
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

from pathgene.host.problem.rings import edges
from pathgene.host.problem.zones import Zone
from pathgene.host.report.style import NOFLY


__all__ = ["MANY", "crossed", "draw_margin", "outline", "outline_of_all", "text"]

Floats = NDArray[np.float64]

#: If there are more zones, they are drawn together, without margins and texts, which take
#: milliseconds each and hide the map.
MANY = 200

# Number of points of a track that are compared with the boxes of zones together.
_STRETCH = 128

# Nodes along the longer side of a polygon with its margin: a node is a few pixels.
_NODES = 256


def outline(zone: Zone, unit_m: float) -> CirclePatch | PathPatch:
    """Return the patch of a zone on axes of ``unit_m`` metres per unit."""
    if zone.footprint.disc is not None:
        x, y, radius = (value / unit_m for value in zone.footprint.disc)
        return CirclePatch((x, y), radius, linewidth=1.6, **_style())
    return PathPatch(_path(zone, unit_m), linewidth=1.6, **_style())


def outline_of_all(zones: Sequence[Zone], unit_m: float) -> PathPatch:
    """Return one patch of many zones, with finer lines."""
    circles = [zone.footprint.disc for zone in zones if zone.footprint.disc is not None]
    paths = [_path(zone, unit_m) for zone in zones if zone.footprint.rings]
    if circles:
        unit, around = Outline.unit_circle(), np.array(circles)[:, None] / unit_m
        corners = around[..., :2] + around[..., 2:] * np.asarray(unit.vertices)
        assert unit.codes is not None
        paths.append(Outline(corners.reshape(-1, 2), np.tile(unit.codes, len(circles))))
    return PathPatch(Outline.make_compound_path(*paths), linewidth=0.6, **_style())


def _style() -> dict[str, Any]:
    return {
        "facecolor": (*to_rgb(NOFLY), 0.28),
        "edgecolor": NOFLY,
        "hatch": "///",
        "zorder": 4,
    }


def _path(zone: Zone, unit_m: float) -> Outline:
    """Return the outline of a polygon."""
    corners: list[tuple[float, float]] = []
    codes: list[Any] = []
    # The rings have opposite directions, so that holes are neither filled nor hatched.
    for ring in zone.footprint.wound_rings:
        corners += [(x / unit_m, y / unit_m) for x, y in (*ring, ring[0])]
        codes += [Outline.MOVETO, *[Outline.LINETO] * (len(ring) - 1), Outline.CLOSEPOLY]
    return Outline(corners, codes)


def draw_margin(axes: Axes, zone: Zone, margin_m: float, unit_m: float) -> None:
    """Draw the line around a zone that no path may cross.

    Parameters
    ----------
    axes : Axes
        Axes of ``unit_m`` metres per unit, with fixed limits.
    margin_m : float
        Distance of the line from the zone, more than 0.
    unit_m : float
        Metres per unit of the axes.
    """
    if zone.footprint.disc is not None:
        x_m, y_m, radius_m = zone.footprint.disc
        around = (x_m / unit_m, y_m / unit_m), (radius_m + margin_m) / unit_m
        axes.add_patch(CirclePatch(*around, fill=False, edgecolor=NOFLY, linewidth=0.7, zorder=4))
        return
    x, y, distance = _distances(zone, margin_m)
    axes.contour(
        x / unit_m,
        y / unit_m,
        distance,
        levels=[margin_m],
        colors=NOFLY,
        linewidths=0.7,
        zorder=4,
    )


def _distances(zone: Zone, margin_m: float) -> tuple[Floats, Floats, Floats]:
    """Return the distance of nodes from a polygon, exact near the margin.

    Returns
    -------
    tuple of ndarray
        Columns (nx,), rows (ny,), and the distances (ny, nx), negative inside; all float64 metres.
    """
    box = np.array(zone.footprint.box)
    low, high = box[:2] - 2 * margin_m, box[2:] + 2 * margin_m
    cell_m = float((high - low).max()) / _NODES
    x, y = (np.arange(a, b + 2 * cell_m, cell_m) for a, b in zip(low, high, strict=True))
    # Distances farther away are not needed.
    reach_m = margin_m + 3 * cell_m
    distance = np.full((len(y), len(x)), reach_m)
    for ring in zone.footprint.rings:
        for x0, y0, x1, y1 in edges(ring):
            columns = slice(*np.searchsorted(x, (min(x0, x1) - reach_m, max(x0, x1) + reach_m)))
            rows = slice(*np.searchsorted(y, (min(y0, y1) - reach_m, max(y0, y1) + reach_m)))
            east, north = x[None, columns] - x0, y[rows, None] - y0
            dx, dy = x1 - x0, y1 - y0
            square = dx * dx + dy * dy
            along = np.clip((east * dx + north * dy) / (square or 1.0), 0, 1)
            near = np.hypot(east - along * dx, north - along * dy)
            distance[rows, columns] = np.minimum(distance[rows, columns], near)
    return x, y, np.where(zone.covers(x, y), -distance, distance)


def text(zone: Zone) -> str:
    """Name, heights and times of a zone, each on its own line."""
    lines = [zone.name] if zone.name else []
    above, below = _height(zone.lower_m, zone.lower_agl_m), _height(zone.upper_m, zone.upper_agl_m)
    if above[1] == below[1]:
        above = (above[0], "")
    t0, t1 = (None if at is None else f"{at:g}" for at in (zone.t0_s, zone.t1_s))
    for (low, own), (high, unit) in ((above, below), ((t0, ""), (t1, " s"))):
        if low is not None and high is not None:
            lines.append(f"{low}{own} to {high}{unit}")
        elif low is not None:
            lines.append(f"from {low}{own or unit}")
        elif high is not None:
            lines.append(f"to {high}{unit}")
    return "\n".join(lines)


def _height(metres: float | None, agl_m: float | None) -> tuple[str | None, str]:
    """Return the number and the unit of a limit."""
    if agl_m is not None:
        return f"{agl_m:g}", " m AGL"
    return None if metres is None else f"{metres:g}", " m"


def crossed(
    zones: Sequence[Zone], x: Floats, y: Floats
) -> Iterator[tuple[Zone, NDArray[np.bool_]]]:
    """Yield the zones whose outline a track enters, each with the points that are inside.

    Parameters
    ----------
    zones : sequence of Zone
        The zones, in the order in which they are yielded.
    x, y : ndarray
        Points of the track in flying order, (k,) float64 metres.

    Yields
    ------
    Zone, ndarray
        The zone, and whether each point is within its outline, (k,) bool.
    """
    if not zones:
        return
    # Usually few zones are near the track, and their boxes show that quickly.
    boxes = np.array([zone.footprint.box for zone in zones])
    lows, highs = boxes[:, :2], boxes[:, 2:]
    near = np.ones((len(zones), -(-len(x) // _STRETCH)), dtype=bool)
    for axis, places in enumerate((x, y)):
        first = np.arange(0, len(x), _STRETCH)
        near &= lows[:, axis, None] <= np.maximum.reduceat(places, first)
        near &= highs[:, axis, None] >= np.minimum.reduceat(places, first)
    for at in np.flatnonzero(near.any(axis=1)).tolist():
        inside = _covers(zones[at], x, y)
        if inside.any():
            yield zones[at], inside


def _covers(zone: Zone, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which points are within the outline of a zone, as it is drawn."""
    if not zone.footprint.rings:
        return zone.footprint.contains(x, y)
    inside = np.zeros(len(x), dtype=bool)
    for ring in zone.footprint.rings:
        inside ^= Outline(ring).contains_points(np.stack((x, y), axis=1))
    return inside
