"""Tables of the documentation, written from results that are stored with the project.

``docs/figures/NAME.json`` has the last kept report of the benchmark NAME:
``python -m bench NAME --keep`` writes it, together with every table in the pages that shows it. A
page marks the place: between the lines ``<!-- tables of BENCH=NAME -->`` and
``<!-- end of BENCH=NAME -->`` are all tables of the report, each under its title.
``<!-- tables of BENCH=NAME: TEXT -->`` is the place of the single table with TEXT in its title,
which is then shown without its title.

``python -m bench.pages`` writes all pages; a test checks that they equal the results.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from bench.report import Report
from pathgene.host.errors import InputError


_ROOT = Path(__file__).resolve().parents[1]
#: Folder of the kept reports, and folder of the pages that show them.
FIGURES, PAGES = _ROOT / "docs" / "figures", _ROOT / "docs"

_PLACE = re.compile(
    r"^<!-- tables of BENCH=(?P<name>[\w-]+)(?:: (?P<title>[^>]+?))? -->\n"
    r"(?P<tables>.*?)"
    r"^<!-- end of BENCH=(?P=name) -->$",
    re.MULTILINE | re.DOTALL,
)
#: Level of the headings of tables.
_LEVEL = 3


def keep(name: str, report: Report) -> Path:
    """Keep a report of a benchmark and write the pages that show it."""
    FIGURES.mkdir(exist_ok=True)
    path = report.write(FIGURES / f"{name}.json")
    write()
    return path


def keep_table(name: str, report: Report) -> Path:
    """Keep a table of a benchmark and no other table of it; write the pages."""
    path = FIGURES / f"{name}.json"
    content = json.loads(path.read_text("utf-8"))
    table = report.table()
    others = [each for each in content.get("further", ()) if each["title"] != report.title]
    content |= {**report.data, "further": [*others, table]}
    path.write_text(json.dumps(content, indent=1, default=float) + "\n")
    write()
    return path


def write() -> list[Path]:
    """Write the tables of all pages; return the pages that changed."""
    changed = []
    for page in pages():
        text = page.read_text("utf-8")
        written = render(text, page.name)
        if written != text:
            page.write_text(written, "utf-8")
            changed.append(page)
    return changed


def pages() -> list[Path]:
    """Return the pages that may show tables."""
    return sorted(PAGES.glob("*.md"))


def render(text: str, name: str) -> str:
    """Return the text of a page with its stored tables.

    Raises
    ------
    InputError
        If a table that the page ``name`` asks for is not stored, or a place has no end mark.
    """

    def tables(place: re.Match[str]) -> str:
        begin, _, _ = place[0].partition("\n")
        shown = _tables(place["name"], place["title"], name)
        return f"{begin}\n\n{shown}\n\n<!-- end of BENCH={place['name']} -->"

    written, places = _PLACE.subn(tables, text)
    if places != text.count("<!-- tables of BENCH="):
        raise InputError(
            f"{name} has a line <!-- tables of BENCH=NAME --> without <!-- end of BENCH=NAME -->."
        )
    return written


def _tables(bench: str, title: str | None, page: str) -> str:
    path = FIGURES / f"{bench}.json"
    if not path.exists():
        raise InputError(
            f"{page} shows BENCH={bench}, of which nothing is kept: "
            f"run python -m bench {bench} --keep."
        )
    content = json.loads(path.read_text("utf-8"))
    kept = [content, *content.get("further", ())]
    if title is None:
        return "\n\n".join(_table(each) for each in kept if each["rows"])
    for each in kept:
        if title in each["title"]:
            return _table(each).partition("\n\n")[2]
    titles = ", ".join(repr(each["title"]) for each in kept)
    raise InputError(f"{page} shows a table {title!r} of BENCH={bench}; there are {titles}.")


def _table(content: dict[str, Any]) -> str:
    columns = list(dict.fromkeys(column for row in content["rows"] for column in row))
    rows = [[row.get(column, "") for column in columns] for row in content["rows"]]
    return Report(content["title"], columns, [*rows], content["notes"]).text(_LEVEL).rstrip()


def main() -> int:
    """Write all pages."""
    try:
        for page in write():
            print(f"Wrote {page.relative_to(_ROOT)}.")
    except InputError as error:
        print(f"bench.pages: {error}", file=sys.stderr)
        return error.exit_status
    return 0


if __name__ == "__main__":
    sys.exit(main())
