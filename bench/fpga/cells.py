"""Cells of a device that a design uses, by the tools' names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.hdl.boards.route import Routed


__all__ = ["CELLS", "XILINX", "Family", "chip_clock", "used"]

#: Columns of cells, in the order of :meth:`Family.count`.
CELLS = ("LUTs", "flip-flops", "block RAMs", "multipliers")


@dataclass(frozen=True)
class Family:
    """Cells of a family by their kind.

    Parameters
    ----------
    luts, registers, block_rams, multipliers : dict of str to int
        Kinds of cells, and how many LUTs, registers, block RAMs or multipliers each one counts for.
    """

    luts: Mapping[str, int]
    registers: Mapping[str, int]
    block_rams: Mapping[str, int]
    multipliers: Mapping[str, int]

    def count(self, cells: Mapping[str, int]) -> dict[str, Any]:
        """Return the numbers of :data:`CELLS`, given the number of cells of each kind."""
        kinds = (self.luts, self.registers, self.block_rams, self.multipliers)
        counts = (
            sum(weight * cells.get(cell, 0) for cell, weight in kind.items()) for kind in kinds
        )
        return dict(zip(CELLS, counts, strict=True))


# Counted as by nextpnr: a carry or a bit of LUT RAM takes a TRELLIS_COMB, like a LUT.
_ROUTED = {
    "ecp5": Family({"TRELLIS_COMB": 1}, {"TRELLIS_FF": 1}, {"DP16KD": 1}, {"MULT18X18D": 1}),
    "ice40": Family(
        {"ICESTORM_LC": 1},
        {},
        {"ICESTORM_RAM": 1, "ICESTORM_SPRAM": 1},
        {"ICESTORM_DSP": 1},
    ),
}
_LUTS = {f"LUT{inputs}": 1 for inputs in range(1, 7)}
# 16 rows of one bit take one LUT, 32 rows two; a memory with a second port stores its rows twice.
_LUT_RAMS = {"RAM16X1S": 1, "RAM16X1D": 2, "RAM32X1D": 2, "RAM64X1D": 2, "RAM32M": 4, "RAM64M": 4}
#: Cells of ``synth_xilinx``; block RAMs of 18 kbit.
XILINX = Family(
    {**_LUTS, **_LUT_RAMS, "SRL16E": 1, "SRLC32E": 1},
    dict.fromkeys(("FDRE", "FDSE", "FDCE", "FDPE"), 1),
    {
        **{f"RAMB16_S{a}_S{b}": 1 for a in (1, 2, 4, 9, 18, 36) for b in (1, 2, 4, 9, 18, 36)},
        "RAMB18": 1,
        "RAMB18E1": 1,
        "RAMB36": 2,
        "RAMB36E1": 2,
    },
    {"MULT18X18": 1, "MULT18X18S": 1, "DSP48E": 1, "DSP48E1": 1},
)


def used(routed: Routed, family: str) -> dict[str, Any]:
    """Return how many of :data:`CELLS` a routed design uses on a device of ``family``."""
    return _ROUTED[family].count({name: count for name, (count, _) in routed.cells.items()})


def chip_clock(routed: Routed) -> tuple[float, float]:
    """Return the achieved and the requested frequency of the chip's clock, MHz."""
    return min(routed.clocks.values(), key=lambda clock: clock[0] / clock[1])
