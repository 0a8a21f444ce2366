"""Units of the limits in reports."""

from __future__ import annotations


__all__ = ["unit_of"]


def unit_of(limit: str) -> str:
    """Return the unit of a limit, given its name in a report."""
    # Loads the kernels.
    from pathgene.host.evaluation.aircraft_limits import limit_named

    own = limit_named(limit)
    return "m" if own is None else own.unit
