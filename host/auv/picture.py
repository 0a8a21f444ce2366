"""The picture of an AUV's path: the landscape from above, the seabed below it, convergence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from host.auv.field import AuvField, control_polygon
from host.auv.landscape import HALF_SIDE, height
from host.auv.plan import REPORT_SAMPLES
from host.planners.routes.field import Route
from host.planners.routes.spline import sample
from host.report.files import replacing
from host.report.palette import BEST, GOAL, GROUND, LAND, PATH, START, TEXT, halo


__all__ = ["write"]

_NODES = 501


def write(field: AuvField, route: Route, summary: dict[str, Any], file: Path) -> None:
    """Draw a run into the PNG ``file``.

    Parameters
    ----------
    field : AuvField
        The problem.
    route : Route
        The route.
    summary : dict
        Result of :func:`host.auv.plan.describe`, with ``planner`` and ``seed``.
    file : Path
        File to write.
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
        f"Landscape {field.landscape}, {summary['planner']} ({field.reading}), seed "
        f"{summary['seed']}: delta {summary['delta']:.3f} at {field.samples} samples a segment, "
        f"{fine['delta']:.3f} at {REPORT_SAMPLES}",
        color=TEXT,
        weight="bold",
    )
    with replacing(file) as binary:
        figure.savefig(binary, format="png", dpi=150)


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
    """Draw the height along the path and the samples of the search."""
    control, counts = route.segments.control, route.segments.counts
    along = np.linspace(0, 1, REPORT_SAMPLES)
    begin = 0.0
    for curve, coarse in zip(
        sample(control, counts, REPORT_SAMPLES), sample(control, counts, field.samples), strict=True
    ):
        gone = begin + np.concatenate(([0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))))
        axes.plot(gone, height(field.landscape, *curve.T), color=GROUND)
        axes.plot(
            np.interp(np.linspace(0, 1, field.samples), along, gone),
            height(field.landscape, *coarse.T),
            color=PATH,
            linestyle="",
            marker=".",
        )
        begin = gone[-1]
    axes.set(xlim=(0, begin), ylim=(0, None), xlabel="distance", ylabel="height of the seabed")
    axes.set_title("Along the path; dots: what the search has read", loc="left", fontsize=10)


def _draw_cost(axes: Axes, summary: dict[str, Any]) -> None:
    generation, cost = np.array(summary["history"])[:, :2].T
    axes.step(generation, cost, where="post", color=BEST)
    axes.set(xlabel="generation", ylabel="delta", ylim=(0, None))
    axes.set_title("Best path so far", loc="left", fontsize=10)
