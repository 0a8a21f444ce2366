"""Sentences on the files of a problem that were read: the ``read`` of a summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pathgene.host.remarks import Grade
from pathgene.host.terrain import embedded


__all__ = ["sentences", "terrain_in_words", "warnings_in"]


def warnings_in(summary: Mapping[str, Any]) -> list[str]:
    """Return the warnings in the ``read`` of a summary; none in a summary of an earlier version."""
    read = summary.get("read") or {}
    return [
        remark["text"]
        for part in read.values()
        for remark in part["remarks"]
        if remark["grade"] == Grade.WARNING
    ]


def sentences(read: Mapping[str, Any] | None) -> Iterator[str]:
    """Yield the report on files that were read, in sentences: the facts, then the remarks.

    A terrain of the package, or a grid of numpy's without a place on Earth, states metres and has
    warnings alone.

    Parameters
    ----------
    read : mapping, optional
        The value of ``read`` in a summary; None in a summary of an earlier version.
    """
    if read is None:
        return
    terrain = read["terrain"]
    described = terrain_in_words(terrain)
    if described:
        yield f"Terrain {described}."
    for part in (terrain, read["zones"]):
        for remark in part.get("remarks", ()):
            if described or part is not terrain or remark["grade"] == Grade.WARNING:
                yield f"{remark['grade'].capitalize()}: {remark['text']}"


def terrain_in_words(facts: Mapping[str, Any]) -> str:
    """Return the main facts of a terrain; empty for one that states metres alone."""
    is_file = facts.get("driver", "numpy") != "numpy"
    if not is_file and (facts.get("projection") is None or facts["source"] in embedded.names()):
        return ""
    rows, columns = facts["nodes"]
    east, north = facts["cell_m"].get("middle", facts["cell_m"]["used"])
    heights = facts["heights"]
    text = f"{facts['source']}: {rows} x {columns} nodes, cells of {east:.4g} x {north:.4g} m"
    place = facts["projection"]
    if place is not None:
        change = f", warped to {_short(place['frame'])}" if place["is_warped"] else ""
        text += f", {_short(place['file'])}{change}"
    return (
        f"{text}, heights of {heights['lowest_m']:g} to {heights['highest_m']:g} m above "
        f"{heights['datum']} (unit {heights['unit_from']}, datum {heights['datum_from']})"
    )


def _short(crs: str) -> str:
    """Return the name of a reference system, without the rest of its WKT."""
    name = crs.partition('"')[2].partition('"')[0]
    # A local frame has no name.
    return "local metres" if name == "unknown" else name or crs
