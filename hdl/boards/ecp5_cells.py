"""Cells of the ECP5 that the cores may take: block RAMs and multipliers with registers in them."""

from collections.abc import Sequence

from pathgene.hdl.boards.ecp5_add_subtract import Ecp5AddSubtract
from pathgene.hdl.boards.ecp5_memory import Ecp5Memory
from pathgene.hdl.boards.ecp5_multiplier import FACTOR_BITS, Ecp5Multiplier
from pathgene.hdl.primitives.cells import Cells


__all__ = ["Ecp5Cells"]

#: Maximum bits of a factor with which the product is left to logic: two or three additions are no
#: slower than the way to a multiplier and back. Wide products have such parts.
_NARROW = 3
#: Maximum bits of both factors, where logic is short.
_TINY = 8


class Ecp5Cells(Cells):
    """Cells of an ECP5.

    Parameters
    ----------
    sites : sequence of str
        Sites of block RAMs, in the order in which numbered memories take them; the placer chooses
        for those past the end, and for all where there are none.
    saves_logic : bool
        Takes multipliers for narrow products too, and block RAMs for long delays and tables: for a
        device that has more of them left than of logic.
    """

    def __init__(self, sites: Sequence[str] = (), *, saves_logic: bool = False) -> None:
        self.sites = tuple(sites)
        self.saves_logic = saves_logic
        self.ram_style = "block" if saves_logic else "distributed"

    def memory(self, *, rows: int, width: int, ports: int, number: int | None) -> Ecp5Memory:
        """Return a memory of DP16KD primitives; its sites follow the sites of smaller numbers."""
        sites = ()
        if number is not None:
            each = Ecp5Memory.primitives(rows=rows, width=width)
            sites = self.sites[number * each :][:each]
        return Ecp5Memory(rows=rows, width=width, ports=ports, sites=sites)

    def multiplier(
        self, widths: tuple[int, int], signs: tuple[bool, bool]
    ) -> Ecp5Multiplier | None:
        """Return a MULT18X18D, or None if a factor is too wide or too narrow for it."""
        is_small = sum(widths) <= _TINY if self.saves_logic else min(widths) <= _NARROW
        return None if is_small or max(widths) > FACTOR_BITS else Ecp5Multiplier(signs)

    def add_subtract(self, width: int) -> Ecp5AddSubtract:
        """Return a carry chain."""
        return Ecp5AddSubtract(width)
