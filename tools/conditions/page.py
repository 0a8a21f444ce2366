"""The table of the host's coverage in ``docs/reliability.md``."""

from __future__ import annotations

from collections.abc import Iterable

from tools.conditions.measure import Row
from tools.conditions.rooms import ROOT


__all__ = ["PAGE", "table_in", "write"]

PAGE = ROOT / "docs" / "reliability.md"
_BEGIN, _END = "<!-- coverage of the host -->\n\n", "\n<!-- end of the coverage of the host -->"
_HEADS = (
    ("room", "statements", "branches", "run", "decisions", "conditions", "with a pair"),
    ("---", "---:", "---:", "---:", "---:", "---:", "---:"),
)


def table_in(text: str) -> list[list[str]]:
    """Return the cells of the table in the text of the page, a list a room."""
    _, _, rest = text.partition(_BEGIN)
    lines = rest.partition(_END)[0].strip().splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[len(_HEADS) :]]


def write(rows: Iterable[Row]) -> None:
    """Replace the table of the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    lines = [*_HEADS, *map(_cells, rows)]
    table = "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
    PAGE.write_text(f"{before}{_BEGIN}{table}{_END}{after}", encoding="utf-8")


def _cells(row: Row) -> tuple[str, ...]:
    numbers = (row.decisions, row.conditions, row.paired)
    return (
        row.room.name,
        f"{row.statements:,}",
        f"{row.branches:,}",
        f"{row.percent:.1f} %",
        *(f"{number:,}" for number in numbers),
    )
