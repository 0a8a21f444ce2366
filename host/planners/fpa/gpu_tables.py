"""Many problems in a few arrays, the input of the GPU's kernel."""

import hashlib
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import Floats


__all__ = ["joined", "table"]


def table(rows: Sequence[NamedTuple]) -> NDArray[Any]:
    """Return named tuples of one class as records, (r,)."""
    kinds = {float: np.float64, int: np.int64}
    fields = [(name, kinds.get(kind, kind)) for name, kind in type(rows[0]).__annotations__.items()]
    return np.array([tuple(row) for row in rows], dtype=np.dtype(fields, align=True))


def joined(rasters: Sequence[Floats]) -> tuple[Floats, NDArray[np.int64]]:
    """Return distinct flat rasters concatenated, and the index of each raster, (r,)."""
    places: dict[int | bytes, int] = {}  # Compared by identity, then by digest.
    kept = []
    begins = []
    end = 0
    for raster in rasters:
        if id(raster) not in places:
            digest = hashlib.blake2b(raster.tobytes()).digest()
            if digest not in places:
                places[digest] = end
                kept.append(raster)
                end += raster.size
            places[id(raster)] = places[digest]
        begins.append(places[id(raster)])
    return np.concatenate(kept), np.array(begins, dtype=np.int64)
