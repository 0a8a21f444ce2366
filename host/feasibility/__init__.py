"""The collision checker as a tool of its own: maps, paths and boards for ``pathgene feasible``.

Imports nothing, so that the command line can list the modes at once.
"""

__all__ = ["MODES"]

#: What each mode asks of the chip's configuration; the first is the default of boards built to
#: order. ``detailed`` takes every segment to the detailed map, a cell a clock.
MODES: dict[str, dict[str, str | int]] = {
    "two-tier": {"checker": "two-tier", "lanes": 1},
    "detailed": {"checker": "parallel", "lanes": 1},
    "parallel": {"checker": "parallel"},
}
