"""The picture of a flight with replans: every version of the path, heights and distances."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.flight.flight import PERIOD_S
from pathgene.host.flight.ground import demanded_m
from pathgene.host.flight.picture import layout
from pathgene.host.problem.tiles import wholes
from pathgene.host.report import plan_view, zone_shapes
from pathgene.host.report.style import (
    FLOWN,
    GROUND,
    LEGEND,
    NOFLY,
    PATH,
    SERIES,
    START,
    TEXT,
    any_letters,
    finish,
    frame,
    halo,
)
from pathgene.host.terrain.surface import surface_below


if TYPE_CHECKING:
    from pathgene.host.replanning.outcome import Replanned

__all__ = ["draw", "titles", "version_points", "window"]

Floats = NDArray[np.float64]

# Step along a drawn track, metres.
_STEP_M = 10.0
# Interval between drawn samples of a flight, in samples.
_EVERY = 10
#: Style of the versions of the path after the first.
VERSION: dict[str, Any] = {"linewidth": 2.0, "linestyle": (0, (4, 1.5))}
# Colours of later paths: those that the rest of the picture does not use.
_VERSIONS = tuple(each for each in SERIES if each not in (PATH, FLOWN, START, NOFLY))
_HELD: dict[str, Any] = {"color": START, "linewidth": 1.6, "linestyle": (0, (1.5, 1))}


@any_letters()
def draw(report: Replanned) -> Figure:
    """Return the figure: the map next to heights and distances over time."""
    session = report.session
    mission = session.mission
    terrain = mission.terrain
    figure, plan, bar, heights, zones = layout(terrain.width_m / terrain.height_m)
    first = session.pilot.legs[0].track
    samples = SmoothedTrack(first, terrain).sample(_STEP_M)
    ends = np.array([mission.start, mission.goal])
    none = np.zeros(len(samples.s), dtype=bool)
    shown = window(report, plan)
    legend = plan_view.draw(plan, bar, mission, ends, samples, none, window=shown)
    legend = [each for each in legend if each.get_label() != "waypoint"]
    legend[2].set_label("first path")
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    for zone in new_zones(report):
        plan.add_patch(zone_shapes.outline(zone, unit_m))
    for number, leg in enumerate(session.pilot.legs[1:], 1):
        points = version_points(report, number)
        style = {"color": _VERSIONS[(number - 1) % len(_VERSIONS)], **VERSION}
        plan.plot(*(points / unit_m).T, zorder=6, **(style if leg.kind == "path" else _HELD))
    flown = np.array(session.pilot.samples)[::_EVERY]
    plan.plot(
        flown[:, 1] / unit_m,
        flown[:, 2] / unit_m,
        color=FLOWN,
        linewidth=1.3,
        zorder=7,
        path_effects=halo(0.4),
    )
    legend += [
        Line2D([], [], color=_VERSIONS[0], label="later paths", **VERSION),
        Line2D([], [], label="circle, way out", **_HELD),
        Line2D([], [], color=FLOWN, linewidth=1.6, label="flown"),
    ]
    _draw_heights(heights, report, flown)
    _draw_distances(zones, report, flown)
    frame(figure, *titles(report), legend)
    return figure


def titles(report: Replanned) -> tuple[str, str]:
    """Return title and subtitle of pictures of a flight."""
    outcome, session = report.outcome, report.session
    board = f" (board {report.board})" if report.board else ""
    title = f"{session.mission.terrain.name}, replanned in flight by {report.planner}{board}"
    times = [1000 * each.active_s for each in session.changes if each.active_s is not None]
    found = "no new path"
    if times:
        first, last = f"{min(times):.1f}", f"{max(times):.1f}"
        found = f"{'new paths' if len(times) > 1 else 'a new path'} after {first} ms"
        if first != last:
            found = f"new paths after {first} to {last} ms"
    subtitle = (
        f"{len(session.changes)} changes, {found}; {outcome.flight_time_s / 60:.1f} min, least "
        f"clearance {outcome.clearance_flown_m:.1f} m. "
        + ("Everything kept." if outcome.kept else outcome.breaks[0])
    )
    return title, subtitle


def new_zones(report: Replanned) -> list[Any]:
    """Return the zones that did not exist when the flight began, at their first positions."""
    air = report.session.airspace
    known = {zone.name for zone in air.past[0][1]}
    found = []
    for _, zones in air.past:
        # Zones that appear together may share a name.
        found += [zone for zone in wholes(zones) if zone.name not in known]
        known |= {zone.name for zone in zones}
    return found


def window(report: Replanned, axes: Axes) -> tuple[float, float, float, float]:
    """Return west, south, east and north of all tracks, in the axes' aspect."""
    session = report.session
    points = np.vstack(
        [
            np.array(session.pilot.samples)[:, 1:3],
            *(version_points(report, number) for number in range(len(session.pilot.legs))),
        ]
    )
    return plan_view.window_around(points, axes, session.mission.terrain)


