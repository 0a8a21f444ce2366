"""Synthetic terrains: the kinds of land on which the papers test, each from a seed.

Extents and heights are taken from the papers; the shapes are our own, because the papers' maps are
not published.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.terrain.grid import Terrain


__all__ = ["canyon", "large_canyon", "river"]

Grid = NDArray[np.float64]


def canyon(seed: int = 0) -> Terrain:
    """Return a winding, terraced canyon through a plateau: 25 km2, 0 to 260 m (*roberge*).

    501 x 501 nodes at 10 m.
    """
    rng = np.random.default_rng(seed)
    land = _canyon(rng, 501)
    return Terrain("canyon", _stretched(land, 260.0), 10.0, 10.0, source=f"synthetic, seed {seed}")


def river(seed: int = 0) -> Terrain:
    """Return a river valley between rounded hills: 25 km2, 0 to 217 m (*roberge*).

    501 x 501 nodes at 10 m.
    """
    rng = np.random.default_rng(seed)
    nodes = 501
    away = _distance_to_course(rng, nodes, swing=0.16, bends=1.6)
    hills = _noise(rng, nodes, slope=2.7, longest=0.25)
    detail = _noise(rng, nodes, slope=2.2, longest=0.06)
    valley = _rise(away, 0.02, 0.34)
    land = valley * (1.0 + 0.42 * hills) + 0.03 * detail * (0.2 + valley) + 0.01 * away
    return Terrain("river", _stretched(land, 217.0), 10.0, 10.0, source=f"synthetic, seed {seed}")


def large_canyon(seed: int = 0) -> Terrain:
    """Return a canyon of 80 x 80 km, 0 to 3500 m (*allaire-2008*, figure 7).

    500 x 500 nodes at 80000 / 499 m.
    """
    rng = np.random.default_rng(seed)
    spacing_m = 80_000.0 / 499
    return Terrain(
        "large-canyon",
        _stretched(_canyon(rng, 500), 3500.0),
        spacing_m,
        spacing_m,
        source=f"synthetic, seed {seed}",
    )


def _canyon(rng: np.random.Generator, nodes: int) -> Grid:
    away = _distance_to_course(rng, nodes, swing=0.2, bends=1.8)
    # Side valleys: the walls recede where a slow noise is near zero.
    gullies = np.abs(_noise(rng, nodes, slope=2.9, longest=0.2))
    wall = _rise(away * (0.5 + 0.5 * np.minimum(gullies, 1.3)), 0.012, 0.12)
    strata = 5.0
    step = wall * strata
    terraces = (np.floor(step) + _rise(step - np.floor(step), 0.35, 0.9)) / strata
    plateau = 0.09 * _noise(rng, nodes, slope=2.5, longest=0.4)
    detail = 0.012 * _noise(rng, nodes, slope=2.0, longest=0.05)
    return 0.45 * wall + 0.55 * terraces + plateau * wall + detail * (0.3 + wall)


def _distance_to_course(
    rng: np.random.Generator, nodes: int, *, swing: float, bends: float
) -> Grid:
    """Return the distance of each node to a meandering course from south to north.

    Lengths are in units of the map's edge. The course swings by ``swing`` about ``bends`` times,
    and the distance is measured in a plane warped by noise, so that the banks are not parallel.
    """
    y, x = np.meshgrid(*[np.linspace(0.0, 1.0, nodes)] * 2, indexing="ij")
    bend = 0.035
    x = x + bend * _noise(rng, nodes, slope=3.2, longest=0.3)
    y = y + bend * _noise(rng, nodes, slope=3.2, longest=0.3)
    along = np.linspace(-0.2, 1.2, 281)
    course = np.full_like(along, 0.5)
    for octave in range(3):
        size = swing * 0.45**octave * rng.uniform(0.75, 1.0)
        turns = 2.0 * np.pi * bends * 1.9**octave * rng.uniform(0.85, 1.15)
        course += size * np.sin(turns * along + rng.uniform(0.0, 2.0 * np.pi))
    nearest = np.full_like(x, np.inf)
    for east, north in zip(course, along, strict=True):
        np.minimum(nearest, (x - east) ** 2 + (y - north) ** 2, out=nearest)
    distance: Grid = np.sqrt(nearest)
    return distance


def _noise(rng: np.random.Generator, nodes: int, *, slope: float, longest: float) -> Grid:
    """Return noise of mean 0 and deviation 1 whose amplitude falls as frequency ** -slope.

    Waves longer than ``longest`` map edges are damped. The noise is drawn on a larger square and
    cropped, so that opposite edges do not match.
    """
    size = 2 * nodes
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij"))
    lowest = 1.0 / (longest * nodes)
    spectrum *= (lowest**2 + frequency**2) ** (-slope / 2)
    noise: Grid = np.fft.irfft2(spectrum, s=(size, size))[:nodes, :nodes]
    standard: Grid = (noise - noise.mean()) / noise.std()
    return standard


def _rise(value: Grid, low: float, high: float) -> Grid:
    """Return 0 up to ``low``, 1 above ``high``, and a smooth rise between."""
    share = np.clip((value - low) / (high - low), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _stretched(land: Grid, highest_m: float) -> Grid:
    """Return ``land`` rescaled to range from exactly 0 to exactly ``highest_m``."""
    share = (land - land.min()) / (land.max() - land.min())
    stretched: Grid = highest_m * share
    return stretched
