"""Cells that a device family may supply instead of a primitive's generic description.

Synthesis leaves some registers of the hard cells of a family unused. A platform that can use them
has an attribute ``cells``, an instance of a subclass of :class:`Cells`; the board files set it. A
primitive asks :func:`cells_of`, and describes itself with registers and memories if the answer is
None, so that a core never names a device.

The copies of :func:`pathgene.hdl.primitives.logic.fanout` do not need a cell: their attribute
``keep`` suffices for a family's synthesis script to keep them apart.
"""

from amaranth.lib import wiring


__all__ = ["Cells", "cells_of"]


class Cells:
    """Cells of an unknown device, which has none. Families override the methods.

    Attributes
    ----------
    ram_style : str
        Kind of memory for long delays and tables, ``"distributed"`` or ``"block"``.
    """

    ram_style = "distributed"

    def memory(
        self, *, rows: int, width: int, ports: int, number: int | None
    ) -> wiring.Component | None:
        """Return a memory whose data come from registers within its block RAMs, or None.

        Its members are as in :class:`pathgene.hdl.primitives.storage.BlockMemory`.
        """
        return None

    def multiplier(
        self, widths: tuple[int, int], signs: tuple[bool, bool]
    ) -> wiring.Component | None:
        """Return a multiplier with a register at its output, or None.

        Parameters
        ----------
        widths : (int, int)
            Widths of the factors. The component may take wider ones: it has the members ``first``,
            ``second`` and ``product`` of :class:`pathgene.hdl.primitives.arithmetic.Multiplier`
            without a shift.
        signs : (bool, bool)
            Whether each factor is signed.
        """
        return None

    def add_subtract(self, width: int) -> wiring.Component | None:
        """Return a twin of :class:`pathgene.hdl.primitives.arithmetic.AddSubtract`, or None."""
        return None


_GENERIC = Cells()


def cells_of(platform: object) -> Cells:
    """Return the cells of ``platform``; in simulation, ``platform`` is None."""
    return getattr(platform, "cells", _GENERIC)
