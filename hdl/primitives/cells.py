"""Cells that a family of devices may supply in place of a primitive's generic description.

Synthesis leaves some registers of the hard cells of a family unused. A platform that can use them
has an attribute ``cells``, an instance of a subclass of :class:`Cells`; the board files set it. A
primitive asks :func:`cells_of` and describes itself in registers and memories where the answer is
None, so that a core never names a device.

The copies of :func:`pathgene.hdl.primitives.logic.fanout` do not need a cell: their attribute
``keep`` is enough for a family's synthesis script to leave them apart.
"""

from amaranth.lib import wiring


__all__ = ["Cells", "cells_of"]


class Cells:
    """Cells of an unknown device: none. Families override the methods.

    Attributes
    ----------
    ram_style : str
        Memories that long delays and tables take, ``"distributed"`` or ``"block"``.
    """

    ram_style = "distributed"

    def memory(
        self, *, rows: int, width: int, ports: int, number: int | None
    ) -> wiring.Component | None:
        """Return a memory whose data come out of registers within its block RAMs, or None.

        Parameters
        ----------
        rows, width, ports, number
            As in :class:`pathgene.hdl.primitives.storage.BlockMemory`; the component has the
            same members.
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
            The factors that have a sign.
        """
        return None

    def add_subtract(self, width: int) -> wiring.Component | None:
        """Return a component with the members of an adder that subtracts, or None.

        Parameters
        ----------
        width : int
            As in :class:`pathgene.hdl.primitives.arithmetic.AddSubtract`.
        """
        return None


_GENERIC = Cells()


def cells_of(platform: object) -> Cells:
    """Return the cells of ``platform``, which is None in simulation."""
    return getattr(platform, "cells", _GENERIC)