def version_points(report: Replanned, number: int) -> Floats:
    """Return the x and y of a version of the path, (k, 2) metres, from where it came into use."""
    session = report.session
    leg = session.pilot.legs[number]
    samples = SmoothedTrack(leg.track, session.mission.terrain).sample(_STEP_M)
    points = np.column_stack((samples.x, samples.y))
    index = min(round(leg.since_s / PERIOD_S), len(session.pilot.samples) - 1)
    here = session.pilot.samples[index][1:3]
    nearest = int(np.argmin(np.hypot(*(points - here).T)[: len(points)]))
    return points[nearest:]


def _draw_heights(axes: Axes, report: Replanned, flown: Floats) -> None:
    mission = report.session.mission
    seconds = _seconds(flown)
    x, y, z = flown[:, 1], flown[:, 2], flown[:, 3]
    surface = surface_below(mission.terrain, x, y, void_m=math.nan)
    low, high = float(np.nanmin(surface)), float(max(np.nanmax(surface), z.max()))
    margin = max(1.0, 0.12 * (high - low))
    axes.fill_between(seconds, low - 10 * margin, surface, color=GROUND, linewidth=0, zorder=2)
    axes.plot(seconds, surface, color="#5b4a38", linewidth=0.8, zorder=3)
    axes.plot(
        seconds,
        surface + demanded_m(mission, x, y),
        color="#5b4a38",
        linewidth=0.9,
        linestyle=(0, (7, 2)),
        zorder=3,
        label="clearance",
    )
    axes.plot(seconds, z, color=FLOWN, linewidth=1.4, zorder=6, label="flown")
    axes.set_ylim(low - margin, high + margin)
    _mark(axes, report, seconds)
    axes.legend(ncols=2, **LEGEND)
    finish(axes, "Altitude", "time (s)", "altitude (m)")


def _draw_distances(axes: Axes, report: Replanned, flown: Floats) -> None:

    past = report.session.airspace.past
    seconds = _seconds(flown)
    distance = np.full(len(flown), math.nan)
    for (since, zones), end in zip(past, [each[0] for each in past[1:]] + [math.inf], strict=True):
        during = (seconds >= since) & (seconds < end)
        if zones and during.any():
            distance[during] = np.min(
                [
                    zone.footprint.distance_m(flown[during, 1], flown[during, 2])
                    for zone in wholes(zones)
                ],
                axis=0,
            )
    rules = report.session.mission.rules
    assert rules is not None
    axes.axhline(0, color=NOFLY, linewidth=1.2, zorder=3, label="border")
    axes.axhline(
        rules.zone_margin_m,
        color=NOFLY,
        linewidth=1.0,
        linestyle=(0, (6, 3)),
        zorder=3,
        label="margin",
    )
    axes.plot(seconds, distance, color=PATH, linewidth=1.4, zorder=5, label="nearest zone")
    if np.isfinite(distance).any():
        axes.set_ylim(min(-50.0, 1.1 * float(np.nanmin(distance))), 1000.0)
    _mark(axes, report, seconds)
    axes.legend(ncols=3, **LEGEND)
    finish(axes, "Distance from zones", "time (s)", "metres, up to 1,000")


def _seconds(flown: Floats) -> Floats:
    return np.arange(len(flown), dtype=np.float64) * (PERIOD_S * _EVERY)


def _mark(axes: Axes, report: Replanned, seconds: Floats) -> None:
    axes.set_xlim(0, max(float(seconds[-1]), 1.0))
    for change in report.session.changes:
        axes.axvline(change.at_s, color=TEXT, linewidth=0.9, linestyle=(0, (2, 2)), zorder=4)
