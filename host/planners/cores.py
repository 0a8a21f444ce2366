"""The chip that a planner needs: its genetic core, its population."""

from __future__ import annotations

from pathgene.hdl.config import Config, GeneticCore
from pathgene.host.errors import InputError


__all__ = ["require_chip"]


def require_chip(config: Config, core: GeneticCore, population: int | None) -> None:
    """Refuse a chip that has another genetic core than ``core``, or another population.

    Raises
    ------
    InputError
        If the chip is refused; ``population`` is None where any will do.
    """
    if config.genetic is GeneticCore.NONE:
        raise InputError(
            "This board has no genetic core, it only checks paths; use another board, "
            "or the planner ga-pc."
        )
    if config.genetic is not core and core is GeneticCore.STREAMING:
        raise InputError(
            "This board has no streaming genetic core, so it does not plan by itself; use another "
            "board, or the planner ga-fpga."
        )
    if config.genetic is not core:
        raise InputError(
            "This board has the streaming genetic core, which breeds without the host; use another "
            "board, or the planner ga-chip."
        )
    if population not in (None, config.population):
        raise InputError(
            f"The population of this board is {config.population}, not {population}; leave the "
            "population out (--population) or use another board."
        )
