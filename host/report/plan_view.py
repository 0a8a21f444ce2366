"""The plan view of the picture: land, zones, path, scale and arrows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, Normalize, to_rgb, to_rgba
from matplotlib.lines import Line2D
from matplotlib.offsetbox import (
    AnchoredOffsetbox,
    AuxTransformBox,
    DrawingArea,
    HPacker,
    TextArea,
    VPacker,
)
from matplotlib.patches import FancyArrow, Patch, Rectangle
from matplotlib.patches import Polygon as Triangle
from numpy.typing import NDArray

from pathgene.host.evaluation import Samples
from pathgene.host.problem.tiles import wholes
from pathgene.host.report import points, zone_shapes
from pathgene.host.report.placing import label
from pathgene.host.report.style import LAND, NOFLY, PATH, TEXT, TROUBLE, VOID, halo


if TYPE_CHECKING:
    from pathgene.host.problem.problem import Problem
    from pathgene.host.terrain import Terrain

__all__ = ["axis_unit", "draw", "draw_reason", "nice_length", "window_around"]

_LARGEST_RASTER = 1600  # Maximum nodes per side that a picture of this size can show.
# Places of scale and north arrow, best first, and a sufficient distance from the path.
_PLACES = (
    "upper left",
    "upper right",
    "lower left",
    "lower right",
    "center left",
    "center right",
    "upper center",
    "lower center",
)
_FAR_INCHES = 0.4
# Width of a part of the map relative to the points in it, and its minimum height in metres.
_WIDER, _LEAST_M = 1.18, 1000.0
_WAYPOINT: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": "white",
    "markeredgecolor": PATH,
    "markeredgewidth": 1.6,
}


_RING: dict[str, Any] = {"color": TROUBLE, "linewidth": 2.0, "linestyle": (0, (4, 2))}
_PLACE: dict[str, Any] = {
    "color": TROUBLE,
    "linestyle": "",
    "marker": "X",
    "markersize": 12,
    "markeredgecolor": TEXT,
    "markeredgewidth": 1.2,
}


def draw(
    axes: Axes,
    bar: Axes,
    problem: Problem,
    path: NDArray[np.float64],
    samples: Samples,
    trouble: NDArray[np.bool_],
    reasons: Sequence[tuple[str, float, float]] = (),
    *,
    wind: tuple[float, float] | None = None,
    window: tuple[float, float, float, float] | None = None,
) -> list[Line2D | Patch]:
    """Draw the map of ``problem`` with ``path`` on ``axes``, in kilometres or metres.

    Returns the entries of a legend.

    Parameters
    ----------
    axes : Axes
        Axes with the aspect ratio of the map; if they are wider, the map lies in their south-west.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    trouble : ndarray
        True for samples that cannot be flown, (k,) bool.
    reasons : sequence of (str, float, float)
        Reasons to write next to the path, each with x and y in metres.
    wind : (float, float), optional
        The wind that the arrow shows, m/s; by default the wind of the problem.
    window : (float, float, float, float), optional
        West, south, east and north of the part that is shown, metres; all by default.
    """
    terrain = problem.terrain
    unit_m, unit = axis_unit(max(terrain.width_m, terrain.height_m))
    voids = _draw_land(axes, bar, problem, unit_m)
    if window is not None:
        west, south, east, north = (edge / unit_m for edge in window)
        axes.set(xlim=(west, east), ylim=(south, north))
    margin_m = 0.0 if problem.rules is None else problem.rules.zone_margin_m
    # Added as artists, because `add_patch` computes the limits of each curve, and the axes already
    # have limits.
    zones = wholes(problem.zones)
    many = len(zones) > zone_shapes.MANY
    if many:
        axes.add_artist(zone_shapes.outline_of_all(zones, unit_m))
    else:
        for zone in zones:
            axes.add_artist(zone_shapes.outline(zone, unit_m))
            if margin_m:
                zone_shapes.draw_margin(axes, zone, margin_m, unit_m)

    x, y = samples.x / unit_m, samples.y / unit_m
    axes.plot(
        x, y, color=PATH, linewidth=2.6, solid_capstyle="round", path_effects=halo(1.4), zorder=6
    )
    if trouble.any():
        axes.plot(
            np.where(trouble, x, np.nan),
            np.where(trouble, y, np.nan),
            color=TROUBLE,
            linewidth=4,
            zorder=7,
        )
    inner = path[1:-1] / unit_m
    axes.plot(inner[:, 0], inner[:, 1], zorder=8, **_WAYPOINT)
    points.draw(axes, path, problem, unit_m)
    for end, heading in zip(path[[0, -1]], problem.headings, strict=True):
        if heading is not None:
            axes.annotate(
                "",
                end[:2] / unit_m,
                xytext=(26 * heading[0], 26 * heading[1]),
                textcoords="offset points",
                arrowprops={"arrowstyle": "<|-", "color": TEXT, "linewidth": 2},
                zorder=8,
            )

    lines = np.stack((x, y), axis=1)
    air = problem.in_frame(problem.wind if wind is None else wind)
    box = _draw_scale_and_north(axes, lines, unit_m, air, problem.north_deg)
    taken = [box.get_window_extent()]
    # A violated zone has a single text, next to the path.
    broken = {f"zone {zone.name}": zone_shapes.text(zone) for zone in zones if zone.name}
    named = {text for text, _, _ in reasons}
    texts: list[tuple[str, tuple[float, float], dict[str, Any]]] = [
        (
            f"zone {broken[text]}" if text in broken else text,
            (x, y),
            {"color": TROUBLE, "fontsize": 9.5, "weight": "bold", "zorder": 12},
        )
        for text, x, y in reasons
    ]
    texts += [
        (text, zone.footprint.middle, {"color": NOFLY, "fontsize": 8.5, "zorder": 11})
        for zone in (() if many else zones)
        if (text := zone_shapes.text(zone)) and f"zone {zone.name}" not in named
    ]
    for text, (at_x, at_y), style in texts:
        place = at_x / unit_m, at_y / unit_m
        placed = label(axes, [place], text, taken, lines=lines, **style)
        taken += [] if placed is None else [placed]
    axes.set_title("Plan view", loc="left", fontsize=11.5, weight="bold", color=TEXT)
    axes.set_xlabel(f"east ({unit})", color=TEXT)
    axes.set_ylabel(f"north ({unit})", color=TEXT)
    axes.tick_params(colors=TEXT, labelsize=9)
    return _legend(problem, voids, bool(trouble.any()))


def _draw_land(axes: Axes, bar: Axes, problem: Problem, unit_m: float) -> bool:
    """Draw tinted hillshade and its colour bar; return whether there are voids."""
    terrain = problem.terrain
    rows, columns = terrain.elevation.shape
    stride = max(1, math.ceil(max(rows, columns) / _LARGEST_RASTER))
    land = terrain.elevation[::stride, ::stride]
    dx, dy = terrain.dx_m * stride, terrain.dy_m * stride
    voids = np.isnan(land)
    low, high = np.nanpercentile(land, (0.5, 99.5))
    high = max(high, low + 1)
    norm = Normalize(low, high)

    solid = np.where(voids, low, land)
    # Flat land is exaggerated and alps are toned down so that the steepest tenth shows as 40
    # degrees.
    slopes = np.hypot(*np.gradient(solid, dy, dx))[~voids]
    exaggeration = float(np.clip(0.85 / max(np.percentile(slopes, 90), 1e-3), 0.4, 12))
    shade = LightSource(azdeg=315, altdeg=45).hillshade(
        solid, vert_exag=exaggeration, dx=dx, dy=-dy
    )
    # Single precision with opacity: matplotlib draws it in two thirds of the time.
    image = LAND(norm(solid)).astype(np.float32)
    image[..., :3] *= 0.45 + 0.62 * shade[..., None].astype(np.float32)
    image[voids] = to_rgba("#e6e8ea")

    half = np.array((dx, dy)) / 2 / unit_m
    east, north = (land.shape[1] - 1) * dx / unit_m, (land.shape[0] - 1) * dy / unit_m
    extent = (-half[0], east + half[0], -half[1], north + half[1])
    axes.imshow(
        np.clip(image, 0, 1), origin="lower", extent=extent, interpolation="bilinear", zorder=1
    )
    box = axes.get_window_extent()
    width, height = extent[1] - extent[0], extent[3] - extent[2]
    wider = box.width / box.height / (width / height)
    if wider > 1.01:
        width *= wider
    elif wider < 0.99:
        height /= wider
    axes.set(
        xlim=(extent[0], extent[0] + width),
        ylim=(extent[2], extent[2] + height),
        facecolor="#f3f4f5",
    )
    axes.add_patch(
        Rectangle(
            (extent[0], extent[2]),
            extent[1] - extent[0],
            extent[3] - extent[2],
            fill=False,
            edgecolor=TEXT,
            linewidth=0.8,
            zorder=3,
        )
    )
    if voids.any():
        hatched = axes.contourf(
            np.linspace(0, east, land.shape[1]),
            np.linspace(0, north, land.shape[0]),
            voids.astype(float),
            levels=[0.5, 1.5],
            colors="none",
            hatches=["xxxxx"],
            zorder=2,
        )
        hatched.set(edgecolor=VOID, linewidth=0)
    ramp = np.linspace(low, high, 256)[:, None]
    bar.imshow(LAND(norm(ramp)), origin="lower", aspect="auto", extent=(0, 1, low, high))
    for clips, tip, level, colour in (
        (bool(np.nanmin(land) < low), -1, low, LAND(0.0)),
        (bool(np.nanmax(land) > high), 1, high, LAND(1.0)),
    ):
        if clips:
            # The arrow says that there is land beyond the range of the bar.
            corners = [(0, level), (1, level), (0.5, level + tip * 0.04 * (high - low))]
            bar.add_patch(
                Triangle(corners, facecolor=colour, edgecolor=TEXT, linewidth=0.6, clip_on=False)
            )
    bar.set_ylim(low, high)
    bar.xaxis.set_visible(False)
    bar.yaxis.tick_right()
    bar.tick_params(colors=TEXT, labelsize=8.5)
    bar.yaxis.set_label_position("right")
    bar.set_ylabel("height of the ground (m)", fontsize=9, color=TEXT)
    return bool(voids.any())


def axis_unit(span_m: float) -> tuple[float, str]:
    """Return metres per unit of an axis that spans ``span_m``, and the unit: km from 2 km on."""
    return (1000.0, "km") if span_m >= 2000 else (1.0, "m")


def window_around(
    points: NDArray[np.float64], axes: Axes, terrain: Terrain
) -> tuple[float, float, float, float]:
    """Return west, south, east and north of a part of the map with points, in the axes' aspect.

    Parameters
    ----------
    points : ndarray
        x and y, (k, 2) metres.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = 0.5 * (low + high), _WIDER * (high - low)
    box = axes.get_window_extent()
    aspect = box.width / box.height
    height = max(size[1], size[0] / aspect, _LEAST_M)
    half = 0.5 * np.array((height * aspect, height))
    # Beyond the edge of the map there is nothing to see but points.
    land = np.array((terrain.width_m, terrain.height_m))
    if (low >= 0).all() and (high <= land).all():
        middle = np.where(2 * half < land, np.clip(middle, half, land - half), 0.5 * land)
    (west, south), (east, north) = (middle - half).tolist(), (middle + half).tolist()
    return west, south, east, north


