"""The end of a mission and its rally points on the plan view."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from pathgene.host.report.handed_over import HandedOver
from pathgene.host.report.style import PATH, TEXT, halo


__all__ = ["CIRCLE", "draw", "draw_circle"]

_WAY: dict[str, Any] = {"color": PATH, "linewidth": 1.3, "linestyle": (0, (5, 2))}
#: Style of a circle that is flown.
CIRCLE: dict[str, Any] = {"color": PATH, "linewidth": 1.3}
_DISC: dict[str, Any] = {"color": PATH, "linewidth": 0.8, "linestyle": (0, (1, 2))}
_RALLY: dict[str, Any] = {
    "linestyle": "",
    "marker": "^",
    "markersize": 5.5,
    "markerfacecolor": "white",
    "markeredgecolor": TEXT,
    "markeredgewidth": 1.0,
}


def draw_circle(
    axes: Axes, x_m: float, y_m: float, radius_m: float, unit_m: float, **style: Any
) -> None:
    """Draw a circle that is flown on a map."""
    ring = Circle(
        (x_m / unit_m, y_m / unit_m), radius_m / unit_m, fill=False, zorder=6.5, **CIRCLE | style
    )
    ring.set_path_effects(halo(0.8))
    axes.add_artist(ring)


def draw(axes: Axes, mission: HandedOver, unit_m: float) -> list[Line2D]:
    """Draw the mission on a map that has its limits, and return its legend entries."""
    limits = axes.get_xlim(), axes.get_ylim()
    for line in (mission.way, mission.go_around):
        if len(line) > 1:
            axes.plot(*line[:, :2].T / unit_m, zorder=6.5, path_effects=halo(0.8), **_WAY)
    for each in mission.circles:
        draw_circle(axes, each.x_m, each.y_m, each.radius_m, unit_m)
        draw_circle(axes, each.x_m, each.y_m, each.disc_m, unit_m, **_DISC)
    if len(mission.rally):
        axes.plot(*mission.rally[:, :2].T / unit_m, zorder=8.5, **_RALLY)
    axes.set(xlim=limits[0], ylim=limits[1])
    handles = []
    if len(mission.way) > 1 or mission.circles:
        handles.append(Line2D([], [], label="end of the mission", **_WAY))
    if len(mission.rally):
        handles.append(Line2D([], [], label="rally point", **_RALLY))
    return handles
