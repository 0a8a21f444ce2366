"""The planners, by name: :mod:`pathgene.host.planners.registry` has the table. Light to import."""

from __future__ import annotations

from pathgene.host.planners.options import ENGINES, OPTIONS, Option
from pathgene.host.planners.registry import DEFAULT, PLANNERS, Entry, make


__all__ = ["DEFAULT", "ENGINES", "OPTIONS", "PLANNERS", "Entry", "Option", "make"]
