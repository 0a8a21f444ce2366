"""The reason why there is no path, marked in the plan view."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from pathgene.host.report.palette import TEXT, TROUBLE, halo


__all__ = ["draw"]

_RING: dict[str, Any] = {"color": TROUBLE, "linewidth": 2.0, "linestyle": (0, (4, 2))}
_PLACE: dict[str, Any] = {
    "color": TROUBLE,
    "linestyle": "",
    "marker": "X",
    "markersize": 12,
    "markeredgecolor": TEXT,
    "markeredgewidth": 1.2,
}


def draw(axes: Axes, reason: Mapping[str, Any], unit_m: float) -> list[Line2D]:
    """Draw the closing ring and the place of a reason, and return their legend entries.

    Parameters
    ----------
    axes : Axes
        The plan view.
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
