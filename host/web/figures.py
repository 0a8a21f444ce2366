"""The main figures of a summary, as a page states them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pathgene.host.report.routes import route_from, route_note


__all__ = ["captions", "figures"]


def _metres(value: float) -> str:
    return f"{value:,.0f} m" if abs(value) >= 100 else f"{value:.1f} m"


def _distance(value: float) -> str:
    return f"{value / 1000:,.2f} km" if value >= 2000 else _metres(value)


def _duration(value: float) -> str:
    minutes, seconds = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {seconds:02} s"


def _newtons(value: float) -> str:
    return f"{value:.3f} N"


# Key in the summary, label and text; a missing or null key has no figure.
_FIGURES: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("length_m", "Length", _distance),
    ("flight_time_s", "Flight time", _duration),
    ("minimum_clearance_m", "Least clearance", _metres),
    ("clearance_m", "Clearance asked", _metres),
    ("max_height_agl_m", "Greatest height", _metres),
    ("mean_altitude_m", "Mean altitude", _metres),
    ("fuel_N", "Fuel burned", _newtons),
    ("fuel_left_N", "Fuel left", _newtons),
    ("range_left_m", "Range left", _distance),
    ("fitness", "Fitness", lambda value: f"{value:.4f}"),
    ("generations", "Generations", lambda value: f"{value:,}"),
)


def figures(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the main figures of a summary: ``key``, ``label``, ``value``, ``text``.

    The legs of a mission follow with their lengths; the key of the first is ``legs.0.length_m``.
    """
    found = [
        {"key": key, "label": label, "value": summary[key], "text": text(summary[key])}
        for key, label, text in _FIGURES
        if isinstance(summary.get(key), int | float)
    ]
    for number, leg in enumerate(summary.get("legs") or ()):
        length_m = leg["length_m"] if leg["planned"] else None
        found.append(
            {
                "key": f"legs.{number}.length_m",
                "label": f"Leg {number + 1}",
                "value": length_m,
                "text": "not planned" if length_m is None else _distance(length_m),
            }
        )
    return found


def captions(summary: Mapping[str, Any]) -> tuple[str, str]:
    """Return the title of a plan, and a line with planner and aircraft."""
    named = {key: summary.get(key) or {} for key in ("terrain", "uav")}
    title = str(named["terrain"].get("name", "terrain"))
    by = str(summary.get("planner", "an unknown planner"))
    if board := summary.get("board"):
        by += f" on the board {board}"
    if fallback := summary.get("fallback"):
        by += f", {'in part ' if summary.get('legs') else ''}by its fallback {fallback}"
    if note := route_note(route_from(summary)):
        by += f", {note}"
    parts = [f"planned by {by}", str(named["uav"].get("name", "")), f"seed {summary.get('seed')}"]
    if wind := summary.get("wind"):
        east, north = wind
        if east or north:
            parts.append(f"wind {east:g} m/s to the east, {north:g} m/s to the north")
    parts.append(f"pathgene {summary.get('pathgene')}")
    return title, " · ".join(part for part in parts if part)
