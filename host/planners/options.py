"""Constants of the options that several planners have."""

from __future__ import annotations


__all__ = ["DEFAULT_BOARD", "ENGINES"]

#: Engines of the planners that have a choice, the default first.
ENGINES = ("threads", "sequential", "gpu")

#: The board if none is named: the software model.
DEFAULT_BOARD = "model:"