def nice_length(span: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most a quarter of ``span``."""
    power = 10.0 ** math.floor(math.log10(span / 4))
    return max(step * power for step in (1, 2, 5) if step * power <= span / 4)


def _draw_scale_and_north(
    axes: Axes,
    points: NDArray[np.float64],
    unit_m: float,
    wind: tuple[float, float] = (0.0, 0.0),
    north_deg: float = 0.0,
) -> AnchoredOffsetbox:
    """Draw scale bar, north arrow and wind where they are farthest from ``points``."""
    (left, right), window = axes.get_xlim(), axes.get_window_extent()
    per_inch = (right - left) * axes.figure.dpi / window.width
    length = nice_length(right - left)
    metres = length * unit_m
    label = f"{metres / 1000:g} km" if metres >= 1000 else f"{metres:g} m"
    bar = AuxTransformBox(axes.transData)
    bar.add_artist(Rectangle((0, 0), length, 0.032 * per_inch, color=TEXT))
    text = TextArea(label, textprops={"fontsize": 9.5, "color": TEXT})
    scale = VPacker(children=[text, bar], align="center", pad=0, sep=4)
    arrow = DrawingArea(10, 18)
    # The frame's north is up.
    lean = 18 * math.tan(math.radians(-north_deg))
    arrow.add_artist(
        FancyArrow(
            5 - lean / 2,
            0,
            lean,
            18,
            width=2.2,
            head_width=9,
            head_length=9,
            length_includes_head=True,
            color=TEXT,
            linewidth=0,
        )
    )
    name = TextArea("N", textprops={"fontsize": 10, "weight": "bold", "color": TEXT})
    north = VPacker(children=[arrow, name], align="center", pad=0, sep=2)
    parts: list[Artist] = [scale, north]
    speed = math.hypot(*wind)
    if speed > 0:
        # The arrow points in the direction in which the air moves.
        east, to_north = 20 * wind[0] / speed, 20 * wind[1] / speed
        area = DrawingArea(22, 22)
        area.add_artist(
            FancyArrow(
                11 - east / 2,
                11 - to_north / 2,
                east,
                to_north,
                width=2.2,
                head_width=8,
                head_length=8,
                length_includes_head=True,
                color=PATH,
                linewidth=0,
            )
        )
        said = TextArea(f"wind {speed:.3g} m/s", textprops={"fontsize": 9, "color": PATH})
        parts.append(VPacker(children=[area, said], align="center", pad=0, sep=2))
    box = AnchoredOffsetbox(
        _PLACES[0],
        child=HPacker(children=parts, align="center", pad=0, sep=10),
        pad=0.5,
        borderpad=0.9,
    )
    box.patch.set(linewidth=0, alpha=0.85, boxstyle="round,pad=0,rounding_size=0.3")
    box.set_zorder(10)
    axes.add_artist(box)

    seen = axes.transData.transform(points[np.isfinite(points).all(axis=1)])

    def distance(place: str) -> float:
        box.loc = AnchoredOffsetbox.codes[place]
        around = box.get_window_extent()
        outside = np.maximum(np.maximum(around.min - seen, seen - around.max), 0)
        return min(float(np.hypot(*outside.T).min(initial=np.inf)) / axes.figure.dpi, _FAR_INCHES)

    box.loc = AnchoredOffsetbox.codes[max(_PLACES, key=distance)]
    return box


def _legend(problem: Problem, voids: bool, trouble: bool) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [
        *points.legend(problem),
        Line2D([], [], color=PATH, linewidth=2.6, label="smoothed path"),
        Line2D([], [], label="waypoint", **_WAYPOINT),
    ]
    if problem.zones:
        handles.append(
            Patch(
                facecolor=(*to_rgb(NOFLY), 0.28), edgecolor=NOFLY, hatch="///", label="no-fly zone"
            )
        )
    if voids:
        handles.append(Patch(facecolor="#e6e8ea", edgecolor=VOID, hatch="xxxxx", label="void"))
    if trouble:
        handles.append(Line2D([], [], color=TROUBLE, linewidth=4, label="not flyable"))
    return handles


def draw_reason(axes: Axes, reason: Mapping[str, Any], unit_m: float) -> list[Line2D]:
    """Draw the closing ring and the place of a reason, and return their legend entries.

    Parameters
    ----------
    reason : mapping
        The ``reason`` of a summary; empty if there is none.
    unit_m : float
        Metres per unit of the axes.
    """
    handles = []
    limits = axes.get_xlim(), axes.get_ylim()
    ring = [np.array(line, dtype=np.float64) / unit_m for line in reason.get("ring") or ()]
    for line in ring:
        axes.plot(*line.T, zorder=9.5, path_effects=halo(1.0), **_RING)
    if ring:
        handles.append(Line2D([], [], label="closing ring", **_RING))
    if reason.get("place") is not None:
        x, y = reason["place"]
        axes.plot(x / unit_m, y / unit_m, zorder=9.6, **_PLACE)
        label = "must open here" if reason.get("code") == "closed" else "reason here"
        handles.append(Line2D([], [], label=label, **_PLACE))
    axes.set(xlim=limits[0], ylim=limits[1])
    return handles
