"""Recorder of the program's results, to show that a change of the code does not affect them.

``python -m tools.record FILE.json`` records; ``--compare FILE.json`` records again, lists every
difference and exits with 1 if there is one. Floats are recorded exactly, so compare a record on the
machine that made it. ``--goldens`` writes the small record of the tests, which contains integers
and the terms of fixed paths and is valid on every machine.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import load
from tools.protocol_page.frames import golden_frames
from tools.recording import checksum, record_generations, record_paths


__all__ = ["GOLDENS", "GOLDEN_PARTS", "PARTS", "differences", "evaluate", "main"]

#: The committed record of the tests.
GOLDENS = Path(__file__).resolve().parents[1] / "tests" / "golden" / "golden.json"

#: The parts of a record, quick ones first.
PARTS: dict[str, Callable[[], dict[str, Any]]] = {
    "frames": golden_frames,
    "generations": record_generations,
    "paths": record_paths,
}

_GOLDEN_SEEDS = (1,)
_GOLDEN_CHIPS = ("default", "with map", "small with map")
_GOLDEN_EVERY = 10
_GOLDEN_PATHS = 300
_GOLDEN_BLOCK = 100


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 1 if something differs, otherwise 0."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.record", description="Record what the program computes."
    )
    parser.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE.json",
        help="file to write or, with --compare, to compare with",
    )
    parser.add_argument(
        "--compare",
        action="store_true",
        help="record again and list every difference from FILE.json",
    )
    parser.add_argument(
        "--only", choices=PARTS, metavar="PART", help=f"one part only: {', '.join(PARTS)}"
    )
    parser.add_argument(
        "--goldens", action="store_true", help="write the small record of the tests instead"
    )
    arguments = parser.parse_args(argv)
    if arguments.goldens == (arguments.file is not None):
        parser.error("give either FILE.json or --goldens")
    if arguments.goldens:
        kept = json.loads(GOLDENS.read_text())
        for fixed in kept["fitness"]:
            fixed["terms"] = evaluate(kept["problems"][fixed["map"]], fixed["path"])
        _write(GOLDENS, kept | {name: make() for name, make in GOLDEN_PARTS.items()})
        return 0
    # Fail before minutes of recording.
    before = json.loads(arguments.file.read_text()) if arguments.compare else None
    found = _record([arguments.only] if arguments.only else list(PARTS))
    if before is None:
        _write(arguments.file, found)
        return 0
    if arguments.only:
        before = {arguments.only: before[arguments.only]}
    differing = list(differences(before, found))
    plural = "" if len(differing) == 1 else "s"
    print(*differing, f"{len(differing)} difference{plural}", sep="\n")
    return 1 if differing else 0


def _record(parts: Sequence[str]) -> dict[str, Any]:
    found = {}
    for part in parts:
        started = time.monotonic()
        found[part] = PARTS[part]()
        print(f"{part}: {time.monotonic() - started:.0f} s", file=sys.stderr, flush=True)
    # JSON turns tuples into lists, as in a record read from a file.
    result: dict[str, Any] = json.loads(json.dumps(found, allow_nan=False))
    return result


def _write(file: Path, value: Any) -> None:
    file.write_text(json.dumps(value, indent=1, allow_nan=False) + "\n")


def differences(before: Any, after: Any, place: str = "") -> Iterator[str]:
    """Yield a line for every value that differs between two JSON documents."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in [*before, *(key for key in after if key not in before)]:
            where = f"{place}/{key}"
            if key not in after:
                yield f"{where}: gone"
            elif key not in before:
                yield f"{where}: new"
            else:
                yield from differences(before[key], after[key], where)
    elif isinstance(before, list) and isinstance(after, list):
        if len(before) != len(after):
            yield f"{place}: {len(before)} entries, now {len(after)}"
        for number, pair in enumerate(zip(before, after, strict=False)):
            yield from differences(*pair, f"{place}/{number}")
    # 1, 1.0 and true count as different.
    elif type(before) is not type(after) or before != after:
        yield f"{place}: {before!r}, now {after!r}"


def _golden_generations() -> dict[str, Any]:
    """Return every tenth population and all counters of some runs."""
    runs = record_generations(_GOLDEN_SEEDS, _GOLDEN_CHIPS)
    for run in runs.values():
        run["populations"] = run["populations"][_GOLDEN_EVERY - 1 :: _GOLDEN_EVERY]
    return runs


def _golden_paths() -> dict[str, Any]:
    """Return the CRC-32 of each build's results on a hundred paths."""
    return {
        title: [
            checksum(rows[first : first + _GOLDEN_BLOCK])
            for first in range(0, len(rows), _GOLDEN_BLOCK)
        ]
        for title, rows in record_paths(_GOLDEN_PATHS).items()
    }


def evaluate(problem: dict[str, Any], path: list[list[float]]) -> dict[str, float]:
    """Return every term of a path in metres over a problem of the tests' record."""
    zones = tuple(Circle(*circle) for circle in problem["circles"])
    ends = tuple(problem["start"]), tuple(problem["goal"])
    plane = aircraft.load("silver-fox")
    task = Problem(load(problem["terrain"]), *ends, plane, zones=zones, as_paper=True)
    terms = Evaluator(task, threads=1).evaluate(np.array(path)).to_dict()
    return {key: float(value) for key, value in terms.items()}


#: Parts of the tests' record that are integers. Its fixed paths and their problems stay.
GOLDEN_PARTS: dict[str, Callable[[], Any]] = {
    "generations": _golden_generations,
    "paths": _golden_paths,
}


if __name__ == "__main__":
    sys.exit(main())
