"""The common style of all graphs."""

from matplotlib.axes import Axes

from host.report.palette import TEXT


__all__ = ["finish"]


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
