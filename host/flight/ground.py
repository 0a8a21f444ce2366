"""Ground and required clearance below a flight, from the definitions of docs/rules.md.

The judges of flights use them. They share no code with the rules that the planners follow, so a
fault there does not excuse the flight.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


__all__ = ["demanded_m", "is_off_map", "known_surface_m"]

Floats = NDArray[np.float64]

# Rounding of coordinates, metres: points so close to the edge are on the map.
_ROUNDING_M = 1e-6


def is_off_map(terrain: Terrain, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Return which points (k,) lie beyond the edge of the map."""
    rows, columns = terrain.shape
    beyond_x = np.abs(x - 0.5 * (columns - 1) * terrain.dx_m) - 0.5 * (columns - 1) * terrain.dx_m
    beyond_y = np.abs(y - 0.5 * (rows - 1) * terrain.dy_m) - 0.5 * (rows - 1) * terrain.dy_m
    return np.maximum(beyond_x, beyond_y) > _ROUNDING_M


def known_surface_m(terrain: Terrain, x: Floats, y: Floats) -> Floats:
    """Return the surface below points (k,), metres; NaN over voids and beyond the map's edge.

    The surface is the greater of the nearest node's height and the bilinear interpolation.
    """
    rows, columns = terrain.shape
    across = np.clip(np.asarray(x, dtype=np.float64) / terrain.dx_m, 0, columns - 1)
    up = np.clip(np.asarray(y, dtype=np.float64) / terrain.dy_m, 0, rows - 1)
    west, south = np.floor(across).astype(np.intp), np.floor(up).astype(np.intp)
    between = np.zeros_like(across)
    for column in (west, west + 1):
        for row in (south, south + 1):
            weight = (1 - np.abs(across - column)) * (1 - np.abs(up - row))
            # A node without weight may lie beyond the edge, or be a void.
            counts = weight > 0
            height = terrain.elevation[np.where(counts, row, 0), np.where(counts, column, 0)]
            between += np.where(counts, weight * height, 0.0)
    nearest = terrain.elevation[
        np.floor(up + 0.5).astype(np.intp), np.floor(across + 0.5).astype(np.intp)
    ]
    surface: Floats = np.maximum(nearest, between)  # NaN if either is.
    return np.where(is_off_map(terrain, x, y), np.nan, surface)


def demanded_m(problem: Problem, x: Floats, y: Floats) -> Floats:
    """Return the clearance required right below points (k,), metres; it is lower near both ends.

    At a horizontal distance d from an end it is at most the end's own height over the surface plus
    d times half the tangent of the climb limit (start) or descent limit (goal). 0 with
    ``as_paper``.
    """
    if problem.rules is None:
        return np.zeros_like(x)
    demanded = np.full(np.shape(x), problem.rules.clearance_m)
    aircraft = problem.aircraft
    for (end_x, end_y, end_z), steepest_deg in (
        (problem.start, aircraft.max_climb_deg),
        (problem.goal, aircraft.max_descent_deg),
    ):
        ground = float(known_surface_m(problem.terrain, np.array([end_x]), np.array([end_y]))[0])
        # An end over a void has no height of its own.
        height = 0.0 if math.isnan(ground) else end_z - ground
        away = np.sqrt((x - end_x) ** 2 + (y - end_y) ** 2)
        slope = 0.5 * math.tan(math.radians(steepest_deg))
        demanded = np.minimum(demanded, height + slope * away)
    return demanded
