"""Style of the pictures: colours, graphs, titles and the legend of a map.

The colours are distinct with any colour vision and in grey. The strong ones are from Okabe and
Ito's set or close to it; the tints of the land become lighter with height, so their order is
visible without hue.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, Normal, Stroke
from PIL import Image

from pathgene.host.files.output import replacing


__all__ = [
    "BAND",
    "BEST",
    "DASHES",
    "FLOWN",
    "GOAL",
    "GROUND",
    "LAND",
    "LEFT",
    "LEGEND",
    "MEAN",
    "NARROWEST",
    "NOFLY",
    "PATH",
    "RIGHT",
    "SERIES",
    "START",
    "TEXT",
    "TROUBLE",
    "VOID",
    "WIDTH",
    "any_letters",
    "finish",
    "frame",
    "halo",
    "save",
    "titles",
]


TEXT = "#22272b"
PATH = "#0a4f8f"
START = "#009e73"
GOAL = "#f0b400"
NOFLY = "#a3246b"
# Bright enough to differ from the path in greyscale, dark enough for text on white.
TROUBLE = "#df1f1a"
FLOWN = "#d55e00"
VOID = "#6e7478"
GROUND = "#c7b697"
BAND = "#f0b400"
BEST = PATH
MEAN = "#7a7f84"

#: Colours of compared items, and the dashes of their lines. Both lists repeat; a repeated colour
#: has a different dash.
SERIES = (PATH, FLOWN, START, NOFLY, "#56b4e9", "#8a6d00", VOID)
DASHES: tuple[str | tuple[int, tuple[float, ...]], ...] = (
    "solid",
    (0, (6, 1.6)),
    (0, (2.2, 1.1)),
    (0, (6, 1.5, 1.5, 1.5)),
    (0, (1.1, 1.1)),
)

LAND = LinearSegmentedColormap.from_list(
    "land", ["#4f7268", "#7c9479", "#a9ac85", "#ccbd97", "#e3d5bb", "#f7f3ec"]
)
# Pixels per inch; a picture is a little wider than a screen of 1,920.
_DPI = 146


def halo(width: float) -> list[AbstractPathEffect]:
    """Return a white rim of ``width`` points around a line or a text."""
    return [Stroke(linewidth=2 * width + 1.5, foreground="white", alpha=0.9), Normal()]


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
    # With y, matplotlib does not measure all labels to find out whether one is above the title.
    axes.set_title(title, y=1.0, loc="left", fontsize=11.5, weight="bold", color=TEXT)
    axes.set_xlabel(x, color=TEXT)
    axes.set_ylabel(y, color=TEXT)
    axes.tick_params(colors=TEXT, labelsize=9)
    axes.grid(color="#d9d9d9", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


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


@contextmanager
def any_letters() -> Iterator[None]:
    """Mute the warning of letters that the font lacks: names may be in any script."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from", UserWarning)
        yield


@any_letters()
def save(figure: Figure, file: Path) -> None:
    """Write an opaque figure to a PNG file."""
    figure.set_dpi(_DPI)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    # Without transparency, level 2 takes a third of the time of Matplotlib's default, and no more
    # space.
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    with replacing(file) as binary:
        image.save(binary, "png", compress_level=2, dpi=(_DPI, _DPI))
