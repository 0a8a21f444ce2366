"""A problem over smaller cells, for searches."""

from __future__ import annotations

import dataclasses

import numpy as np

from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["divided", "finer", "on_grid"]


def divided(terrain: Terrain, parts: int) -> Terrain:
    """Return the terrain with ``parts`` x ``parts`` smaller cells for each; a new grid.

    A node has the highest ground that the strict rule assumes in its cell: of the nearest nodes of
    the terrain, two or four on the edge between their cells, and of the bilinear surface at the
    node. A node with a void among these is a void.
    """
    from scipy import ndimage

    rows, columns = (np.arange((nodes - 1) * parts + 1) / parts for nodes in terrain.shape)
    heights = terrain.elevation
    for axis, places in enumerate((rows, columns)):
        low, high = (each.astype(np.int64) for each in (np.ceil(places - 0.5), places + 0.5))
        heights = np.maximum(np.take(heights, low, axis), np.take(heights, high, axis))
    between = ndimage.map_coordinates(
        np.where(terrain.voids, terrain.lowest, terrain.elevation),
        np.meshgrid(rows, columns, indexing="ij"),
        order=1,
    )
    return terrain.having(
        elevation=np.maximum(heights, between),
        dx_m=terrain.dx_m / parts,
        dy_m=terrain.dy_m / parts,
    )


def finer(problem: Problem, parts: int) -> Problem:
    """Return the problem over ``parts`` x ``parts`` smaller cells for each; see :func:`on_grid`."""
    return problem if parts == 1 else on_grid(problem, divided(problem.terrain, parts))


def on_grid(problem: Problem, terrain: Terrain, zones: tuple[Zone, ...] | None = None) -> Problem:
    """Return the problem over a new grid of the same ground, for searches alone.

    Nothing is checked: an end on the ground may lie below a node of the new grid.

    Parameters
    ----------
    zones : tuple of Zone, optional
        Its zones; by default the problem's.
    """
    other = object.__new__(type(problem))
    values = {field.name: getattr(problem, field.name) for field in dataclasses.fields(problem)}
    values["terrain"] = terrain
    if zones is not None:
        values["zones"] = zones
    for name, value in values.items():
        object.__setattr__(other, name, value)
    return other
