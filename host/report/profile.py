"""The altitude profile of the picture: ground, required clearance, zones and ceilings."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from pathgene.host.evaluation import Samples
from pathgene.host.evaluation.aircraft_limits import line_limits
from pathgene.host.problem.problem import Problem
from pathgene.host.report import points, zone_shapes
from pathgene.host.report.placing import label
from pathgene.host.report.plan_view import axis_unit
from pathgene.host.report.style import (
    BAND,
    GROUND,
    LEGEND,
    NOFLY,
    PATH,
    TEXT,
    TROUBLE,
    VOID,
    finish,
    halo,
)


__all__ = ["draw"]

Floats = NDArray[np.float64]

# Positions of a ceiling's text as shares of the profile's width, best first: next to its line, or
# at the top for a higher ceiling.
_ASIDE = (0.75, 0.5, 0.25, 0.9, 0.1)
_AT_TOP = tuple(np.linspace(0.05, 0.95, 37).tolist())
# Points of each line that texts avoid.
_POINTS = 400
# Maximum height above the altitudes at which a ceiling is still shown, as a share of their range.
_HIGHER = 0.5


def draw(
    axes: Axes,
    problem: Problem,
    samples: Samples,
    ground: Floats,
    band: Floats,
    trouble: NDArray[np.bool_],
    reasons: Sequence[tuple[str, int]] = (),
    lowest_at_m: float | None = None,
    clearance_m: float | None = None,
    visited: Sequence[tuple[str, float]] = (),
) -> None:
    """Draw the altitudes along a path over the ground.

    Parameters
    ----------
    ground, band : ndarray
        The surface below the samples, and the lowest altitude that the rules allow, (k,) metres.
    trouble : ndarray
        True for samples that cannot be flown, (k,) bool.
    reasons : sequence of (str, int)
        Limits to name, each with its sample.
    lowest_at_m : float or None
        Metres flown to the minimum clearance; by default where the samples are lowest.
    clearance_m : float, optional
        The minimum clearance; by default it is not marked.
    visited : sequence of (str, float)
        The points between the ends, each with the metres flown to the nearest place of the path.
    """
    unit_m, unit = axis_unit(float(samples.s[-1]))
    along = samples.s / unit_m
    ceilings = _ceilings(problem, ground)
    low, top = _heights(samples, ground, ceilings)
    axes.set_xlim(0, along[-1])
    axes.set_ylim(low, top)

    axes.fill_between(along, 11 * low - 10 * top, ground, color=GROUND, linewidth=0, zorder=2)
    axes.plot(along, ground, color="#5b4a38", linewidth=0.8, zorder=3)
    names: list[tuple[str, list[tuple[float, float]], str]] = []
    if problem.rules is None:
        zone = problem.nofly_raster[problem.terrain.nearest_nodes(samples.x, samples.y)]
        _shade(axes, along, zone, NOFLY)
    else:
        axes.fill_between(along, ground, band, color=BAND, alpha=0.55, linewidth=0, zorder=2)
        _draw_zones(axes, along, problem, samples)
        for name, heights in ceilings:
            axes.plot(along, heights, color=TEXT, linewidth=1.0, linestyle="--", zorder=4)
            names.append(_ceiling_text(name, along, heights, top))
        clearance = f"clearance {problem.rules.clearance_m:g} m"
        axes.legend(handles=[Patch(color=BAND, alpha=0.55, linewidth=0, label=clearance)], **LEGEND)
    _shade(axes, along, np.isnan(ground), VOID)
    axes.plot(along, samples.z, color=PATH, linewidth=2, zorder=5, path_effects=halo(1.5))
    if trouble.any():
        axes.plot(along, np.where(trouble, samples.z, np.nan), color=TROUBLE, linewidth=3, zorder=6)
    for name, at_m in visited:
        points.draw_along(axes, name, at_m / unit_m, float(np.interp(at_m, samples.s, samples.z)))
    finish(axes, "Altitude along the path", f"distance flown ({unit})", "altitude (m)")
    taken: list[Bbox] = []
    if clearance_m is not None:
        taken = _mark_clearance(axes, along, samples, lowest_at_m, clearance_m)
    for limit, at in reasons:
        names.append((limit, [(float(along[at]), float(samples.z[at]))], TROUBLE))
    every = max(1, len(along) // _POINTS)
    drawn = [samples.z, *(ceiling for _, ceiling in ceilings)]
    lines = np.concatenate([np.stack((along, line), axis=1)[::every] for line in drawn])
    for text, places, colour in names:
        # Above a line, and below the top.
        first = 0.5 * math.pi if all(y < top for _, y in places) else -0.5 * math.pi
        near = label(
            axes,
            places,
            text,
            taken,
            lines=lines,
            first=first,
            color=colour,
            fontsize=9,
            zorder=10,
        )
        taken += [] if near is None else [near]


def _ceiling_text(
    name: str, along: Floats, heights: Floats, top: float
) -> tuple[str, list[tuple[float, float]], str]:
    """Return the text of a ceiling, the places for it and its colour.

    If a ceiling is nowhere below ``top``, its text is at ``top`` with an arrow.
    """
    if not (heights < top).any():
        return f"\u2191 {name}", [(share * float(along[-1]), top) for share in _AT_TOP], TEXT
    at = [*(int(share * len(along)) for share in _ASIDE), int(np.nanargmin(heights))]
    return name, [(float(along[i]), float(heights[i])) for i in at if heights[i] < top], TEXT


def _ceilings(problem: Problem, ground: Floats) -> list[tuple[str, Floats]]:
    """Return the ceilings of a problem, each with its name and its altitudes, (k,) metres."""
    if problem.rules is None:
        return []
    ceilings = [
        (f"{name} {ceiling:,.0f} m", np.full(len(ground), ceiling))
        for name, ceiling in (
            ("ceiling", problem.rules.ceiling_m),
            *((limit.label, altitude) for limit, altitude in line_limits(problem)),
        )
        if ceiling is not None
    ]
    if (above := problem.rules.ceiling_agl_m) is not None:
        ceilings.append((f"ceiling {above:,.0f} m above ground", ground + above))
    return ceilings


def _heights(
    samples: Samples, ground: Floats, ceilings: Sequence[tuple[str, Floats]]
) -> tuple[float, float]:
    """Return the lowest and the highest altitude of the graph, with all ceilings that are near."""
    heights = np.concatenate((samples.z, ground))
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    most = high + _HIGHER * (high - low)
    tops = [float(np.nanmax(ceiling, initial=high)) for _, ceiling in ceilings]
    shown = max((top for top in tops if top <= most), default=high)
    margin = max(1.0, 0.12 * (shown - low))
    return low - margin, shown + (3.2 if ceilings else 2.2) * margin


def _draw_zones(axes: Axes, along: NDArray[np.float64], problem: Problem, samples: Samples) -> None:
    """Draw the zones that the track crosses as blocks of their heights."""
    bottom, top = axes.get_ylim()
    blocks = []
    for zone, inside in zone_shapes.crossed(problem.zones, samples.x, samples.y):
        # A limit beyond the graph needs no position.
        low = bottom if zone.lower_m is None else max(zone.lower_m, 2 * bottom - top)
        high = top if zone.upper_m is None else min(zone.upper_m, 2 * top - bottom)
        if low > top or high < bottom:
            continue
        for first, end in _runs(inside):
            left, right = along[first], along[end - 1]
            blocks.append([(left, low), (right, low), (right, high), (left, high)])
    # One collection, because there may be thousands of blocks and each alone would take
    # milliseconds.
    drawn = PolyCollection(
        blocks,
        facecolor=(*to_rgb(NOFLY), 0.25),
        edgecolor=NOFLY,
        hatch="///",
        linewidth=0.8,
        zorder=1.5,
    )
    axes.add_collection(drawn, autolim=False)


def _shade(axes: Axes, along: NDArray[np.float64], where: NDArray[np.bool_], colour: str) -> None:
    """Shade the intervals in which ``where`` holds, from bottom to top."""
    for first, end in _runs(where):
        axes.axvspan(
            along[first],
            along[end - 1],
            facecolor=colour,
            alpha=0.3,
            hatch="///",
            zorder=1,
            edgecolor=colour,
            linewidth=0,
        )


def _runs(where: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the first index and the index after the last of each run of True, (n, 2)."""
    edges = np.diff(np.concatenate(([False], where, [False])).astype(np.int8))
    return np.flatnonzero(edges).reshape(-1, 2)


