"""Colours of the picture, distinct for any colour vision and in greyscale.

The strong colours are from Okabe and Ito's set or close to it; the tints of the land only grow
lighter with height, so their order is visible without hue.
"""

from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patheffects import AbstractPathEffect, Normal, Stroke


__all__ = [
    "BAND",
    "BEST",
    "DASHES",
    "FLOWN",
    "GOAL",
    "GROUND",
    "LAND",
    "MEAN",
    "NOFLY",
    "PATH",
    "SERIES",
    "START",
    "TEXT",
    "TROUBLE",
    "VOID",
    "halo",
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


def halo(width: float) -> list[AbstractPathEffect]:
    """Return a white rim of ``width`` points around a line or a text."""
    return [Stroke(linewidth=2 * width + 1.5, foreground="white", alpha=0.9), Normal()]
