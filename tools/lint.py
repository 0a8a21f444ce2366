"""Verilator's lint of the generated Verilog: ``python -m tools.lint FILE.v ...``.

The top level of each file is the module with the file's name. ``tools/amaranth.vlt`` lists the
waived warnings with their reasons.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from pathgene.host.errors import PathgeneError
from pathgene.sim.verilator import run_verilator


WAIVERS = Path(__file__).parent / "amaranth.vlt"


def lint(path: Path) -> None:
    """Check one file with all warnings of Verilator.

    Raises
    ------
    JobError
        If there is a warning that is not waived; the exception's note has the warnings.
    """
    run_verilator(
        ["--lint-only", "-Wall", "--top-module", path.stem, WAIVERS, path.resolve()],
        cwd=path.resolve().parent,
        what=f"Lint of {path.name}",
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the files named on the command line; return the exit status."""
    paths = [Path(name) for name in (sys.argv[1:] if arguments is None else arguments)]
    if not paths:
        print("error: No Verilog file is given; name the files to check.", file=sys.stderr)
        return 2
    status = 0
    for path in paths:
        try:
            lint(path)
        except PathgeneError as error:
            print(*getattr(error, "__notes__", []), f"error: {error}", sep="\n", file=sys.stderr)
            status = error.exit_status
        else:
            print(f"{path}: clean")
    return status


if __name__ == "__main__":
    sys.exit(main())
