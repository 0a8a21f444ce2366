"""The conditions by which a mission is judged, from the values of options."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pathgene.host.mission.build import aircraft_of, rules_of
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["flight_problem_of"]

_NOWHERE = (0.0, 0.0, 0.0)


def flight_problem_of(
    values: Mapping[str, Any], terrain: Terrain, zones: Iterable[Zone]
) -> FlightProblem:
    """Return the problem by which a mission is judged.

    Parameters
    ----------
    values : mapping
        Aircraft, wind, rules and ``ds`` by the names in
        :data:`pathgene.host.options.table.OPTIONS`; None stands for the default.

    Raises
    ------
    InputError
        If a value is bad.
    """
    return FlightProblem(
        terrain,
        _NOWHERE,
        _NOWHERE,
        aircraft_of(values),
        tuple(zones),
        values.get("wind") or (0.0, 0.0),
        values.get("ds"),
        **rules_of(values),
    )
