"""The common style of all graphs."""

from typing import Any

from matplotlib.axes import Axes

from pathgene.host.report.palette import TEXT


__all__ = ["LEGEND", "finish"]

#: To the right of the title, where no line can cross it.
LEGEND: dict[str, Any] = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 1.0),
    "fontsize": 9,
    "frameon": False,
    "borderpad": 0.3,
    "borderaxespad": 0.0,
    "handlelength": 1.4,
    "columnspacing": 1.1,
}


def finish(axes: Axes, title: str, x: str, y: str) -> None:
    """Give ``axes`` a title, labels and a light grid; remove the frame at the top and right."""
    axes.set_title(title, loc="left", fontsize=11.5, weight="bold", color=TEXT)
    axes.set_xlabel(x, color=TEXT)
    axes.set_ylabel(y, color=TEXT)
    axes.tick_params(colors=TEXT, labelsize=9)
    axes.grid(color="#d9d9d9", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
