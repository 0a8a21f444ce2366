"""Configuration of a simulated chip, unless the URL of the board says otherwise."""

from __future__ import annotations

from pathgene.hdl.config import Config


__all__ = ["DEFAULT_CONFIG"]

#: Sizes of the chips of ``sim:`` and ``model:``. The UART divisor is the smallest that the receiver
#: allows, so that a byte takes few cycles to simulate.
DEFAULT_CONFIG = Config(clocks_per_bit=4)
