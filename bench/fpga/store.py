"""Measured rows, in a file that is kept with the sources.

A row is stale when its digest no longer fits its sources. The digest covers the netlist up to names
(:class:`tools.netlist.Netlist`), options of the tools, seed, floor plan, and the versions of the
tools. In the floor plan, cells count by their place in the netlist. Renaming a unit or moving a
file therefore leaves a row valid; any other change of a circuit makes it stale.

Up to version 0.1.0 digests were digests of the text of the Verilog. The rows of that version got
their present digests without being measured again, and did so again when :mod:`tools.netlist`
learned to tell the ports of a memory by their wires: each time the sources of that version had been
shown to give the digest on record, and their netlists to equal today's up to names. The
iCEBreaker's chip and the genetic core alone, whose circuits had changed, were measured again.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench.fpga.job import Measured
from bench.report import Report


__all__ = ["Store", "Table"]


class Store:
    """Rows of all tables, by table and name; every change is written at once.

    Parameters
    ----------
    path : Path
        JSON; need not be there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read()

    def digest(self, table: str, name: str) -> str | None:
        """Return the digest of a measured row's sources, or None."""
        kept = self._tables.get(table, {}).get(name)
        return None if kept is None else str(kept["digest"])

    def rows(self, table: str) -> dict[str, dict[str, Any]]:
        """Return the rows of a table by their names."""
        return {name: kept["row"] for name, kept in self._tables.get(table, {}).items()}

    def keep(self, table: str, name: str, measured: Measured) -> None:
        """Keep a row, and the rows that another process has kept in the same file."""
        self._read()
        self._tables.setdefault(table, {})[name] = asdict(measured)
        self._path.write_text(json.dumps(self._tables, indent=1) + "\n", encoding="utf-8")

    def _read(self) -> None:
        self._tables: dict[str, dict[str, dict[str, Any]]] = (
            json.loads(self._path.read_text(encoding="utf-8")) if self._path.exists() else {}
        )


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of the results.

    Parameters
    ----------
    name, title : str
    columns : sequence of str
        Heads; the first is of the names of the rows.
    order : sequence of str
        Names of all rows.
    notes : sequence of str
    """

    name: str
    title: str
    columns: Sequence[str]
    order: Sequence[str]
    notes: Sequence[str] = ()

    def report(self, store: Store) -> Report:
        """Return the rows that are in ``store``; a note names the missing ones."""
        rows = store.rows(self.name)
        report = Report(self.title, self.columns, notes=list(self.notes))
        report.rows = [
            (name, *(rows[name][column] for column in self.columns[1:]))
            for name in self.order
            if name in rows
        ]
        missing = [name for name in self.order if name not in rows]
        if missing:
            report.notes.append(f"Not measured yet: {'; '.join(missing)}.")
        return report
