"""The picture of a run: plan view over hillshade, altitude profile and convergence."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.path import Path as Outline
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from host.evaluation import Evaluation, Evaluator, Samples
from host.evaluation.broken import Stretch
from host.evaluation.evaluator import FINE
from host.problem.problem import Problem
from host.problem.zones import Circle, Polygon, Zone
from host.report import convergence, plan_view, reason_marks
from host.report.axes import LEGEND, finish
from host.report.files import replacing
from host.report.palette import BAND, GROUND, NOFLY, PATH, TEXT, TROUBLE, VOID, halo
from host.report.placing import label


__all__ = ["Scene", "draw", "write"]

_WIDE = 2.2  # Maps wider than this by height lie above the two graphs.
_NARROWEST, _WIDEST = 0.28, 6.5  # Frames of maps narrower than these have room beside the map.
# Inches: width of the figure, and the margins that titles, labels and legend need.
_WIDTH, _LEFT, _RIGHT, _TOP, _BOTTOM = 13.2, 0.85, 0.35, 1.6, 1.0
# Shares of the profile's width where the text of a ceiling may stand, the better ones first.
_ASIDE = (0.75, 0.5, 0.25, 0.9, 0.1)
_MOST_REASONS = 12  # Stretches that are named, the longest ones.
# Units of the limits that are no lengths.
_UNITS = {"climb": "m/s", "descent": "m/s", "power": "W", "fuel": "N", "stall": "m/s"}


@dataclass(frozen=True)
class Scene:
    """The content of a picture.

    Parameters
    ----------
    evaluator : Evaluator
        Holds the problem and its terrain.
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    evaluation : Evaluation
        Terms of the path.
    history : sequence of [int, float, float]
        Generation, best and mean fitness; empty for a path that was given.
    title, subtitle : str
        Lines above the picture.
    reason : mapping
        The ``reason`` of a summary: why a planner found no path; empty for a path that was given.
    """

    evaluator: Evaluator
    path: NDArray[np.float64]
    evaluation: Evaluation
    history: Sequence[Sequence[float]]
    title: str
    subtitle: str
    reason: Mapping[str, Any] = field(default_factory=dict)


def write(scene: Scene, file: Path) -> None:
    """Draw ``scene`` into the PNG ``file``, 1920 pixels wide or more."""
    figure = draw(scene)
    with replacing(file) as binary:
        figure.savefig(binary, format="png", dpi=150)


def draw(scene: Scene) -> Figure:
    """Return the figure: the map beside the two graphs, or above them if it is wide."""
    terrain = scene.evaluator.problem.terrain
    rows, columns = terrain.elevation.shape
    aspect = columns * terrain.dx_m / (rows * terrain.dy_m)
    figure, (plan, bar, profile, progress) = _layout(aspect)

    # The samples of the verdict, so that the picture does not contradict it.
    samples, _ = scene.evaluator.track(scene.path).midpoints(scene.evaluator.ds_m / FINE)
    stretches = scene.evaluator.broken(scene.path)
    trouble = _trouble(scene.evaluator, samples, stretches)
    reasons = _reasons(samples, stretches)
    legend = plan_view.draw(
        plan,
        bar,
        scene.evaluator.problem,
        scene.path,
        samples,
        trouble,
        [(limit, float(samples.x[at]), float(samples.y[at])) for limit, at in reasons],
    )
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    legend += reason_marks.draw(plan, scene.reason, unit_m)
    _draw_profile(profile, scene, samples, trouble, reasons)
    convergence.draw(progress, scene.history, scene.evaluation.fitness)

    width, height = figure.get_size_inches()
    figure.legend(
        handles=legend,
        loc="center",
        ncols=len(legend),
        fontsize=10,
        frameon=False,
        bbox_to_anchor=(0.5, 0.24 / height),
        handletextpad=0.6,
        columnspacing=2.0,
    )
    for text, below, style in (
        (scene.title, 0.36, {"fontsize": 16, "weight": "bold"}),
        (scene.subtitle, 0.68, {"fontsize": 11.5}),
    ):
        figure.text(_LEFT / width, 1 - below / height, text, color=TEXT, va="center", **style)
    if not scene.evaluation.feasible and (why := _why(scene)):
        figure.text(
            _LEFT / width,
            1 - 0.85 / height,
            "\n".join(textwrap.wrap(why, 125, max_lines=2, placeholder=" ...")),
            color=TROUBLE,
            va="top",
            fontsize=10.5,
            weight="bold",
        )
    return figure


def _why(scene: Scene) -> str:
    """Return why a path is not feasible; empty for a given path as paper."""
    if sentence := scene.reason.get("sentence"):
        return f"No path: {sentence}"
    if not scene.evaluation.limits:
        return ""
    worst = scene.evaluation.limits[0]
    name = worst["limit"]
    unit = "m" if name.startswith("zone ") else _UNITS.get(name, "m")
    return (
        f"Not feasible: {name} is {worst['worst']:,.1f} {unit}, "
        f"allowed {worst['allowed']:,.1f} {unit}, after {worst['at_m'] / 1000:.2f} km"
    )


def _reasons(samples: Samples, stretches: Sequence[Stretch]) -> list[tuple[str, int]]:
    """Return the limits of the longest stretches, each with the sample in its middle."""
    longest = sorted(stretches, key=lambda each: each.from_m - each.to_m)[:_MOST_REASONS]
    middles = np.searchsorted(samples.s, [0.5 * (each.from_m + each.to_m) for each in longest])
    at = np.minimum(middles, len(samples.s) - 1).tolist()
    return [(each.limit, place) for each, place in zip(longest, at, strict=True)]


def _layout(aspect: float) -> tuple[Figure, list[Axes]]:
    """Return the figure and the axes of map, colour bar, profile and convergence."""
    aspect = min(max(aspect, _NARROWEST), _WIDEST)
    if aspect > _WIDE:
        map_width = min(_WIDTH - _LEFT - 1.0, 4.0 * aspect)
        map_height = map_width / aspect
        graph_height, gap = 2.3, 1.1
        bottom = _BOTTOM + graph_height + gap
        height = bottom + map_height + _TOP
        left = _LEFT + (_WIDTH - _LEFT - 1.0 - map_width) / 2
        graph_width = (_WIDTH - _LEFT - _RIGHT - 0.9) / 2
        graphs = [
            (_LEFT, _BOTTOM, graph_width * 1.15, graph_height),
            (_LEFT + graph_width * 1.15 + 0.9, _BOTTOM, graph_width * 0.85, graph_height),
        ]
    else:
        height = 7.75
        room = height - _TOP - _BOTTOM
        map_width = min(6.1, room * aspect)
        map_height = map_width / aspect
        left, bottom = _LEFT, _BOTTOM + (room - map_height) / 2
        graph_left = left + map_width + 1.75
        graph_width, graph_height = _WIDTH - _RIGHT - graph_left, (room - 1.0) / 2
        graphs = [
            (graph_left, _BOTTOM + graph_height + 1.0, graph_width, graph_height),
            (graph_left, _BOTTOM, graph_width, graph_height),
        ]
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    FigureCanvasAgg(figure)
    places = [
        (left, bottom, map_width, map_height),
        (left + map_width + 0.12, bottom, 0.16, map_height),
        *graphs,
    ]
    return figure, [
        figure.add_axes((x / _WIDTH, y / height, w / _WIDTH, h / height)) for x, y, w, h in places
    ]


def _trouble(
    evaluator: Evaluator, samples: Samples, stretches: Sequence[Stretch]
) -> NDArray[np.bool_]:
    """Return which samples break a limit; as paper, are in the ground, a void or a zone."""
    problem = evaluator.problem
    if not problem.as_paper:
        broken = np.zeros(len(samples.s), dtype=bool)
        for each in stretches:
            broken |= (samples.s >= each.from_m) & (samples.s <= each.to_m)
            middle = np.searchsorted(samples.s, 0.5 * (each.from_m + each.to_m))
            broken[min(int(middle), len(broken) - 1)] = True
        return broken
    zone = problem.nofly_raster[problem.terrain.nearest_nodes(samples.x, samples.y)]
    trouble: NDArray[np.bool_] = np.isnan(samples.ground) | (samples.clearance < 0) | zone
    return trouble


def _draw_profile(
    axes: Axes,
    scene: Scene,
    samples: Samples,
    trouble: NDArray[np.bool_],
    reasons: Sequence[tuple[str, int]],
) -> None:
    problem = scene.evaluator.problem
    unit_m, unit = plan_view.axis_unit(float(samples.s[-1]))
    along = samples.s / unit_m
    if problem.rules is None:
        ground = samples.ground
    else:
        ground, band = _surface_and_band(scene.evaluator, samples)
    heights = np.concatenate((samples.z, ground))
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    margin = max(1.0, 0.12 * (high - low))
    axes.set_xlim(0, along[-1])
    axes.set_ylim(low - margin, high + 2.2 * margin)

    axes.fill_between(along, low - 10 * margin, ground, color=GROUND, linewidth=0, zorder=2)
    axes.plot(along, ground, color="#5b4a38", linewidth=0.8, zorder=3)
    names: list[tuple[str, list[tuple[float, float]], str]] = []
    if problem.rules is None:
        zone = problem.nofly_raster[problem.terrain.nearest_nodes(samples.x, samples.y)]
        _shade(axes, along, zone, NOFLY)
    else:
        axes.fill_between(along, ground, band, color=BAND, alpha=0.55, linewidth=0, zorder=2)
        _draw_zones(axes, along, problem, samples)
        for name, ceiling in (
            ("ceiling", problem.rules.ceiling_m),
            ("service ceiling", problem.aircraft.service_ceiling_m),
        ):
            if ceiling is not None and ceiling < axes.get_ylim()[1]:
                axes.axhline(ceiling, color=TEXT, linewidth=1.2, linestyle="--", zorder=4)
                places = [(share * float(along[-1]), ceiling) for share in _ASIDE]
                names.append((f"{name} {ceiling:,.0f} m", places, TEXT))
        if (above := problem.rules.ceiling_agl_m) is not None:
            axes.plot(along, ground + above, color=TEXT, linewidth=0.9, linestyle="--", zorder=4)
            aside = [int(share * len(along)) for share in _ASIDE]
            places = [(float(along[i]), float(ground[i] + above)) for i in aside]
            names.append((f"ceiling {above:,.0f} m above ground", places, TEXT))
        clearance = f"clearance {problem.rules.clearance_m:g} m"
        axes.legend(handles=[Patch(color=BAND, alpha=0.55, linewidth=0, label=clearance)], **LEGEND)
    _shade(axes, along, np.isnan(ground), VOID)
    axes.plot(along, samples.z, color=PATH, linewidth=2, zorder=5, path_effects=halo(1.5))
    if trouble.any():
        axes.plot(along, np.where(trouble, samples.z, np.nan), color=TROUBLE, linewidth=3, zorder=6)
    finish(axes, "Altitude along the path", f"distance flown ({unit})", "altitude (m)")
    lowest_m = scene.evaluator.lowest_at_m(scene.path)
    taken = _mark_clearance(axes, along, samples, lowest_m, scene.evaluation.minimum_clearance_m)
    for limit, at in reasons:
        names.append((limit, [(float(along[at]), float(samples.z[at]))], TROUBLE))
    for text, places, colour in names:
        for x, y in places:
            placed = label(axes, x, y, text, taken, color=colour, fontsize=9, zorder=10)
            if placed is not None:
                taken.append(placed)
                break


def _surface_and_band(
    evaluator: Evaluator, samples: Samples
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the surface below the track, and the lowest altitude that the rules demand there.

    The corridor is looked at along five lines; the verdict looks everywhere.
    """
    from host.problem.surface import surface_below

    problem = evaluator.problem
    assert problem.rules is not None
    dx, dy = np.gradient(samples.x), np.gradient(samples.y)
    run = np.maximum(np.hypot(dx, dy), 1e-9)
    highest = np.full(len(samples.x), -np.inf)
    for share in (-1.0, -0.5, 0.0, 0.5, 1.0):
        aside = share * problem.rules.corridor_m
        x, y = samples.x - aside * dy / run, samples.y + aside * dx / run
        highest = np.maximum(highest, surface_below(problem.terrain, x, y))
    surface = surface_below(problem.terrain, samples.x, samples.y)
    required = problem.demand.required_m(samples.x, samples.y)
    return (
        np.where(np.isfinite(surface), surface, np.nan),
        np.where(np.isfinite(highest), highest + required, np.nan),
    )


