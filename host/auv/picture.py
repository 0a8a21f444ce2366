"""The picture of an AUV's path: map of the landscape, profile of the seabed, convergence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pathgene.host.auv.field import AuvField, control_polygon
from pathgene.host.auv.landscape import HALF_SIDE, height
from pathgene.host.auv.measures import Floats
from pathgene.host.auv.plan import REPORT_SAMPLES
from pathgene.host.planners.routes.field import Route
from pathgene.host.planners.routes.spline import sample
from pathgene.host.report.style import (
    BEST,
    GOAL,
    GROUND,
    LAND,
    PATH,
    START,
    TEXT,
    TROUBLE,
    halo,
    save,
)


__all__ = ["write"]

_NODES = 501


def write(field: AuvField, route: Route, summary: dict[str, Any], file: Path) -> None:
    """Draw a run and write it to the PNG ``file``.

    Parameters
    ----------
    summary : dict
        Result of :func:`pathgene.host.auv.plan.describe`, with ``planner`` and ``seed``.
    """
    figure = Figure(figsize=(12.8, 6.9), facecolor="white")
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    axes = figure.subplot_mosaic([["map", "seabed"], ["map", "cost"]], width_ratios=(1.15, 1))
    _draw_map(axes["map"], field, route)
    figure.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=9.5)
    _draw_seabed(axes["seabed"], field, route)
    _draw_cost(axes["cost"], summary)
    fine = summary[f"at_{REPORT_SAMPLES}_samples"]
    figure.suptitle(
        f"Landscape {field.landscape}, {summary['planner']} ({field.reading}"
        f"{', as paper' if field.samples is not None else ''}), seed "
        f"{summary['seed']}: delta {summary['delta']:.3f} as searched, "
        f"{fine['delta']:.3f} at {REPORT_SAMPLES} samples a segment",
        color=TEXT,
        weight="bold",
    )
    save(figure, file)


def _draw_map(axes: Axes, field: AuvField, route: Route) -> None:
    side = np.linspace(-HALF_SIDE, HALF_SIDE, _NODES)
    land = height(field.landscape, side[None, :], side[:, None])
    image = axes.imshow(
        land,
        origin="lower",
        cmap=LAND,
        vmin=0,
        vmax=1,
        extent=(-HALF_SIDE, HALF_SIDE, -HALF_SIDE, HALF_SIDE),
    )
    axes.contour(
        side, side, land, levels=np.arange(0.1, 1, 0.1), colors=TEXT, linewidths=0.3, alpha=0.5
    )
    axes.figure.colorbar(image, ax=axes, shrink=0.7, label="height of the seabed")
    segments = route.segments
    curves = sample(segments.control, segments.counts, REPORT_SAMPLES).reshape(-1, 2)
    axes.plot(*curves.T, color=PATH, linewidth=2.4, path_effects=halo(1.2), label="path")
    polygon = control_polygon(route)
    axes.plot(
        *polygon.T,
        color=TEXT,
        linewidth=0.8,
        linestyle=":",
        marker=".",
        markersize=6,
        label="control points",
    )
    if len(route.points) > 2:
        axes.plot(
            *route.points[1:-1].T,
            linestyle="",
            marker="o",
            markerfacecolor="white",
            markeredgecolor=PATH,
            markersize=7,
            label="crossover points",
        )
    for point, marker, colour, size, name in (
        (route.points[0], "o", START, 11, "start"),
        (route.points[-1], "*", GOAL, 18, "goal"),
    ):
        axes.plot(
            *point,
            marker=marker,
            color=colour,
            markersize=size,
            markeredgecolor=TEXT,
            linestyle="",
            label=name,
            clip_on=False,
            zorder=9,
        )
    axes.set(xlabel="x", ylabel="y")


def _draw_seabed(axes: Axes, field: AuvField, route: Route) -> None:
    """Draw the height along the path, and the samples of the search with their steepest step."""
    control, counts = route.segments.control, route.segments.counts
    curves = sample(control, counts, REPORT_SAMPLES)
    read, read_of, _ = field.points(control, counts)
    samples = np.split(read, np.cumsum(read_of)[:-1])
    places = []
    begin = 0.0
    for curve, points in zip(curves, samples, strict=True):
        gone = _lengths(curve)
        axes.plot(begin + gone, height(field.landscape, *curve.T), color=GROUND)
        if field.samples is None:
            along = _lengths(points)
            # Chords are a little shorter than the curve.
            place = along * (gone[-1] / along[-1]) if along[-1] > 0 else along
        else:
            place = np.interp(
                np.linspace(0, 1, len(points)), np.linspace(0, 1, REPORT_SAMPLES), gone
            )
        places.append(begin + place)
        begin += gone[-1]
    heights = [height(field.landscape, *points.T) for points in samples]
    axes.vlines(
        np.concatenate(places), 0, np.concatenate(heights), color=PATH, linewidth=0.4, alpha=0.6
    )
    if field.samples is not None:
        axes.plot(
            np.concatenate(places), np.concatenate(heights), color=PATH, linestyle="", marker="."
        )
    _mark_steepest(axes, samples, places, heights)
    # Room for the mark above the ground.
    top = 1.25 * max(own.max() for own in heights)
    axes.set(
        xlim=(0, begin),
        ylim=(0, max(axes.get_ylim()[1], top)),
        xlabel="distance",
        ylabel="height of the seabed",
    )
    axes.set_title(
        f"Along the path; lines: the {len(read)} samples of the search", loc="left", fontsize=10
    )


def _mark_steepest(
    axes: Axes, samples: list[Floats], places: list[Floats], heights: list[Floats]
) -> None:
    """Mark the steepest step of the samples."""
    best = 0.0, 0.0, 0.0
    for points, place, own in zip(samples, places, heights, strict=True):
        step = np.hypot(*np.diff(points, axis=0).T)
        rate = np.abs(np.diff(own)) / np.where(step > 0, step, np.inf)
        k = int(rate.argmax())
        best = max(
            best, (float(rate[k]), float(place[k : k + 2].mean()), float(own[k : k + 2].mean()))
        )
    _, x, z = best
    axes.plot(
        x,
        z,
        linestyle="",
        marker="o",
        markersize=9,
        markerfacecolor="none",
        markeredgecolor=TROUBLE,
        markeredgewidth=1.8,
        label="steepest step of the search",
        clip_on=False,
        zorder=9,
    )
    axes.legend(frameon=False, fontsize=9, loc="upper right")


def _lengths(points: Floats) -> Floats:
    """Return the cumulative length of a polyline, (n, 2), at each of its points, (n,)."""
    along: Floats = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    return along


def _draw_cost(axes: Axes, summary: dict[str, Any]) -> None:
    generation, cost = np.array(summary["history"])[:, :2].T
    axes.step(generation, cost, where="post", color=BEST)
    axes.set(xlabel="generation", ylabel="delta", ylim=(0, None))
    axes.set_title("Best path so far", loc="left", fontsize=10)
