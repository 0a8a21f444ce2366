"""The ladder of reasons, from limits that forbid every path to gaps that a search may miss."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pathgene.host.diagnosis.aircraft import (
    fuel_reasons,
    power_reasons,
    slope_reasons,
    stall_reasons,
)
from pathgene.host.diagnosis.barriers import Barrier, Ring
from pathgene.host.diagnosis.bounds import Bounds, zone_name
from pathgene.host.diagnosis.ends import edge_reasons, end_reasons
from pathgene.host.diagnosis.reason import Figure, Reason, geographic, listed
from pathgene.host.evaluation.aircraft_limits import SERVICE_CEILING
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


__all__ = ["diagnose"]

Flags = NDArray[np.bool_]

_EIGHT = np.ones((3, 3), dtype=bool)
_HALVINGS = 16


def diagnose(problem: Problem) -> Reason:
    """Return the reason why a problem has no path, or why the search finds none.

    In this order: start or goal violates a limit; zones, voids and the edge of the map enclose one
    of them; they do so below the ceilings; the climb or descent limit; power; fuel; a turn that the
    aircraft cannot fly. A reason of this list is proven: it never names a limit that some path
    keeps. Then come an end so near the edge of the map that the corridor hardly fits, and the same
    limits on the search surface, which are not proven. The last reason is
    that no path was found at this cell size, which is also the answer for a problem that has paths.

    Parameters
    ----------
    problem : Problem
        The problem; with ``as_paper``, ceilings, power and fuel are not limited.
    """
    bounds = Bounds(problem)
    reason = next(_reasons(bounds), None) or _not_found(problem)
    if reason.place is not None:
        reason = dataclasses.replace(reason, place_geo=geographic(problem.terrain, reason.place))
    if problem.headings != (None, None) and reason.code not in ("start", "goal"):
        # The track begins before the start or ends beyond the goal, perhaps across a barrier.
        reason = dataclasses.replace(reason, proven=False)
    return reason


def _reasons(bounds: Bounds) -> Iterator[Reason]:
    yield from end_reasons(bounds)
    yield from _closed(bounds)
    yield from _ceiling(bounds)
    slopes = list(slope_reasons(bounds))
    yield from (reason for reason in slopes if reason.proven)
    yield from power_reasons(bounds)
    yield from fuel_reasons(bounds)
    yield from stall_reasons(bounds)
    yield from edge_reasons(bounds.problem)
    yield from _too_narrow(bounds)
    yield from slopes


def _closed(bounds: Bounds) -> Iterator[Reason]:
    """Yield a reason if no route leads from start to goal at any altitude."""
    barrier = bounds.barrier()
    if not barrier.closed:
        return
    ring = barrier.ring()
    end, region = _enclosed(bounds, ring, math.inf)
    names = _names(bounds, ring)
    ways = f"{listed(names)} {'encloses' if len(names) == 1 else 'enclose'} the {end}"
    yield Reason(
        code="closed",
        sentence=f"No way leads from the start to the goal at any altitude: {ways}, and must open "
        f"near {_at(ring.place)}.",
        proven=True,
        zones=_zone_names(bounds, ring),
        place=ring.place,
        end=end,
        ring=ring.lines,
        region=region,
    )


def _ceiling(bounds: Bounds) -> Iterator[Reason]:
    """Yield a reason if no route leads from start to goal below the ceilings."""
    problem = bounds.problem
    rules, top = problem.rules, problem.limits.ceiling_m
    agl = math.inf if rules is None or rules.ceiling_agl_m is None else rules.ceiling_agl_m
    if top == math.inf and agl == math.inf:
        return
    barrier = bounds.barrier(top, agl)
    if not barrier.closed:
        return
    ring = barrier.ring()
    assert rules is not None
    end, region = _enclosed(bounds, ring, top)
    if bounds.barrier(top).closed:
        own = rules.ceiling_m is not None and rules.ceiling_m == top
        limit = "ceiling" if own else SERVICE_CEILING.name
        option = "--ceiling" if own else SERVICE_CEILING.label
        allowed, figure = top, _least_ceiling(bounds, top)
        below = f"below the {'ceiling' if own else SERVICE_CEILING.label} of {top:g} m"
    else:
        limit, option, allowed, figure = "ceiling-agl", "--ceiling-agl", agl, None
        below = f"below the ceiling of {agl:g} m above ground"
    names = _names(bounds, ring, high=True)
    would = (
        "" if figure is None else f"; a {option} of {figure:.0f} m would do for ground and zones"
    )
    yield Reason(
        code="ceiling",
        sentence=f"No way leads from the start to the goal {below}: near "
        f"{_at(ring.place)}, {listed(names)} {'leaves' if len(names) == 1 else 'leave'} no room"
        f"{would}.",
        proven=True,
        zones=_zone_names(bounds, ring),
        place=ring.place,
        figure=Figure(limit, allowed, figure, "m"),
        end=end,
        ring=ring.lines,
        region=region,
    )


def _least_ceiling(bounds: Bounds, top: float) -> float | None:
    """Return a ceiling, in whole metres, below which the search surface is connected."""
    problem = bounds.problem
    floor = np.where(problem.nofly_raster, np.nan, problem.surface.elevation)
    if problem.roof is not None:
        floor = np.where(floor <= problem.roof, floor, np.nan)
    low, high = top, float(np.nanmax(floor)) if np.isfinite(floor).any() else top
    if not _connected(problem, floor <= high):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _connected(problem, floor <= middle) else (middle, high)
    return math.ceil(max(high, problem.start[2], problem.goal[2]))


def _connected(problem: Problem, free: Flags) -> bool:
    """Return whether free nodes connect start and goal."""
    ends = [problem.terrain.nearest_nodes(x, y) for x, y, _ in (problem.start, problem.goal)]
    free = free.copy()
    for end in ends:
        free[end] = True
    part, _ = ndimage.label(free, _EIGHT)
    return bool(part[ends[0]] == part[ends[1]])


def _too_narrow(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that gaps are too narrow for the search, which blocks whole cells."""
    problem = bounds.problem
    if _connected(problem, ~problem.blocked_raster):
        return
    terrain = problem.terrain
    blocked = problem.blocked_raster.copy()
    for x, y, _ in (problem.start, problem.goal):
        blocked[terrain.nearest_nodes(x, y)] = False
    barrier = Barrier(
        terrain,
        problem.start,
        problem.goal,
        blocked,
        np.empty((0, 5)),
        np.empty(0, dtype=np.int64),
        diagonal=False,
    )
    if not barrier.closed:
        return
    ring = barrier.ring()
    names = _near_zones(bounds, ring)
    by = f": {listed(names)} leave no cell free" if names else ""
    yield Reason(
        code="not-found",
        sentence=f"No way was found at this cell size ({_cell(terrain)}): near {_at(ring.place)} "
        f"every gap is narrower than a cell{by}; try a finer terrain, or a smaller clearance, "
        "corridor or zone margin.",
        proven=False,
        zones=names,
        place=ring.place,
        ring=ring.lines,
    )


