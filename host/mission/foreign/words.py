"""Faults and remedies in words, and as tables of a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from pathgene.host.mission.foreign.course import Chain, Handle, moved
from pathgene.host.mission.foreign.faults import Fault
from pathgene.host.mission.foreign.remedies import Remedy
from pathgene.host.problem.problem import Problem


__all__ = ["change_of", "counted", "fault_line", "where"]

_COMPASS = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)
# A faulty remedy names this number of other faults.
_MOST_BROKEN = 2


def counted(number: int, word: str) -> str:
    """Return a number of things in words, such as ``1 leg`` or ``2 legs``."""
    return f"{number} {word}" if number == 1 else f"{number} {word}s"


def where(chain: Chain, leg: int, *, is_leg: bool) -> str:
    """Return a leg or point in words, such as ``item 6 to 7``."""
    points = chain.points
    if not is_leg or leg + 1 >= len(points):
        return points[leg].name
    first, last = points[leg].name, points[leg + 1].name
    word, _, number = last.rpartition(" ")
    is_same = bool(word) and first.rpartition(" ")[0] == word
    return f"{first} to {number if is_same else last}"


def fault_line(
    chains: Sequence[Chain], fault: Fault, found: Remedy | None, problem: Problem
) -> str:
    """Return a fault with its place and remedy on one line."""
    x, y, _ = fault.place
    place = f"at ({x:.1f}, {y:.1f}) m"
    if problem.terrain.crs is not None:
        lat, lon = problem.terrain.to_geographic(x, y)
        place = f"at {lat:.6f}, {lon:.6f}"
    if fault.is_leg:
        place += f", {fault.span_m[0]:.0f} to {fault.span_m[1]:.0f} m along"
    at = where(chains[fault.chain], fault.leg, is_leg=fault.is_leg)
    return f"{at}: {_broken(fault)}, {place}; {_remedy(chains, fault, found, problem)}."


def _broken(fault: Fault) -> str:
    """Return the limit and the metres."""
    metres, allowed = f"{fault.metres:.1f} m", f"{fault.allowed:.4g} m"
    if fault.limit == "clearance":
        return f"clearance {metres} too low ({fault.value:.1f} m, required {allowed})"
    if fault.limit == "void":
        return "the ground is unknown (a void)"
    if fault.limit == "map":
        return f"{metres} beyond the edge of the map, where the ground is unknown"
    if fault.limit in ("climb", "descent"):
        return f"{fault.limit} {metres} too high ({fault.value:.1f} m, possible {allowed})"
    if fault.limit == "turn":
        if fault.value == 0:
            return f"turn back on itself, which takes a radius of {allowed}"
        return (
            f"turn too tight: {fault.value:.0f} m of radius, the aircraft needs {allowed}"
            f" ({metres} too short)"
        )
    if fault.limit.startswith("zone"):
        return f"{fault.limit} entered by {metres}, its margin of {allowed} included"
    return f"{fault.limit} {metres} too high ({fault.value:.1f} m, allowed {allowed})"


def _remedy(chains: Sequence[Chain], fault: Fault, found: Remedy | None, problem: Problem) -> str:
    """Return the remedy in words."""
    if found is None:
        if fault.limit == "turn":
            return f"a radius of {fault.allowed:.4g} m would do"
        if fault.limit == "void":
            return "fly around it, or fill the voids (--fill-voids)"
        if fault.limit == "map":
            return "give a terrain that reaches farther"
        last = chains[fault.chain].points[-1]
        if fault.limit == "clearance" and last.is_ground and last.handle is not None:
            ground_m = problem.terrain.ground(last.x_m, last.y_m)
            if last.z_m < ground_m:
                return f"give {last.name} the height of the ground there, {ground_m:.1f} m"
        return "no move of these items would do, so lead the mission another way"
    text = _move(chains, found, problem)
    if found.breaks:
        named = [
            f"{where(chains[each.chain], each.leg, is_leg=each.is_leg)} ({each.limit})"
            for each in found.breaks[:_MOST_BROKEN]
        ]
        return f"{text} would do, but breaks {' and '.join(named)}"
    return text


def _move(chains: Sequence[Chain], found: Remedy, problem: Problem) -> str:
    """Return a change in the imperative."""
    parts = _listed(chains, found.handles)
    if found.is_removal:
        return f"leave {parts} out"
    if found.up_m:
        return f"{'raise' if found.up_m > 0 else 'lower'} {parts} by {abs(found.up_m):.0f} m"
    metres = math.hypot(found.east_m, found.north_m)
    bearing = math.degrees(math.atan2(found.east_m, found.north_m)) + problem.north_deg
    compass = _COMPASS[round(bearing / 45) % 8]
    return f"move {parts} by {metres:.0f} m to the {compass} ({round(bearing) % 360} degrees)"


def _listed(chains: Sequence[Chain], handles: Sequence[Handle]) -> str:
    """Return parts of a mission in words, such as ``items 6 and 7``."""
    names = {point.handle: point.name for chain in chains for point in chain.points}
    parts = [
        "the height of the return (--return-height)" if handle[0] == "return" else names[handle]
        for handle in dict.fromkeys(handles)
    ]
    first, _, number = parts[0].rpartition(" ")
    if len(parts) == 2 and first == parts[1].rpartition(" ")[0]:
        return f"{first}s {number} and {parts[1].rpartition(' ')[2]}"
    return " and ".join(parts)


def change_of(chains: tuple[Chain, ...], found: Remedy, problem: Problem) -> dict[str, Any]:
    """Return a remedy as in the report: the parts, and their move or places."""
    parts = [
        "return" if kind == "return" else f"{kind} {number}"
        for kind, number in dict.fromkeys(found.handles)
    ]
    table: dict[str, Any] = {"of": parts}
    if found.is_removal:
        table["leave_out"] = True
    elif found.up_m:
        table["raise_m"] = found.up_m
    else:
        after = moved(chains, frozenset(found.handles), found.east_m, found.north_m)
        places = {point.handle: (point.x_m, point.y_m) for chain in after for point in chain.points}
        is_local = problem.terrain.crs is None
        table["places"] = [
            [*(places[handle] if is_local else problem.terrain.to_geographic(*places[handle]))]
            for handle in dict.fromkeys(found.handles)
        ]
    if found.breaks:
        table["breaks"] = [
            f"{where(chains[each.chain], each.leg, is_leg=each.is_leg)}: {each.limit}"
            for each in found.breaks
        ]
    return table
