"""A smoothed track as the kernels lay it, with the figures of its pieces."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import TURN_AT_END_RAD, Constants, Floats
from pathgene.host.evaluation.geometry import Arc, Piece
from pathgene.host.evaluation.rule_kernels import FIGURES, FLOWN, FUEL, piece_figures
from pathgene.host.evaluation.terrain_rule import track_point


__all__ = ["LaidTrack", "Place", "lay_pieces"]


def lay_pieces(pieces: Sequence[Piece], airspeed_m_s: float) -> tuple[Floats, Floats]:
    """Return the geometry of pieces, and the second at which each begins.

    An arc must turn by less than half a circle.

    Returns
    -------
    tuple
        (n, PIECE_FIELDS) float64, of which only the geometry is filled in, and (n + 1,) float64,
        the last being the end of the last piece. In wind the times are as in still air.
    """
    # Lists first: to write single numbers into an array takes ten times as long.
    table = []
    for piece in pieces:
        row = [0.0] * fields.PIECE_FIELDS
        row[fields.X], row[fields.Y], row[fields.Z] = piece.start
        row[fields.UX], row[fields.UY] = piece.heading
        row[fields.RUN], row[fields.RISE] = piece.run_m, piece.rise_m
        row[fields.LENGTH] = piece.length_m
        if isinstance(piece, Arc):
            row[fields.SIDE] = 1.0 if piece.turn_rad >= 0 else -1.0
            row[fields.ANGLE] = abs(piece.turn_rad)
            row[fields.Z_END] = piece.start[2] + piece.rise_m
        else:
            row[fields.SIDE] = 1.0
            row[fields.X_END], row[fields.Y_END], row[fields.Z_END] = piece.stop
        table.append(row)
    rows = np.array(table, dtype=np.float64).reshape(-1, fields.PIECE_FIELDS)
    times = np.concatenate(([0.0], np.cumsum(rows[:, fields.LENGTH]) / airspeed_m_s))
    return rows, times


#: A place on a track: a piece, and the share of its length.
Place = tuple[int, float]


class LaidTrack:
    """A smoothed track.

    Parameters
    ----------
    turns, pieces, times : ndarray
        As :func:`pathgene.host.evaluation.rule_kernels.strict_terms` leaves them.

    Attributes
    ----------
    rows : int
        Rows of ``pieces``; a row of length 0 is not a piece.
    """

    def __init__(
        self, constants: Constants, points: int, turns: Floats, pieces: Floats, times: Floats
    ) -> None:
        self.points, self.turns = points, turns
        self.pieces, self.times = pieces, times
        self.rows = 2 * points - 1
        self.figures = np.zeros((self.rows, FIGURES))
        piece_figures(constants, pieces, self.rows, self.figures)
        self._flown = np.flatnonzero(pieces[: self.rows, fields.LENGTH] > 0)

    @property
    def length_m(self) -> float:
        """Length in three dimensions, metres."""
        return float(self.pieces[self._flown, fields.LENGTH].sum())

    @property
    def time_s(self) -> float:
        """Seconds of the flight."""
        return float(self.times[self.rows])

    @property
    def fuel(self) -> float:
        """Fuel burned, newtons."""
        return float(self.figures[self._flown, FUEL].sum())

    def flown_m(self, row: int, share: float) -> float:
        """Return the metres flown to a place."""
        return float(self.figures[row, FLOWN] + share * self.pieces[row, fields.LENGTH])

    def place(self, row: int, share: float) -> tuple[float, float]:
        """Return the x and y of a place, metres."""
        along = share * self.pieces[row, fields.RUN]
        x, y, _, _ = track_point(self.pieces, row, along, 0.0)
        return x, y

    def highest(self) -> tuple[float, Place]:
        """Return the greatest altitude and its place."""
        pieces = self.pieces[self._flown]
        ends = np.stack((pieces[:, fields.Z], pieces[:, fields.Z] + pieces[:, fields.RISE]))
        end, at = np.unravel_index(int(np.argmax(ends)), ends.shape)
        return float(ends[end, at]), (int(self._flown[at]), float(end))

    def most(self, sign: int, figure: int) -> tuple[float, Place]:
        """Return the greatest value of ``sign`` times a figure, and its place."""
        values = sign * self.figures[self._flown, figure]
        at = int(np.argmax(values))
        return float(values[at]), (int(self._flown[at]), 0.0)

    def tightest_turn(self) -> tuple[float, Place]:
        """Return the least radius that fits at a waypoint with its neighbours, and the place.

        The radius is infinite on a straight path, and 0 at a reversal.
        """
        turns, n = self.turns, self.points
        bends = np.tan(0.5 * turns[:n, fields.ANGLE])
        # A reversal, and a waypoint next to a segment without horizontal length, has no arc.
        bends[~np.isfinite(turns[:n, fields.TANGENT]) & (bends == 0)] = math.inf
        bends[turns[:n, fields.ANGLE] >= math.pi] = math.inf
        runs = turns[:n, fields.RUN]
        best, at = math.inf, (0, 0.0)
        for i in np.flatnonzero(bends > 0).tolist():
            sharp = i in (0, n - 1) and turns[i, fields.ANGLE] > TURN_AT_END_RAD
            fits = 0.0 if sharp else math.inf
            if i > 0:
                fits = min(fits, runs[i - 1] / (bends[i - 1] + bends[i]))
            if i < n - 1:
                fits = min(fits, runs[i] / (bends[i] + bends[i + 1]))
            if fits < best:
                best, at = float(fits), (max(2 * i - 1, 0), 1.0)
        return best, at
