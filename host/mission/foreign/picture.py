"""The picture of a checked mission: its flight on the map and in the profile, and its faults."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from pathgene.host.mission.foreign.check import MissionCheck
from pathgene.host.mission.foreign.drawn import DrawnFlight, drawn_flight
from pathgene.host.mission.foreign.words import counted
from pathgene.host.report import fault_marks, hand_over_view, plan_view, profile
from pathgene.host.report.picture import TOP, layout
from pathgene.host.report.style import TEXT, any_letters, frame


__all__ = ["draw", "titles"]

Floats = NDArray[np.float64]

# Aspect ratios of the map: it shows the flight alone, so any is possible.
_NARROW, _WIDE = 0.75, 1.3


@any_letters()
def draw(check: MissionCheck, name: str) -> Figure:
    """Return the figure: the part of the map that is flown, next to the profile.

    Each fault has a mark with its number in the list of faults.

    Parameters
    ----------
    name : str
        Name of the mission.
    """
    flown, problem = drawn_flight(check), check.judge.problem
    terrain, samples = problem.terrain, flown.samples
    seen = _seen(flown)
    east_m, north_m = np.maximum(np.ptp(seen, axis=0), 1.0)
    aspect = float(np.clip(east_m / north_m, _NARROW, _WIDE))
    figure, (plan, bar, altitudes) = layout(aspect, TOP, searched=False)
    legend = plan_view.draw(
        plan,
        bar,
        problem,
        flown.points,
        samples,
        flown.broken,
        window=plan_view.window_around(seen, plan, terrain),
    )
    legend = [entry for entry in legend if entry.get_label() != "waypoint"]
    legend[2].set_label("mission as flown")
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    for circle in flown.circles:
        hand_over_view.draw_circle(plan, circle.x_m, circle.y_m, circle.radius_m, unit_m)
    if flown.circles:
        legend.append(Line2D([], [], label="circle", **hand_over_view.CIRCLE))
    if flown.marks:
        legend.append(fault_marks.legend())
    places = [(each.number, each.place[0] / unit_m, each.place[1] / unit_m) for each in flown.marks]
    fault_marks.draw(plan, places, np.stack((samples.x, samples.y), axis=1) / unit_m)
    _draw_profile(altitudes, check, flown)
    frame(figure, *titles(check, name), legend)
    return figure


def titles(check: MissionCheck, name: str) -> tuple[str, str]:
    """Return title and subtitle of a mission: its name, and the verdict."""
    problem = check.judge.problem
    verdict = "feasible" if check.feasible else "not feasible"
    figures = dict(check.pairs)
    subtitle = (
        f"{verdict}, {counted(len(check.faults), 'fault')}; length {figures['length']}, minimum "
        f"clearance {figures['minimum clearance']}; {problem.aircraft.name}"
    )
    return f"{name} over {problem.terrain.name}", subtitle


def _draw_profile(axes: Axes, check: MissionCheck, flown: DrawnFlight) -> None:
    """Draw the altitudes, and the faults that lie on a leg."""
    samples = flown.samples
    if not len(samples.s):
        axes.set_axis_off()
        axes.text(0.5, 0.5, "no leg is flown", transform=axes.transAxes, ha="center", color=TEXT)
        return
    profile.draw(axes, check.judge.problem, samples, flown.ground, flown.demanded, flown.broken)
    unit_m, _ = plan_view.axis_unit(float(samples.s[-1]))
    places = [
        (each.number, each.at_m / unit_m, each.place[2])
        for each in flown.marks
        if each.at_m is not None
    ]
    fault_marks.draw(axes, places, np.stack((samples.s / unit_m, samples.z), axis=1))


def _seen(flown: DrawnFlight) -> Floats:
    """Return x and y of all that the map shows, (k, 2) metres."""
    samples = flown.samples
    corners = [
        (each.x_m + side * each.radius_m, each.y_m + side * each.radius_m)
        for each in flown.circles
        for side in (-1, 1)
    ]
    flight = np.stack((samples.x, samples.y), axis=1)
    places = [
        flight[np.isfinite(flight).all(axis=1)],
        flown.points[:, :2],
        np.array([*corners, *(mark.place[:2] for mark in flown.marks)]).reshape(-1, 2),
    ]
    return np.concatenate(places)
