"""Measure the coverage of the host's rooms that judge safety: ``python -m tools.conditions``."""

from __future__ import annotations

import argparse
import sys

from tools.conditions.measure import GROUPS, measure, rows
from tools.conditions.page import write


def main() -> int:
    """Run the tests, write the table into the documentation and say what is missing."""
    parser = argparse.ArgumentParser(prog="python -m tools.conditions", description=__doc__)
    parser.add_argument("--gaps", action="store_true", help="list all that the tests leave out")
    parser.add_argument("--last", action="store_true", help="run no test, take the last data")
    parser.add_argument("--only", choices=GROUPS, action="append", help="a group of tests to run")
    parser.add_argument("--workers", type=int, default=1, help="groups at a time (1)")
    options = parser.parse_args()
    if not options.last and not measure(options.only or GROUPS, options.workers):
        return 1
    found = rows()
    write(found)
    for row in found:
        print(
            f"{row.room.name}: {row.branches_run} of {row.branches} branches "
            f"({row.percent:.1f} %), "
            f"{row.paired} of {row.conditions} conditions with a pair"
        )
        if options.gaps or not row.is_enough:
            print(*(f"  {gap}" for gap in row.gaps), sep="\n")
    lacking = [row.room.name for row in found if not row.is_enough]
    if lacking:
        print(
            f"tools.conditions: {', '.join(lacking)}: the tests run too few branches, or leave a "
            "condition of the strict rule without a pair.",
            file=sys.stderr,
        )
    return int(bool(lacking))


if __name__ == "__main__":
    sys.exit(main())
