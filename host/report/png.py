"""PNG files of 256 colours: a third of the size, and hardly a difference that one sees."""

from __future__ import annotations

import io
from typing import BinaryIO

from matplotlib.figure import Figure
from PIL import Image


__all__ = ["save"]


def save(figure: Figure, binary: BinaryIO, *, dpi: int) -> None:
    """Write a figure as a PNG without transparency.

    Parameters
    ----------
    figure : Figure
        The figure.
    binary : file
        Open for writing.
    dpi : int
        Pixels per inch.
    """
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi, pil_kwargs={"compress_level": 1})
    # Dithering would scatter dots over plain areas.
    reduced = Image.open(drawn).convert("RGB").quantize(dither=Image.Dither.NONE)
    reduced.save(binary, format="png", dpi=(dpi, dpi))
