"""``python -m tools.requirements``: write the tables of requirements, or check their rows."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pathgene.sim.cache import build_root
from tools.mutation.workshop import Workshop
from tools.requirements.checking import Known, verdict
from tools.requirements.table import FILES, PAGE, ROOT, all_rows, load, mistakes, with_tables


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the tables, or check rows; return 1 if an entry or a row is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tools.requirements", description=__doc__)
    parser.add_argument(
        "--check",
        nargs="*",
        metavar="ROW",
        help="plant the faults of these rows, such as rules-7, or of all, instead",
    )
    options = parser.parse_args(arguments)
    rows = {row.name: row for row in all_rows()}
    if unknown := set(options.check or ()) - rows.keys():
        parser.error(f"no row {', '.join(sorted(unknown))}; the rows are {', '.join(rows)}")
    found = [one for name in FILES for one in mistakes(load(name))]
    print(*found, sep="\n", file=sys.stderr, end="\n" if found else "")
    if options.check is None:
        PAGE.write_text(with_tables(PAGE.read_text("utf-8")), "utf-8")
        return 1 if found else 0
    folder = build_root() / "requirements"
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="work.", dir=folder) as work:
        shop = Workshop(ROOT, Path(work) / "copy", compiled=True)
        known: Known = {}
        for name in options.check or rows:
            said = verdict(shop, rows[name], known=known)
            print(said or f"{name}: {rows[name].fault} [{rows[name].test}]", flush=True)
            found += [said] if said else []
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
