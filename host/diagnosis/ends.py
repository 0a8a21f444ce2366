"""Limits that the start or the goal violates by itself."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.diagnosis.barriers import nearest_points
from pathgene.host.diagnosis.bounds import Bounds, is_permanent, zone_name
from pathgene.host.diagnosis.reason import Figure, Reason, rounded_down, rounded_up
from pathgene.host.evaluation.aircraft_limits import line_limits
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain.surface import surface_below


__all__ = ["edge_reasons", "end_reasons"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# A smaller excess is rounding.
_LEAST_M = 1e-3
_NUMBER_OF_HEADINGS = 720
_PLACES_ASIDE = 10


def end_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the limits that the start violates, then the limits that the goal violates."""
    if bounds.problem.rules is None:
        return
    for end in ("start", "goal"):
        point: Point = getattr(bounds.problem, end)
        yield from _ceilings(bounds.problem, end, point)
        yield from _zones(bounds, end, point)
        if bounds.problem.headings[0 if end == "start" else 1] is None:
            # With a heading, the track turns before the start or after the goal, and may not pass
            # through it.
            yield from _edges(bounds.problem, end, point, proven=True)
            yield from _sides(bounds.problem, end, point)


def edge_reasons(problem: Problem) -> Iterator[Reason]:
    """Yield the ends so near the edge of the map that the corridor fits at some headings only."""
    if problem.rules is not None:
        yield from _edges(problem, "start", problem.start, proven=False)
        yield from _edges(problem, "goal", problem.goal, proven=False)


def _reason(
    end: str, point: Point, sentence: str, figure: Figure, *zones: str, proven: bool = True
) -> Reason:
    return Reason(
        code=end,
        sentence=sentence,
        proven=proven,
        zones=zones,
        place=point[:2],
        figure=figure,
        end=end,
    )


def _ceilings(problem: Problem, end: str, point: Point) -> Iterator[Reason]:
    rules = problem.rules
    assert rules is not None
    x, y, z = point
    ceilings = (
        [] if rules.ceiling_m is None else [("ceiling", "the ceiling", rules.ceiling_m, False)]
    )
    for line, altitude in line_limits(problem):
        ceilings.append((line.name, line.words(problem), altitude, line.is_minimum))
    for limit, name, altitude, is_minimum in ceilings:
        beyond = altitude - z if is_minimum else z - altitude
        if beyond > _LEAST_M:
            would_do = rounded_down(z) if is_minimum else rounded_up(z)
            yield _reason(
                end,
                point,
                f"The {end} at {would_do:.1f} m is {rounded_up(beyond):.1f} m "
                f"{'below' if is_minimum else 'above'} {name}, {altitude:.1f} m.",
                Figure(limit, altitude, would_do, "m"),
            )
    if rules.ceiling_agl_m is not None:
        height = z - float(surface_below(problem.terrain, np.array([x]), np.array([y]))[0])
        if height > rules.ceiling_agl_m + _LEAST_M:
            yield _reason(
                end,
                point,
                f"The {end} is {rounded_up(height):.1f} m above the ground, "
                f"{rounded_up(height - rules.ceiling_agl_m):.1f} m more than the ceiling above "
                f"ground, {rules.ceiling_agl_m:.1f} m.",
                Figure("ceiling-agl", rules.ceiling_agl_m, rounded_up(height), "m"),
            )


def _zones(bounds: Bounds, end: str, point: Point) -> Iterator[Reason]:
    margin = bounds.margin_m
    _, _, z = point
    for index, zone in enumerate(bounds.problem.zones):
        if not (is_permanent(zone) or (end == "start" and zone.t0_s in (None, 0.0))):
            continue
        if zone.lower_m is not None and z < zone.lower_m - margin + _LEAST_M:
            continue
        if zone.upper_m is not None and z > zone.upper_m + margin - _LEAST_M:
            continue
        away = _distance_m(zone, point)
        if away < margin - _LEAST_M:
            away = rounded_down(away)
            name = zone_name(bounds.problem, index)
            above = zone.lower_m is not None and z < zone.lower_m
            below = zone.upper_m is not None and z > zone.upper_m
            where = f"under or beside {name}" if above else f"over or beside {name}"
            if not (above or below):
                where = f"{away:.1f} m from {name}"
            yield _reason(
                end,
                point,
                f"The {end} is {where}, within the zone margin of {margin:g} m; move the {end} "
                "or give a smaller --zone-margin.",
                Figure("zone-margin", margin, None if above or below else away, "m"),
                name,
            )