def _mark_clearance(
    axes: Axes,
    along: NDArray[np.float64],
    samples: Samples,
    lowest_m: float | None,
    clearance_m: float,
) -> list[Bbox]:
    """Mark the point of least clearance, and return the box of its text.

    The point is ``lowest_m`` metres flown from the start, by default where the samples are lowest.
    """
    if lowest_m is not None:
        if not np.isfinite(clearance_m):
            return []
        x = float(np.interp(lowest_m, samples.s, along))
        z = float(np.interp(lowest_m, samples.s, samples.z))
        ground = z - clearance_m
    else:
        if np.isnan(samples.clearance).all():
            return []
        at = int(np.nanargmin(samples.clearance))
        x, ground, z = float(along[at]), float(samples.ground[at]), float(samples.z[at])
    axes.plot([x, x], [ground, z], color=TEXT, linewidth=1.4, zorder=7)
    axes.plot(
        x, z, marker="v", markersize=7, color=TEXT, zorder=8, path_effects=halo(1.5), clip_on=False
    )
    left, right = axes.get_xlim()
    share = (x - left) / (right - left)
    half = 1.2 * axes.figure.dpi / axes.get_window_extent().width  # Inches: half the text's width.
    note = axes.annotate(
        f"minimum clearance {clearance_m:,.1f} m",
        (x, z),
        xytext=(min(max(share, half), 1 - half), 0.93),
        textcoords="axes fraction",
        ha="center",
        va="top",
        fontsize=9.5,
        color=TEXT,
        zorder=9,
        bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "alpha": 0.85, "linewidth": 0},
        arrowprops={"arrowstyle": "-", "color": TEXT, "linewidth": 0.8, "shrinkB": 4},
    )
    # Only the text's box, once it is placed: with the arrow, the box would take half the graph.
    note.get_window_extent()
    return [Text.get_window_extent(note)]
