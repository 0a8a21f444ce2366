"""Options with which a planner reports its own path, and not the route of another planner."""

from __future__ import annotations

from typing import Any

from pathgene.host.planners import PLANNERS


__all__ = ["own_path"]


def own_path(planner: str) -> dict[str, Any]:
    """Return the options: with its polish on, ``ga-chip`` may report the route of ``astar``."""
    return {"polish": "chip"} if "polish" in PLANNERS[planner].options else {}