def _distance_m(zone: Zone, point: Point) -> float:
    """Return the distance of a point from a zone as seen from above, 0 inside."""
    x, y, _ = point
    if zone.covers(np.array([x]), np.array([y]))[0, 0]:
        return 0.0
    pieces = zone.footprint.capsules(0.0)
    on, at = nearest_points(
        pieces[:, :4], np.broadcast_to(np.array([x, y, x, y]), (len(pieces), 4))
    )
    return float((np.hypot(*(on - at).T) - pieces[:, 4]).min())


def _edges(problem: Problem, end: str, point: Point, *, proven: bool) -> Iterator[Reason]:
    """Yield the reason that the corridor leaves the map at an end.

    It is proven if the corridor does so whatever the heading, which it does only near a corner.
    """
    rules, terrain, (x, y, _) = problem.rules, problem.terrain, point
    assert rules is not None
    corridor_m = rules.corridor_m
    # Half the width of the corridor fits in x and in y.
    fits_x = min(x, terrain.width_m - x, corridor_m)
    fits_y = min(y, terrain.height_m - y, corridor_m)
    least = min(fits_x, fits_y)
    if least >= corridor_m - _LEAST_M:
        return
    if proven and math.hypot(fits_x, fits_y) >= corridor_m - _LEAST_M:
        return
    remedy = f"give --corridor {rounded_down(least):g}"
    if 2 * corridor_m <= min(terrain.width_m, terrain.height_m):
        inwards = rounded_up(math.hypot(corridor_m - fits_x, corridor_m - fits_y))
        remedy = f"move the {end} {inwards:.1f} m into the map or {remedy}"
    yield _reason(
        end,
        point,
        f"The {end} is {rounded_down(least):.1f} m from the edge of the map, and the corridor of "
        f"{corridor_m:g} m leaves the map there{', whatever the heading' if proven else ''}; "
        f"{remedy}.",
        Figure("corridor", corridor_m, rounded_down(least), "m"),
        proven=proven,
    )


def _sides(problem: Problem, end: str, point: Point) -> Iterator[Reason]:
    """Yield the reason that no heading avoids the ground or a void around an end."""
    rules, x, y, z = problem.rules, *point
    assert rules is not None
    if rules.corridor_m == 0:
        return
    demand = problem.demand
    angles: Floats = np.linspace(0.0, 2 * math.pi, _NUMBER_OF_HEADINGS, endpoint=False)
    aside = np.linspace(0.0, rules.corridor_m, _PLACES_ASIDE + 1)[1:]
    at_x = x + np.sin(angles)[:, None] * aside
    at_y = y + np.cos(angles)[:, None] * aside
    surface = surface_below(problem.terrain, at_x, at_y)
    # The clearance belongs to the track's own place.
    required = float(demand.required_m(np.array([x]), np.array([y]), beside=True)[0])
    with np.errstate(invalid="ignore"):  # There is no height for an end over a void.
        lacking: Floats = (surface + required - z).max(axis=1)
    half = _NUMBER_OF_HEADINGS // 2
    # A heading lacks as much height as the worse of its two sides. A heading in between may lack
    # less.
    by_heading = np.maximum(np.roll(lacking, -half // 2), np.roll(lacking, half // 2))
    by_heading = np.minimum(by_heading, np.minimum(np.roll(by_heading, 1), np.roll(by_heading, -1)))
    least = float(by_heading.min())
    if math.isinf(float(surface_below(problem.terrain, np.array([x]), np.array([y]))[0])):
        least = math.inf
    if least > _LEAST_M:
        if math.isinf(least):
            beside = f"A void of the terrain lies in the corridor of {rules.corridor_m:g} m"
            remedy = "fill the voids (--fill-voids)"
            figure = Figure("void", rules.clearance_m, None, "m")
        else:
            lift = rounded_up(least)
            beside = (
                f"The ground within the corridor of {rules.corridor_m:g} m is {lift:.1f} m too high"
            )
            remedy = f"raise the {end} by {lift:.1f} m"
            figure = Figure(f"{end}-altitude", z, rounded_up(z + lift), "m")
        yield _reason(
            end,
            point,
            f"{beside} beside the {end}, whatever the heading; {remedy}, move it or give a "
            "smaller --corridor.",
            figure,
        )
