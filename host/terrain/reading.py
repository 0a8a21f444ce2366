"""The facts of a terrain that a report states: place, true cells, north, heights and voids."""

from __future__ import annotations

from typing import Any

import numpy as np

from pathgene.host.remarks import Reading
from pathgene.host.terrain.grid import Terrain


__all__ = ["complete"]

# Decimals of a cell's metres, of a degree and of a share.
_DECIMALS = 4


def complete(terrain: Terrain) -> Terrain:
    """Return the terrain, also as the papers take it, with all facts as JSON values."""
    known = terrain.reading.facts
    rows, columns = terrain.shape
    land = int(np.count_nonzero(~terrain.voids))
    lowest, highest = terrain.lowest, terrain.highest
    below = np.count_nonzero(terrain.elevation < 0) if lowest < 0 else 0
    facts = {
        "source": terrain.loading.get("source") or terrain.source or terrain.name,
        "driver": known.get("driver", "numpy"),
        "nodes": [rows, columns],
        "cell_m": _cells(terrain),
        "projection": _projection(terrain),
        "grid_north_deg": None
        if terrain.metric is None
        # Zero has no sign, which rounding would keep.
        else round(terrain.metric.convergence_at_middle_deg, _DECIMALS) + 0.0,
        "heights": {
            **_ASSUMED,
            **known.get("heights", {}),
            "lowest_m": lowest,
            "highest_m": highest,
            "lowest_in_file_m": known.get("lowest_in_file_m", lowest),
            "share_below_0": round(known.get("share_below_0", below / land), _DECIMALS),
        },
        "water_level_m": known.get("water_level_m"),
        "voids": {
            "nodes": rows * columns - land,
            "share": round(1 - land / (rows * columns), _DECIMALS),
            "declared": known.get("declared_void"),
            "marks": known.get("marks", []),
            "named": known.get("named_void"),
            "are_filled": bool(terrain.loading.get("fill_voids")),
        },
    }
    if known.get("is_own"):
        facts["is_own"] = True
    paper = None if terrain.paper is None else complete(terrain.on_paper)
    return terrain.having(reading=Reading(facts, terrain.reading.remarks), paper=paper)


_ASSUMED = {
    "unit": "m",
    "unit_from": "assumed",
    "datum": "mean sea level",
    "datum_from": "assumed",
}


def _cells(terrain: Terrain) -> dict[str, list[float]]:
    """Return a cell's sides east and north, and, on Earth, their lengths at several places."""
    sides = terrain.dx_m, terrain.dy_m
    cells = {"used": [round(side, _DECIMALS) for side in sides]}
    metric = terrain.metric
    if metric is not None:
        for place, point in _POINTS.items():
            lengths = metric.east_m[point] * sides[0], metric.north_m[point] * sides[1]
            cells[place] = [round(float(length), _DECIMALS) for length in lengths]
    return cells


#: Places of a map among the points of its measure.
_POINTS = {"middle": 4, "sw": 0, "se": 2, "nw": 6, "ne": 8}


def _projection(terrain: Terrain) -> dict[str, Any] | None:
    """Return the reference systems of the file and of the frame, and whether the map is warped."""
    if terrain.crs is None:
        return None
    known = terrain.reading.facts
    return {
        "file": known.get("crs", terrain.crs),
        "frame": terrain.crs,
        "is_warped": bool(known.get("is_warped", False)),
        "metres_per_unit": [float(f"{each:.9g}") for each in terrain.frame.metres_per_unit],
    }