def _draw_zones(axes: Axes, along: NDArray[np.float64], problem: Problem, samples: Samples) -> None:
    """Draw the zones that the track crosses as blocks of their heights."""
    bottom, top = axes.get_ylim()
    for zone in problem.zones:
        inside = _covers(zone, samples.x, samples.y)
        low = bottom if zone.lower_m is None else zone.lower_m
        high = top if zone.upper_m is None else zone.upper_m
        axes.fill_between(
            along,
            low,
            high,
            where=inside,
            facecolor=(*to_rgb(NOFLY), 0.25),
            edgecolor=NOFLY,
            hatch="///",
            linewidth=0.8,
            zorder=1.5,
        )


def _covers(zone: Zone, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points are within the outline of a zone."""
    if isinstance(zone, Circle):
        return np.asarray(np.hypot(x - zone.x_m, y - zone.y_m) <= zone.radius_m)
    assert isinstance(zone, Polygon)
    inside = np.zeros(len(x), dtype=bool)
    for ring in (zone.ring, *zone.holes):
        inside ^= Outline(ring).contains_points(np.stack((x, y), axis=1))
    return inside


def _shade(
    axes: Axes,
    along: NDArray[np.float64],
    where: NDArray[np.bool_],
    colour: str,
) -> None:
    """Shade the intervals ``where`` holds, from bottom to top."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], where, [False])).astype(np.int8)))
    for first, last in edges.reshape(-1, 2):
        axes.axvspan(
            along[first],
            along[last - 1],
            facecolor=colour,
            alpha=0.3,
            hatch="///",
            zorder=1,
            edgecolor=colour,
            linewidth=0,
        )


def _mark_clearance(
    axes: Axes,
    along: NDArray[np.float64],
    samples: Samples,
    lowest_m: float | None,
    clearance_m: float,
) -> list[Bbox]:
    """Mark the point of least clearance, and return the box of its text.

    It is ``lowest_m`` metres flown from the start, or by default where the samples are lowest.
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
    half = 1.2 * axes.figure.dpi / axes.get_window_extent().width  # Inches of half the text.
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
    return [note.get_window_extent()]
