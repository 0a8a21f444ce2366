"""The planners by name; :mod:`pathgene.host.planners.registry` has the table."""

from __future__ import annotations

from pathgene.host.planners.registry import (
    DEFAULT,
    DEFAULT_BOARD,
    DEFAULT_TEXT,
    ENGINES,
    PLANNERS,
    Entry,
    asks_hardware,
    default_planner,
    make,
    named_or_default,
)


__all__ = [
    "DEFAULT",
    "DEFAULT_BOARD",
    "DEFAULT_TEXT",
    "ENGINES",
    "PLANNERS",
    "Entry",
    "asks_hardware",
    "default_planner",
    "make",
    "named_or_default",
]
