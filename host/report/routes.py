"""The planner whose route a plan of ``ga-chip`` has, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


__all__ = ["route_from", "route_note", "route_pairs"]


def route_from(summary: Mapping[str, Any]) -> str | None:
    """Return the planner whose route the path is: ``chip`` or ``astar``, or None if none says so.

    For a mission with routes of both it is ``chip and astar``.

    Parameters
    ----------
    summary : mapping
        ``summary.json`` of a plan, or one of its legs.
    """
    parts = summary.get("legs") or (summary,)
    found = {(part.get("hardware") or {}).get("route_from") for part in parts}
    return " and ".join(name for name in ("chip", "astar") if name in found) or None


def route_note(found: str | None) -> str:
    """Return a note on a route from :func:`route_from`; an empty text if it is only the chip's."""
    return "" if found in (None, "chip") else f"route of {found}"


def route_pairs(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the row of a table that says whose route the path of a single leg has, if any."""
    won = route_from(summary)
    if won is None or summary.get("legs"):
        return []
    chip, astar = (summary["hardware"]["routes"][name] for name in ("chip", "astar"))
    text = f"of {'the chip' if won == 'chip' else won}"
    if won == "astar":
        text += "; the chip's own " + (
            "is not feasible" if chip is None else f"has fitness {chip:.4f}"
        )
    elif astar is not None:
        text += f"; astar's has fitness {astar:.4f}"
    return [("route", text)]
