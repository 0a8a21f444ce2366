"""Description of a board."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from amaranth.build import Platform

from pathgene.hdl.boards.pll import Pll
from pathgene.hdl.config import Config


__all__ = ["Board", "ChipKind"]


class ChipKind(enum.StrEnum):
    """Kind of a chip, the value of ``make bitstream CHIP=``."""

    #: Chip that plans by itself: the planner core (:class:`pathgene.hdl.planner.core.PlannerCore`).
    PLANNER = "planner"
    #: Chip of the papers: paper core and checker, or the checker alone on a small device.
    PAPER = "paper"


@dataclass(frozen=True, kw_only=True)
class Board:
    """A board and one of its chips.

    Parameters
    ----------
    name : str
        Name in :data:`pathgene.hdl.boards.BOARDS`, shared by all chips of the board.
    platform : callable
        Makes the Amaranth platform: device, package, speed grade, pins, default clock, and
        ``cells`` if the family has any (:class:`pathgene.hdl.primitives.cells.Cells`).
    pll : Pll
        Makes the chip's clock from the platform's default clock.
    baud : int
        Rate of the UART, within the limit of the board's bridge.
    reset : (str, int)
        Resource of a pin that resets the chip while it is high.
    sizes : Config
        Sizes of the chip; ``clock_hz`` and ``clocks_per_bit`` there are ignored.
    seed : int
        First seed of the placer, with which timing is known to close.
    overrides : mapping
        Options of the platform's tools; see the documentation of the Amaranth platform.

    Raises
    ------
    ValueError
        If the divisor of the UART would be more than 1.25 % off, or the PLL breaks a limit.
    """

    name: str
    platform: Callable[[], Platform]
    pll: Pll
    baud: int = 3_000_000
    reset: tuple[str, int]
    sizes: Config = field(default_factory=Config)
    seed: int = 1
    overrides: Mapping[str, str] = field(default_factory=dict)

    #: Maximum error of the divisor: the receiver tolerates 2 %, part of which is left for the
    #: host's clock.
    BAUD_TOLERANCE = 0.0125

    def __post_init__(self) -> None:
        clocks = self.clock_hz / self.baud
        if abs(round(clocks) / clocks - 1) > self.BAUD_TOLERANCE:
            raise ValueError(
                f"Board.baud must divide the clock of {self.clock_hz} Hz within "
                f"{self.BAUD_TOLERANCE:.2%}, not {self.baud!r}"
            )

    @property
    def chip(self) -> ChipKind:
        """Kind of the chip."""
        return ChipKind.PLANNER if self.sizes.planner_core else ChipKind.PAPER

    @property
    def reference_hz(self) -> int:
        """Frequency of the board's oscillator."""
        return round(self.platform().default_clk_frequency)

    @property
    def clock_hz(self) -> int:
        """Frequency of the chip."""
        return self.pll.output_hz(self.reference_hz)

    @property
    def config(self) -> Config:
        """Configuration of the chip, with the clock and the divisor of this board."""
        return self.sizes.replace(
            clock_hz=self.clock_hz, clocks_per_bit=round(self.clock_hz / self.baud)
        )
