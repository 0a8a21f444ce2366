"""The scene of a problem or a plan: plain JSON that the views of a browser draw.

Lengths are metres in the terrain's local frame: x east, y north of its south-west node, altitudes
above the datum of the terrain. Arrays are base64 of little-endian numbers. The keys of a scene:

``title``, ``subtitle``
    Texts; empty for a problem without a plan.
``verdict``
    ``{"feasible": true, false or null, "sentence": why not, or empty}``.
``terrain``
    ``name``; ``rows``, ``columns`` of the mesh and ``width_m``, ``height_m`` between its outermost
    nodes; ``heights``, uint16 row by row from the south-west, each ``low_m + step_m * value``,
    where 65535 is a void; ``nodes``, rows and columns of the whole terrain, and ``thinned``, true
    if the mesh has fewer nodes: each is then the highest of the terrain nodes around it, or a void
    if one of them is a void; ``vertical``, the factor by which the 3-D view exaggerates heights;
    ``crs`` or null.
``points``
    Start, via points, goal and return in the order of the flight: ``kind`` (``start``, ``via``,
    ``goal``, ``return``), ``name``, ``x``, ``y``, ``z``, ``ground_m`` (null over a void).
``zones``
    ``name``, ``text`` (name, limits and times in lines), ``rings`` (the outline and then its
    holes, [x, y] without the closing corner; a circle as a polygon), ``lower_m``, ``upper_m``,
    ``t0_s``, ``t1_s`` (each may be null), ``circle`` (``x``, ``y``, ``radius_m``, or null),
    ``tiles``: ``rings``, ``circle`` (null), ``lower_m``, ``upper_m`` of the tiles of a zone with
    limits above the ground, whose ``lower_m`` and ``upper_m`` are the outermost; null for another
    zone.
``zones_left_out``
    Number of zones that are not drawn, the smallest ones, because there are too many.
``paths``
    The plan's path, or nothing: ``name``; ``waypoints`` [[x, y, z], ...]; ``track``, the smoothed
    path, with ``length_m``, ``samples`` (k) and the float32 arrays (k,) ``s`` (metres flown),
    ``x``, ``y``, ``z``, ``ground`` (the surface below, NaN over a void), ``clearance`` (height over
    the highest surface within the corridor) and ``demanded`` (minimum altitude of the rules, NaN
    with ``as_paper``); ``broken``, stretches that break a limit: ``limit``, ``from_m``, ``to_m``;
    ``mission``, as an autopilot gets it, null without one: ``items``, ``legs`` between them with
    the arcs of their turns, ``way`` from the goal to the end, ``go_around`` and ``rally`` ([[x, y,
    z], ...]), ``circles`` (``x``, ``y``, ``z``, ``radius_m``, ``disc_m``).
``figures``
    The main figures of the summary: ``key`` of the summary, ``label``, ``value`` as in the summary,
    ``text`` with its unit.
``faults``
    The faults of a checked mission, in the order of the list; missing in other scenes:
    ``sentence``, ``x``, ``y``, ``z``, ``at_m`` (metres flown, null for a place without a leg).
``ceilings``
    Ceilings of the rules and the aircraft: ``name``, ``altitude_m``, ``agl`` (true: above the
    surface).
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluator, Samples
from pathgene.host.evaluation.aircraft_limits import line_limits
from pathgene.host.mission.autopilot.hand_over import USUAL, HandOver
from pathgene.host.mission.drawn import drawn_mission
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import outermost, tiles_of, wholes
from pathgene.host.problem.zones import Zone
from pathgene.host.report.along import broken_limits, surface_and_demand, why
from pathgene.host.report.handed_over import HandedOver
from pathgene.host.report.reading import warnings_in
from pathgene.host.report.track import mark_names
from pathgene.host.terrain import Terrain
from pathgene.host.web.figures import captions, figures


__all__ = [
    "ceilings_scene",
    "columns_scene",
    "mission_scene",
    "path_scene",
    "plan_scene",
    "points_scene",
    "problem_scene",
    "terrain_scene",
    "zones_scene",
]

Floats = NDArray[np.float64]

#: Maximum nodes of the mesh along a side.
MOST_NODES = 512
# Value of a void, and the number of values below it for heights.
_VOID, _VALUES = 65535, 65534
# Samples of a track: the ends of its pieces are samples, too.
_SAMPLES = 1500
# Corners of the polygon around a circle.
_CIRCLE_CORNERS = 72
# Maximum corners of all zones together, to limit the size of the page.
_MOST_CORNERS = 60_000
# Relief of less than this share of the longer side is exaggerated by one of these factors.
_RELIEF = 0.1
_FACTORS = (1.0, 1.5, 2.0, 3.0)


def problem_scene(problem: Problem) -> dict[str, Any]:
    """Return the scene of a problem without a path."""
    zones = zones_scene(problem.zones)
    return {
        "title": problem.terrain.name,
        "subtitle": "",
        "verdict": {"feasible": None, "sentence": ""},
        "terrain": terrain_scene(problem.terrain),
        "points": points_scene(problem),
        "zones": zones,
        "zones_left_out": len(wholes(problem.zones)) - len(zones),
        "paths": [],
        "figures": [],
        "ceilings": ceilings_scene(problem),
    }


def plan_scene(
    evaluator: Evaluator,
    path: Floats,
    summary: Mapping[str, Any],
    wanted: HandOver = USUAL,
) -> dict[str, Any]:
    """Return the scene of a plan.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    summary : mapping
        The content of ``summary.json``: it supplies the verdict and the figures.
    wanted : HandOver
        The user's choices about the mission that an autopilot gets.
    """
    title, subtitle = captions(summary)
    feasible = summary.get("feasible")
    reason = summary.get("reason")
    sentence = ""
    if feasible is False:
        sentence = why(reason or {}, summary.get("limits"))
    sentence = " ".join((*filter(None, [sentence]), *warnings_in(summary)))
    name = str(summary.get("planner") or "path")
    least_m = summary.get("minimum_clearance_m")
    drawn = path_scene(evaluator, path, name, least_m=least_m)
    if feasible:
        mission = drawn_mission(evaluator.problem, evaluator.track(path), wanted)
        drawn["mission"] = mission_scene(mission)
    return {
        **problem_scene(evaluator.problem),
        "title": title,
        "subtitle": subtitle,
        "verdict": {"feasible": feasible, "sentence": sentence},
        "paths": [drawn],
        "figures": figures(summary),
    }


def terrain_scene(terrain: Terrain) -> dict[str, Any]:
    """Return the mesh of a terrain, of at most :data:`MOST_NODES` nodes along a side."""
    mesh = _thinned(terrain.elevation)
    low_m, high_m = terrain.lowest, terrain.highest
    step_m = (high_m - low_m) / _VALUES or 1.0
    solid = np.where(np.isnan(mesh), low_m, mesh)
    values = np.where(np.isnan(mesh), _VOID, np.rint((solid - low_m) / step_m))
    rows, columns = mesh.shape
    return {
        "name": terrain.name,
        "nodes": list(terrain.shape),
        "rows": rows,
        "columns": columns,
        "thinned": mesh.shape != terrain.shape,
        "width_m": terrain.width_m,
        "height_m": terrain.height_m,
        "low_m": low_m,
        "high_m": high_m,
        "step_m": step_m,
        "heights": _base64(values, "<u2"),
        "vertical": _vertical(terrain),
        "crs": terrain.crs,
    }


def zones_scene(zones: Iterable[Zone]) -> list[dict[str, Any]]:
    """Return zones in order, without the smallest if there are too many; see ``zones`` above."""
    from pathgene.host.report.zone_shapes import text

    tiles = tiles_of(zones)
    whole = [(some[0].whole, _rings(some[0].whole)) for some in tiles]
    kept: set[int] = set()
    corners = 0
    for index in sorted(range(len(whole)), key=lambda index: -_extent_m(whole[index][1][0])):
        corners += sum(map(len, whole[index][1]))
        if corners > _MOST_CORNERS and kept:
            break
        kept.add(index)
    return [
        {
            "name": zone.name,
            "text": text(zone),
            "rings": rings,
            "circle": _circle(zone),
            **dict(zip(("lower_m", "upper_m"), outermost(tiles[index]), strict=True)),
            "t0_s": zone.t0_s,
            "t1_s": zone.t1_s,
            "tiles": _tiles(tiles[index]),
        }
        for index, (zone, rings) in enumerate(whole)
        if index in kept
    ]


def _tiles(tiles: Sequence[Zone]) -> list[dict[str, Any]] | None:
    """Return tiles with their limits; None for a zone that is not divided."""
    if len(tiles) == 1:
        return None
    return [
        {"rings": _rings(tile), "circle": None, "lower_m": tile.lower_m, "upper_m": tile.upper_m}
        for tile in tiles
    ]


def path_scene(
    evaluator: Evaluator, path: Floats, name: str, *, least_m: float | None = None
) -> dict[str, Any]:
    """Return a path with its smoothed track; see ``paths`` above.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    least_m : float, optional
        Its minimum clearance, which is assigned to the sample at that place.
    """
    track = evaluator.track(path)
    samples = track.sample(max(track.length_m, 1.0) / _SAMPLES)
    lowest_m = evaluator.lowest_at_m(path)
    if lowest_m is not None:
        samples = _with_sample_at(samples, lowest_m)
    ground, highest, demanded = surface_and_demand(evaluator.problem, samples)
    clearance = samples.z - highest
    if lowest_m is not None and least_m is not None:
        clearance[np.searchsorted(samples.s, lowest_m)] = least_m
    return {
        "name": name,
        "waypoints": path.tolist(),
        "mission": None,
        "track": {
            "length_m": track.length_m,
            **columns_scene(samples, ground, clearance, demanded),
            "broken": [
                {"limit": each.limit, "from_m": each.from_m, "to_m": each.to_m}
                for each in broken_limits(evaluator, path, samples)
            ],
        },
    }


def columns_scene(
    samples: Samples, ground: Floats, clearance: Floats, demanded: Floats
) -> dict[str, Any]:
    """Return the arrays of a track, (k,) metres, and their size; see ``paths`` above."""
    columns = {
        "s": samples.s,
        "x": samples.x,
        "y": samples.y,
        "z": samples.z,
        "ground": ground,
        "clearance": clearance,
        "demanded": demanded,
    }
    arrays = {key: _base64(column, "<f4") for key, column in columns.items()}
    return {"samples": len(samples.s), **arrays}


def mission_scene(mission: HandedOver | None) -> dict[str, Any] | None:
    """Return a mission as an autopilot gets it; see ``paths`` above."""
    if mission is None:
        return None
    lines = {
        name: getattr(mission, name) for name in ("items", "legs", "way", "go_around", "rally")
    }
    return {
        **{name: np.round(line, 1).tolist() for name, line in lines.items()},
        "circles": [
            {
                "x": each.x_m,
                "y": each.y_m,
                "z": each.z_m,
                "radius_m": each.radius_m,
                "disc_m": each.disc_m,
            }
            for each in mission.circles
        ],
    }


def _thinned(heights: Floats) -> Floats:
    """Return the highest of the nodes around each node of the mesh; NaN if one is a void."""
    for axis, nodes in enumerate(heights.shape):
        if nodes <= MOST_NODES:
            continue
        places = np.linspace(0, nodes - 1, MOST_NODES)
        first = np.ceil((places[:-1] + places[1:]) / 2).astype(np.intp)
        heights = np.maximum.reduceat(heights, np.concatenate(([0], first)), axis=axis)
    return heights


def _vertical(terrain: Terrain) -> float:
    """Return the factor that makes a low relief visible."""
    relief = (terrain.highest - terrain.lowest) / max(terrain.width_m, terrain.height_m)
    return next((f for f in _FACTORS if f * relief >= _RELIEF), _FACTORS[-1])


def points_scene(problem: Problem) -> list[dict[str, Any]]:
    """Return the points that the path visits; see ``points`` above."""
    from pathgene.host.terrain.surface import surface_below

    names = mark_names(problem.way)
    x, y, _ = np.array(problem.way, dtype=np.float64).T
    ground = surface_below(problem.terrain, x, y).tolist()
    return [
        {
            "kind": name.split()[0].lower(),
            "name": name,
            "x": point[0],
            "y": point[1],
            "z": point[2],
            "ground_m": below if math.isfinite(below) else None,
        }
        for name, point, below in zip(names, problem.way, ground, strict=True)
    ]


def ceilings_scene(problem: Problem) -> list[dict[str, Any]]:
    """Return the ceilings that apply; empty with ``as_paper``."""
    if problem.rules is None:
        return []
    stated = (
        ("ceiling", problem.rules.ceiling_m, False),
        *((limit.label, altitude, False) for limit, altitude in line_limits(problem)),
        ("ceiling above ground", problem.rules.ceiling_agl_m, True),
    )
    return [
        {"name": name, "altitude_m": altitude, "agl": agl}
        for name, altitude, agl in stated
        if altitude is not None
    ]


def _circle(zone: Zone) -> dict[str, float] | None:
    """Return centre and radius of a circle, None for another zone."""
    disc = zone.footprint.disc
    return None if disc is None else dict(zip(("x", "y", "radius_m"), disc, strict=True))


def _rings(zone: Zone) -> list[list[list[float]]]:
    """Return the outline of a zone and then its holes, rounded to the decimetre."""
    rings = [np.array(ring) for ring in zone.footprint.outline(_CIRCLE_CORNERS)]
    if zone.footprint.disc is not None:  # It has few corners already.
        return [np.round(ring, 1).tolist() for ring in rings]
    return [_drawn(ring) for ring in rings]


def _drawn(ring: Floats) -> list[list[float]]:
    """Return a ring rounded to the decimetre, with fewer corners if it alone has too many."""
    every = math.ceil(len(ring) / (_MOST_CORNERS // 10))
    rounded: list[list[float]] = np.round(ring[::every], 1).tolist()
    return rounded


def _extent_m(ring: list[list[float]]) -> float:
    """Return the longer side of the box around a ring."""
    return float(np.ptp(np.array(ring), axis=0).max())


def _with_sample_at(samples: Samples, at_m: float) -> Samples:
    """Return samples with one inserted between its neighbours, unless there is one already."""
    place = int(np.searchsorted(samples.s, at_m))
    if place < len(samples.s) and samples.s[place] == at_m:
        return samples
    columns = (samples.s, samples.x, samples.y, samples.z, samples.ground, samples.clearance)
    return Samples(
        *(np.insert(column, place, np.interp(at_m, samples.s, column)) for column in columns)
    )


def _base64(values: NDArray[Any], kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