def _zone_names(bounds: Bounds, ring: Ring) -> tuple[str, ...]:
    """Return the names of all zones in a ring."""
    names = [zone_name(bounds.problem, index) for index in ring.zones]
    # The tiles of a zone have one name.
    return tuple(dict.fromkeys((*names, *_near_zones(bounds, ring, ring.zones))))


def _near_zones(bounds: Bounds, ring: Ring, known: tuple[int, ...] = ()) -> tuple[str, ...]:
    """Return the names of the zones not in ``known`` whose cells are in a ring of nodes."""
    row, column = ring.nodes.T
    names = [
        zone_name(bounds.problem, index)
        for index, zone in enumerate(bounds.problem.zones)
        if index not in known and bounds.cells(zone)[row, column].any()
    ]
    return tuple(dict.fromkeys(names))


def _not_found(problem: Problem) -> Reason:
    return Reason(
        code="not-found",
        sentence=f"No path was found at this cell size ({_cell(problem.terrain)}), and no limit "
        "was found that forbids every path; try more --generations, another --seed, a finer "
        "terrain or other ends.",
        proven=False,
    )


def _names(bounds: Bounds, ring: Ring, *, high: bool = False) -> list[str]:
    """Return the names of the parts of a ring."""
    names = []
    voids = bounds.problem.terrain.voids[tuple(ring.nodes.T)]
    if ring.edge_of_map and not high:
        names.append("the edge of the map")
    if voids.any():
        names.append("voids of the terrain")
    names += dict.fromkeys(zone_name(bounds.problem, index) for index in ring.zones)
    if not voids.all():
        near = _near_zones(bounds, ring, ring.zones)
        names += [name for name in near if name not in names]
        if high or not near:
            names.append("the ground")
    return names


def _enclosed(bounds: Bounds, ring: Ring, top: float) -> tuple[str, Flags]:
    """Return the end on the smaller side of a ring, and the nodes of that side."""
    problem, terrain = bounds.problem, bounds.problem.terrain
    free = np.isfinite(bounds.lowest) if top == math.inf else bounds.lowest <= top
    for index in ring.zones:
        free &= ~bounds.cells(problem.zones[index])
    if problem.rules is None:
        free &= ~problem.nofly_raster
    sides = {}
    for end in ("start", "goal"):
        x, y, _ = getattr(problem, end)
        node = terrain.nearest_nodes(x, y)
        own = free.copy()
        own[node] = True
        part, _ = ndimage.label(own)
        sides[end] = part == part[node]
    smaller = min(sides, key=lambda end: int(sides[end].sum()))
    return smaller, sides[smaller]


def _at(place: tuple[float, float]) -> str:
    return f"({place[0]:.0f}, {place[1]:.0f}) m"


def _cell(terrain: Terrain) -> str:
    if terrain.dx_m == terrain.dy_m:
        return f"{terrain.dx_m:g} m"
    return f"{terrain.dx_m:g} x {terrain.dy_m:g} m"
