"""The planners by name; :mod:`pathgene.host.planners.registry` has the table."""

from __future__ import annotations

from pathgene.host.planners.options import DEFAULT_BOARD, ENGINES
from pathgene.host.planners.registry import DEFAULT, ON_PAPER_CORE, PLANNERS, Entry, make


__all__ = ["DEFAULT", "DEFAULT_BOARD", "ENGINES", "ON_PAPER_CORE", "PLANNERS", "Entry", "make"]
