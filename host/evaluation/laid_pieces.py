"""Pieces of any track as the kernels of the strict rule take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import Floats
from pathgene.host.evaluation.geometry import Arc, Piece


__all__ = ["lay_pieces"]


def lay_pieces(pieces: Sequence[Piece], airspeed_m_s: float) -> tuple[Floats, Floats]:
    """Return the geometry of pieces, and the second at which each begins.

    An arc must turn by less than half a circle.

    Returns
    -------
    tuple
        (n, PIECE_FIELDS) float64, of which only the geometry is filled in, and (n + 1,) float64,
        the last being the end of the last piece. In wind the times are as in still air.
    """
    rows = np.zeros((len(pieces), fields.PIECE_FIELDS))
    for row, piece in zip(rows, pieces, strict=True):
        row[[fields.X, fields.Y, fields.Z]] = piece.start
        row[[fields.UX, fields.UY]] = piece.heading
        row[fields.RUN], row[fields.RISE] = piece.run_m, piece.rise_m
        row[fields.LENGTH] = piece.length_m
        if isinstance(piece, Arc):
            row[fields.SIDE] = 1.0 if piece.turn_rad >= 0 else -1.0
            row[fields.ANGLE] = abs(piece.turn_rad)
            row[fields.Z_END] = piece.start[2] + piece.rise_m
        else:
            row[fields.SIDE] = 1.0
            row[[fields.X_END, fields.Y_END, fields.Z_END]] = piece.stop
    times = np.concatenate(([0.0], np.cumsum(rows[:, fields.LENGTH]) / airspeed_m_s))
    return rows, times
