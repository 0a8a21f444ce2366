"""Results that are kept with the project, and the tables of its pages that show them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench.sources import digest
from host.errors import InputError
from host.report.files import replacing


__all__ = ["Kept", "paste"]

Result = dict[str, Any]


class Kept:
    """Results by row and part of the row, in a JSON file that is committed.

    The file is written as soon as a result is there, so an interrupted run goes on where it was, on
    another machine, too. A result follows from sources: after a change of their code it counts as
    missing, and is replaced when it is measured again.

    Parameters
    ----------
    file : Path
        The file; without it there are no results.
    *sources : str
        Folders and files for :func:`bench.sources.digest`.

    Raises
    ------
    InputError
        If the file is not one of results.
    """

    def __init__(self, file: Path, *sources: str) -> None:
        self._file, self._sources = file, digest(*sources)
        try:
            text = file.read_text("utf-8")
        except FileNotFoundError:
            text = "{}"
        try:
            self._rows: dict[str, dict[str, Result]] = json.loads(text)
        except ValueError:
            raise InputError(f"{file} holds no results; remove it or restore it.") from None

    def get(self, row: str, part: str) -> Result | None:
        """Return the result of a part of a row; None if it is missing."""
        result = self._rows.get(row, {}).get(part)
        if result is None or result["sources"] != self._sources:
            return None
        return {key: value for key, value in result.items() if key != "sources"}

    def keep(self, row: str, part: str, result: Result) -> None:
        """Keep a result: a dictionary of what JSON can hold."""
        self._rows.setdefault(row, {})[part] = {"sources": self._sources, **result}
        with replacing(self._file) as file:
            file.write(self._text().encode())

    def _text(self) -> str:
        """Return the content of the file: a line a result."""
        rows = []
        for row, parts in sorted(self._rows.items()):
            lines = ",\n".join(
                f"  {json.dumps(part)}: {json.dumps(result, allow_nan=False)}"
                for part, result in sorted(parts.items())
            )
            rows.append(f" {json.dumps(row)}: {{\n{lines}\n }}")
        return "{\n" + ",\n".join(rows) + "\n}\n"


def paste(page: Path, name: str, tables: str) -> None:
    """Replace the tables of a page, between two comments that name the benchmark.

    Raises
    ------
    InputError
        If the page has not both comments, in this order.
    """
    begin, end = f"<!-- tables of BENCH={name} -->\n", f"<!-- end of BENCH={name} -->\n"
    before, opened, rest = page.read_text("utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not (opened and closed):
        raise InputError(
            f"{page.name} has no place for the tables: the lines {begin.strip()} and {end.strip()}."
        )
    page.write_text(f"{before}{opened}\n{tables}\n\n{closed}{after}", "utf-8")
