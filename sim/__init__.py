"""Bit-exact software model of the chip, and simulated boards that run the chip's Verilog."""

from __future__ import annotations

from pathgene.hdl.config import Config


__all__ = ["DEFAULT_CONFIG"]

#: Sizes of the chips of ``sim:`` and ``model:``, unless the URL says otherwise. The UART divisor is
#: the smallest that the receiver allows, so that a byte takes few simulated cycles. A chip with the
#: planner core has a byte-wide port instead: :func:`pathgene.sim.chip_url.chip_of`.
DEFAULT_CONFIG = Config(clocks_per_bit=4)
