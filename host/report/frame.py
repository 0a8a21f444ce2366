"""Titles and legend of a picture, shared by all pictures of a map with graphs."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.artist import Artist
from matplotlib.figure import Figure

from pathgene.host.report.palette import TEXT


__all__ = ["LEFT", "NARROWEST", "RIGHT", "WIDTH", "frame", "titles"]

#: In inches: width of the figure, and the margins that titles and labels need.
WIDTH, LEFT, RIGHT = 13.2, 0.85, 0.35
#: Frames of maps whose aspect ratio is below this have room next to the map.
NARROWEST = 0.28


def frame(figure: Figure, title: str, subtitle: str, legend: Sequence[Artist]) -> None:
    """Write the titles above the graphs of ``figure``, and the legend of the map below them."""
    height = figure.get_size_inches()[1]
    titles(figure, title, subtitle)
    figure.legend(
        handles=list(legend),
        loc="center",
        ncols=len(legend),
        fontsize=10,
        frameon=False,
        bbox_to_anchor=(0.5, 0.24 / height),
        handletextpad=0.6,
        columnspacing=2.0,
    )


def titles(figure: Figure, title: str, subtitle: str, left: float = LEFT) -> None:
    """Write the titles, starting ``left`` inches from the edge."""
    width, height = figure.get_size_inches()
    for text, below, style in (
        (title, 0.36, {"fontsize": 16, "weight": "bold"}),
        (subtitle, 0.68, {"fontsize": 11.5}),
    ):
        figure.text(left / width, 1 - below / height, text, color=TEXT, va="center", **style)
