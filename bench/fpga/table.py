"""Tables of stored rows.

A row is stale when its digest no longer matches its sources. The digest covers the netlist up to
names (:class:`tools.netlist.Netlist`), options of the tools, seed, floor plan, and the versions of
the tools. In the floor plan, cells are identified by their place in the netlist. Renaming a unit or
moving a file therefore leaves a row valid; any other change of a circuit makes it stale.

Up to version 0.1.0 digests were digests of the text of the Verilog. The rows of that version got
their present digests without being measured again, and did so again when :mod:`tools.netlist`
learned to tell the ports of a memory by their wires: each time the sources of that version had been
shown to give the digest on record, and their netlists to equal today's up to names. The
iCEBreaker's chip and the paper core alone, whose circuits had changed, were measured again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bench.report import Report
from bench.store import Store


__all__ = ["Table", "rows"]


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of the results.

    Parameters
    ----------
    name, title : str
    columns : sequence of str
        Headings; the first belongs to the row names.
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
