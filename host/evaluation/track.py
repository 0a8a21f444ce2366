"""The smoothed path as points, for pictures, files and the clearance in a report."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.geometry import Piece
from pathgene.host.terrain import Terrain


__all__ = ["Samples", "SmoothedTrack"]

# Samples that are evaluated together where only one of them counts.
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Samples:
    """Points along a track, all arrays (k,) float64 metres.

    Parameters
    ----------
    s : ndarray
        Distance flown, from 0 to the length of the track.
    x, y, z : ndarray
        Positions.
    ground : ndarray
        Height of the ground below, NaN over a void; outside the map, that height at the nearest
        node.
    clearance : ndarray
        ``z - ground``.
    """

    s: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    ground: NDArray[np.float64]
    clearance: NDArray[np.float64]


@dataclass(frozen=True)
class SmoothedTrack:
    """A smoothed path over its terrain.

    Parameters
    ----------
    pieces : tuple of Straight or Arc
        Pieces in flying order; at least one.
    """

    pieces: tuple[Piece, ...]
    terrain: Terrain

    @property
    def length_m(self) -> float:
        """Length in three dimensions, metres."""
        return sum(piece.length_m for piece in self.pieces)

    def sample(self, step_m: float) -> Samples:
        """Return points at most ``step_m`` apart, ends of pieces included.

        Raises
        ------
        ValueError
            If ``step_m`` is not a positive number.
        """
        if not (math.isfinite(step_m) and step_m > 0):
            raise ValueError(f"Step must be a positive number of metres, not {step_m!r}")
        along, points = [np.zeros(1)], [self.pieces[0].points(np.zeros(1))]
        flown = 0.0
        for piece in self.pieces:
            parts = math.ceil(piece.length_m / step_m)
            fractions = np.arange(1, parts + 1) / parts
            along.append(flown + piece.length_m * fractions)
            points.append(piece.points(fractions))
            flown += piece.length_m
        return self._samples(np.concatenate(along), np.concatenate(points))

    def midpoints(self, ds_m: float) -> tuple[Samples, NDArray[np.float64]]:
        """Return the samples of d_ut and d_nf: mid-points of equal parts of each piece.

        Returns
        -------
        tuple
            The samples, and the length (k,) of the part that each stands for.
        """
        along, points, weights = [], [], []
        flown = 0.0
        for piece in self.pieces:
            parts = math.ceil(piece.length_m / ds_m)
            fractions = (np.arange(parts) + 0.5) / parts
            along.append(flown + piece.length_m * fractions)
            points.append(piece.points(fractions))
            weights.append(np.full(parts, piece.length_m / parts))
            flown += piece.length_m
        return (
            self._samples(np.concatenate(along), np.concatenate(points)),
            np.concatenate(weights),
        )

    def least_clearance_m(self, ds_m: float) -> float:
        """Return the least clearance of :meth:`midpoints`, metres; NaN where all are over voids.

        It needs memory for some hundred thousand samples, independent of their number.
        """
        least = math.nan
        for piece in self.pieces:
            parts = math.ceil(piece.length_m / ds_m)
            for first in range(0, parts, _BLOCK):
                fractions = (np.arange(first, min(first + _BLOCK, parts)) + 0.5) / parts
                clearance = self._samples(fractions, piece.points(fractions)).clearance
                least = float(np.fmin.reduce(clearance, initial=least))
        return least

    def _samples(self, along: NDArray[np.float64], points: NDArray[np.float64]) -> Samples:
        x, y, z = np.ascontiguousarray(points.T)
        ground = self.terrain.ground(x, y)
        return Samples(along, x, y, z, ground, z - ground)
