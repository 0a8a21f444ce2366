"""The picture of a flight: plan view, altitude profile and errors, planned and flown."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from pathgene.host.flight.ground import demanded_m
from pathgene.host.flight.judge import SHARE
from pathgene.host.report import plan_view
from pathgene.host.report.style import (
    FLOWN,
    GROUND,
    LEFT,
    LEGEND,
    NARROWEST,
    PATH,
    RIGHT,
    TEXT,
    WIDTH,
    finish,
    frame,
    halo,
)
from pathgene.host.terrain.surface import surface_below


if TYPE_CHECKING:
    from pathgene.host.flight.report import FlightReport

__all__ = ["draw", "layout"]

# Inches: height of the figure, and the margins of titles and legend.
_HEIGHT, _TOP, _BOTTOM = 7.6, 1.25, 1.05
_MOST_MAP = 6.1
_WIDEST = 2.4
# Points drawn along a track.
_POINTS = 4000


def draw(report: FlightReport) -> Figure:
    """Return the figure: the map next to the profile and the errors."""
    terrain = report.problem.terrain
    figure, plan, bar, profile, errors = layout(terrain.width_m / terrain.height_m)
    samples = report.track.sample(max(report.track.length_m / _POINTS, 1.0))
    legend = plan_view.draw(
        plan,
        bar,
        report.problem,
        report.path,
        samples,
        np.zeros(len(samples.s), dtype=bool),
        wind=report.wind,
    )
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    flown = report.flown
    plan.plot(
        flown.x / unit_m,
        flown.y / unit_m,
        color=FLOWN,
        linewidth=1.3,
        zorder=7,
        path_effects=halo(0.4),
    )
    legend.insert(3, Line2D([], [], color=FLOWN, linewidth=1.6, label="flown"))
    _draw_profile(profile, report)
    _draw_errors(errors, report)

    frame(figure, *_titles(report), legend)
    return figure


def layout(aspect: float) -> tuple[Figure, Axes, Axes, Axes, Axes]:
    """Return the figure and the axes of map, colour bar, profile and errors."""
    aspect = min(max(aspect, NARROWEST), _WIDEST)
    room = _HEIGHT - _TOP - _BOTTOM
    map_width = min(_MOST_MAP, room * aspect)
    map_height = map_width / aspect
    bottom = _BOTTOM + (room - map_height) / 2
    left = LEFT + map_width + 1.75
    width, height = WIDTH - RIGHT - left, (room - 1.0) / 2
    figure = Figure(figsize=(WIDTH, _HEIGHT), facecolor="white")
    FigureCanvasAgg(figure)
    places = (
        (LEFT, bottom, map_width, map_height),
        (LEFT + map_width + 0.12, bottom, 0.16, map_height),
        (left, _BOTTOM + height + 1.0, width, height),
        (left, _BOTTOM, width, height),
    )
    plan, bar, profile, errors = (
        figure.add_axes((x / WIDTH, y / _HEIGHT, w / WIDTH, h / _HEIGHT)) for x, y, w, h in places
    )
    return figure, plan, bar, profile, errors


def _titles(report: FlightReport) -> tuple[str, str]:
    verdict = report.verdict
    wind = math.hypot(*report.wind)
    weather = "calm air" if wind == 0 else f"wind of {wind:.1f} m/s"
    if report.gusts != "none":
        weather += f", {report.gusts} turbulence"
    title = f"Flown by {report.aircraft.name} in {weather}"
    if report.title:
        title += f", with {report.title}'s laws"
    subtitle = (
        f"{verdict.length_m / 1000:.1f} km in {verdict.flight_time_s / 60:.1f} min, "
        f"least clearance {verdict.clearance_flown_m:.1f} m "
        f"(planned {verdict.clearance_planned_m:.1f} m). "
        + ("Everything kept." if verdict.kept else verdict.breaks[0])
    )
    return title, subtitle


def _draw_profile(axes: Axes, report: FlightReport) -> None:
    flown, problem = report.flown, report.problem
    unit_m, unit = plan_view.axis_unit(report.track.length_m)
    samples = report.track.sample(max(report.track.length_m / _POINTS, 1.0))
    along = _horizontal(samples.x, samples.y) / unit_m
    surface = surface_below(problem.terrain, samples.x, samples.y, void_m=math.nan)
    heights = np.concatenate((samples.z, surface, flown.z))
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    margin = max(1.0, 0.12 * (high - low))
    axes.set_xlim(0, along[-1])
    axes.set_ylim(low - margin, high + margin)
    axes.fill_between(along, low - 10 * margin, surface, color=GROUND, linewidth=0, zorder=2)
    axes.plot(along, surface, color="#5b4a38", linewidth=0.8, zorder=3)
    if problem.rules is not None:
        demanded = demanded_m(problem, samples.x, samples.y)
        for share, dashes, label in (
            (1.0, (0, (7, 2)), "clearance"),
            (SHARE, (0, (2, 2)), "half of it"),
        ):
            axes.plot(
                along,
                surface + share * demanded,
                color="#5b4a38",
                linewidth=0.9,
                linestyle=dashes,
                zorder=3,
                label=label,
            )
    axes.plot(along, samples.z, color=PATH, linewidth=2.2, zorder=5, label="planned")
    axes.plot(flown.along_m / unit_m, flown.z, color=FLOWN, linewidth=1.2, zorder=6, label="flown")
    x, y, at = report.verdict.lowest_at_m
    lowest = int(np.argmin(np.hypot(flown.x - x, flown.y - y)))
    axes.plot(
        at / unit_m,
        flown.z[lowest],
        marker="v",
        markersize=7,
        color=TEXT,
        zorder=8,
        path_effects=halo(1.5),
        clip_on=False,
    )
    axes.legend(ncols=4, **LEGEND)
    finish(axes, "Altitude", f"distance along the path ({unit})", "altitude (m)")


def _draw_errors(axes: Axes, report: FlightReport) -> None:
    flown = report.flown
    unit_m, unit = plan_view.axis_unit(report.track.length_m)
    along = flown.along_m / unit_m
    rules = report.problem.rules
    corridor = rules.corridor_m if rules else 0.0
    most = max(1.1 * corridor, 1.15 * float(np.nanmax(np.abs(flown.cross_m))), 5.0)
    most = max(most, 1.15 * float(np.nanmax(np.abs(flown.height_error_m))))
    axes.axhline(0, color=TEXT, linewidth=0.8, zorder=2)
    axes.plot(along, flown.cross_m, color=PATH, linewidth=1.2, zorder=4, label="to the left")
    axes.plot(along, flown.height_error_m, color=FLOWN, linewidth=1.2, zorder=5, label="up")
    if corridor:
        # Lines in the colour of the lateral error, because the corridor does not limit heights.
        for side, label in ((corridor, "corridor, sideways"), (-corridor, None)):
            axes.axhline(
                side, color=PATH, linewidth=1.0, linestyle=(0, (6, 3)), zorder=3, label=label
            )
    axes.set_xlim(0, max(float(along[-1]), report.track.length_m * 1e-6))
    axes.set_ylim(-most, most)
    axes.legend(ncols=3, **LEGEND)
    finish(axes, "Off the track", f"distance along the path ({unit})", "metres")


def _horizontal(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cumulative horizontal distance along points, starting at 0."""
    steps = np.hypot(np.diff(x), np.diff(y))
    return np.concatenate(([0.0], np.cumsum(steps)))
