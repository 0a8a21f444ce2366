"""A table in Markdown and the same figures as JSON."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from textwrap import wrap
from typing import Any

from bench.store import digest


_NOTE_WIDTH = 120


@dataclass(frozen=True)
class Options:
    """Options of the command line."""

    #: Number of seeds of each terrain in statistical benchmarks.
    seeds: int = 40
    #: Number of seeds in benchmarks that repeat a table of 50 trials.
    trials: int = 50
    #: Part of the names of the rows to measure, for ``complete``, ``fpga``, ``flight``, ``quality``
    #: and ``safety``.
    only: str = ""
    #: Use the seeds that are kept for claims, for ``complete`` and ``untuned``.
    claimed: bool = False
    #: Folder of real flights, for ``autopilot``.
    flights: Path | None = None


@dataclass
class Report:
    """One benchmark's results."""

    title: str
    columns: Sequence[str]
    #: Cells, in the order of ``columns``; numbers are printed with at most 4 significant digits.
    rows: list[Sequence[Any]] = field(default_factory=list)
    #: Paragraphs below the table, in which lines are filled.
    notes: list[str] = field(default_factory=list)
    #: Additional content of the JSON.
    data: dict[str, Any] = field(default_factory=dict)
    #: True if a measurement failed; a note gives the reason.
    failed: bool = False
    #: Tables below this one, each with its own rows and notes.
    further: Sequence[Report] = ()

    def __post_init__(self) -> None:
        # The JSON has a row as a dictionary.
        assert len(set(self.columns)) == len(self.columns), self.columns

    def text(self, level: int = 2) -> str:
        """Return the tables in Markdown, with headings of the given level."""
        cells = [list(self.columns), *([_cell(value) for value in row] for row in self.rows)]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.columns))]
        lines = [f"| {' | '.join(map(str.ljust, row, widths))} |" for row in cells]
        lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
        notes = [line for note in self.notes for line in wrap(note, _NOTE_WIDTH)]
        own = "\n".join([f"{'#' * level} {self.title}", "", *lines, "", *notes])
        return "\n\n".join([own, *(report.text(level) for report in self.further)])

    def write(self, path: Path) -> Path:
        """Write the report as JSON, with its day, machine and digest of the sources."""
        further = [report._content() for report in self.further]
        content = self.table() | ({"further": further} if further else {})
        path.write_text(json.dumps(content | self.data, indent=1, default=float) + "\n")
        return path

    def table(self) -> dict[str, Any]:
        """Return the first table with its day, machine and digest of the sources."""
        machine = {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "python": platform.python_version(),
            "system": platform.system(),
        }
        sources = digest("bench", "hdl", "host", "sim")
        measured = {"date": datetime.now(UTC).date().isoformat(), "sources": sources, **machine}
        return {**self._content(), "measured": measured}

    def _content(self) -> dict[str, Any]:
        rows = [dict(zip(self.columns, row, strict=True)) for row in self.rows]
        return {"title": self.title, "rows": rows, "notes": self.notes}


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}"
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}"
    return str(value)


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
