"""PNG files of 160 colours: a third of the size, and no difference that one sees."""

from __future__ import annotations

import io
from typing import BinaryIO

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

# Comes with matplotlib, which writes PNG files with it.
from PIL import Image

from host.report import palette


__all__ = ["save"]

_COLOURS = 160
# Colours that are kept as they are, with their opacity on white; and so many of the land.
_KEPT = (
    (palette.TEXT, 1.0),
    (palette.PATH, 1.0),
    (palette.START, 1.0),
    (palette.GOAL, 1.0),
    (palette.NOFLY, 1.0),
    (palette.NOFLY, 0.28),
    (palette.TROUBLE, 1.0),
    (palette.VOID, 1.0),
    (palette.GROUND, 1.0),
    (palette.BAND, 0.55),
    (palette.MEAN, 1.0),
    ("white", 1.0),
)
_KEPT_OF_LAND = 40


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
    # Loads SciPy.
    from scipy.spatial import KDTree

    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi, pil_kwargs={"compress_level": 1})
    image = Image.open(drawn).convert("RGB")
    colours = _colours(image)
    pixels = np.asarray(image).astype(np.uint32)
    packed, where = np.unique(pixels @ np.array([65536, 256, 1], np.uint32), return_inverse=True)
    found = np.stack((packed >> 16, packed >> 8 & 255, packed & 255), axis=1)
    nearest = KDTree(colours).query(found)[1].astype(np.uint8)
    reduced = Image.fromarray(nearest[where].reshape(pixels.shape[:2]))
    reduced.putpalette(colours.tobytes())
    reduced.save(binary, format="png", optimize=True, dpi=(dpi, dpi))


def _colours(image: Image.Image) -> NDArray[np.uint8]:
    """Return the colours of a picture, (k, 3): those that are kept and the most frequent others."""
    land = palette.LAND(np.linspace(0, 1, _KEPT_OF_LAND))[:, :3]
    flat = [1 - alpha * (1 - np.array(to_rgb(colour))) for colour, alpha in _KEPT]
    kept = np.rint(255 * np.concatenate((flat, land)))
    others = image.quantize(_COLOURS - len(kept)).getpalette()
    assert others is not None
    return np.concatenate((kept.astype(np.uint8), np.array(others, np.uint8).reshape(-1, 3)))
