"""The files of a comparison: ``compare.json`` with runs and statistics, and a picture."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pathgene.host.compare.entrants import Entrant
from pathgene.host.compare.runs import Outcome
from pathgene.host.compare.statistics import compare_two, describe
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.problem.problem import Problem
from pathgene.host.report.summary import describe_problem, finite, version


__all__ = ["Field", "document", "write_report"]


@dataclass
class Field:
    """The runs of one entrant.

    Parameters
    ----------
    records : dict of int to dict
        Finished runs by seed.
    failures : dict of int to Outcome
        Failed runs by seed.
    """

    entrant: Entrant
    records: dict[int, dict[str, Any]] = field(default_factory=dict)
    failures: dict[int, Outcome] = field(default_factory=dict)

    def values(self) -> list[float]:
        """Return F of the finished runs, by seed."""
        return [self.records[seed]["fitness"] for seed in sorted(self.records)]


def document(
    problem: Problem,
    source: Mapping[str, Any],
    fields: Sequence[Field],
    seeds: Sequence[int],
    *,
    interrupted: bool = False,
) -> dict[str, Any]:
    """Return the whole report; every number in it is finite.

    Parameters
    ----------
    fields : sequence of Field
        All entrants, in the user's order.
    seeds : sequence of int
        Seeds of the runs of each entrant.
    interrupted : bool
        A signal ended the comparison before its last run.
    """
    report = {
        "pathgene": version(),
        **describe_problem(Evaluator(problem, threads=1), source),
        "seeds": [seeds[0], seeds[-1]],
        "paired": False,
        "interrupted": interrupted,
        "planners": [_planner(part) for part in fields],
        "pairs": [
            {
                "planners": [one.entrant.label, other.entrant.label],
                **compare_two(one.values(), other.values()),
            }
            for one, other in itertools.combinations(fields, 2)
        ],
    }
    return {key: finite(value) for key, value in report.items()}


def _planner(part: Field) -> dict[str, Any]:
    records = [part.records[seed] for seed in sorted(part.records)]
    # Stated once, above the runs.
    common = {"problem", "key", "pathgene", "planner", "options"}
    return {
        "label": part.entrant.label,
        **part.entrant.describe(),
        "statistics": describe(records),
        "failures": [
            {"seed": seed, "failure": part.failures[seed].failure} for seed in sorted(part.failures)
        ],
        "runs": [
            {key: value for key, value in record.items() if key not in common} for record in records
        ],
    }


def write_report(
    directory: Path, report: Mapping[str, Any], warn: Callable[[str], None], *, picture: bool = True
) -> list[Path]:
    """Write ``compare.json`` and, unless ``picture`` is false, ``compare.png``; return the paths.

    An error in the picture only causes a warning, because the numbers are still valid.

    Raises
    ------
    InputError
        If the directory cannot be written to.
    """
    numbers, drawing = directory / "compare.json", directory / "compare.png"
    with writing_into(directory):
        replace_files(directory, {numbers.name: json_bytes(report)}, gone=[drawing.name])
    if not picture:
        return [numbers]
    try:
        from pathgene.host.compare.picture import draw
        from pathgene.host.report.style import save

        save(draw(report), drawing)
    except Exception as error:
        warn(f"There is no picture this time, drawing it failed: {type(error).__name__}: {error}.")
        return [numbers]
    return [numbers, drawing]
