"""Modes of the collision checker, for ``pathgene feasible``.

This module imports nothing, so that the command line lists the modes quickly.
"""

__all__ = ["MODES"]

#: Configuration of the chip for each mode. Boards built to order use the first mode by default.
#: ``detailed`` checks every segment against the detailed map, one cell per cycle.
MODES: dict[str, dict[str, str | int]] = {
    "two-tier": {"checker": "two-tier", "lanes": 1},
    "detailed": {"checker": "parallel", "lanes": 1},
    "parallel": {"checker": "parallel"},
}
