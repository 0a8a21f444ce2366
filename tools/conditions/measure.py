"""Measurement of the host's coverage: the tests, the rows of the table, and the gaps."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from tools.conditions.decisions import instrument
from tools.conditions.pairs import lacking
from tools.conditions.plugin import VARIABLE
from tools.conditions.rooms import LEAST_PERCENT, ROOMS, ROOT, Room, files_of, module_of


__all__ = ["GROUPS", "Row", "measure", "rows"]

_FOLDER = ROOT / "build" / "coverage" / "host"
_SETTINGS = _FOLDER / "settings"
_VERDICT = ("safe_flight", "strict_rule", "zones")
_MISSION_COMMANDS = ("batch", "check_missions", "ends", "export", "mend", "problem_files")
#: Tests that are measured, by the name of their group.
GROUPS = {
    "verdict": (
        *(f"tests/unit/evaluation/test_{name}.py" for name in _VERDICT),
        "tests/unit/flight/test_judge.py",
        "tests/unit/test_checking.py",
        "tests/unit/test_planning.py::test_check_reports_plain_numbers",
        "tests/unit/test_planning.py::test_refuses_a_path_with_other_ends",
        "tests/unit/test_planning.py::test_refuses_a_path_that_is_no_grid_of_real_numbers",
    ),
    "evaluation": (
        "tests/unit/evaluation",
        *(f"--ignore=tests/unit/evaluation/test_{name}.py" for name in _VERDICT),
    ),
    "problem": ("tests/unit/problem",),
    "terrain": ("tests/unit/terrain",),
    "formats": ("tests/unit/formats",),
    "mission": (
        *("-m", "not long"),
        "tests/unit/mission",
        *(f"tests/cli/test_{name}.py" for name in _MISSION_COMMANDS),
        "tests/unit/pathgene/test_api.py",
    ),
}
# Groups that plan, which would take hours without the compiler; their rooms have no kernels.
_COMPILED = ("mission",)
# Tests that would take minutes without the compiler, or that are about its speed or its types.
# Other tests run the same lines with fewer paths.
_EVALUATION = "tests/unit/evaluation/test"
_LEFT_OUT = (
    f"{_EVALUATION}_broken.py::test_agrees_with_the_verdict_on_random_paths",
    f"{_EVALUATION}_cost_base.py::test_costs_are_those",
    f"{_EVALUATION}_cost_base.py::test_planners_plan",
    f"{_EVALUATION}_evaluator.py::test_population_equals_its_paths[200-",
    f"{_EVALUATION}_evaluator.py::test_refuses_a_bad_path[evaluate]",
    f"{_EVALUATION}_evaluator.py::test_terms_are_plain_json_values",
    f"{_EVALUATION}_evaluator.py::test_the_first_feasible_path",
    *(
        f"{_EVALUATION}_kernels.py::test_fuel_by_the_series_and_in_closed_form[{slope}-"
        for slope in ("-0.3", "-0.07", "0.073", "0.2")
    ),
    f"{_EVALUATION}_kernels.py::test_kernels_match_the_reference",
    f"{_EVALUATION}_kernels.py::test_samples_on_straight_pieces",
    f"{_EVALUATION}_safe_flight.py::test_planner_avoids",
    f"{_EVALUATION}_sampling.py::test_quick_and_general",
    f"{_EVALUATION}_strict_rule.py::test_limits_touched_all_along",
    f"{_EVALUATION}_strict_rule.py::test_no_path_along_the_edge",
    f"{_EVALUATION}_strict_rule.py::test_samples_find_paths",
    f"{_EVALUATION}_zones.py::test_a_long_path_among_many_zones",
    f"{_EVALUATION}_zones.py::test_a_zone_counts_for_the_parts_of_an_arc_in_wind",
    f"{_EVALUATION}_zones.py::test_cells_that_are_not_blocked",
    f"{_EVALUATION}_zones.py::test_polygon_of_many_corners",
    "tests/unit/formats/test_ed318_rules.py::test_random_documents",
    "tests/unit/formats/test_large_files.py",
    "tests/unit/problem/test_planned_zones.py",
    "tests/unit/problem/test_planted_zone_faults.py",
    "tests/unit/problem/test_many_corners.py",
    "tests/unit/terrain/test_intake.py",
)
# Kinds of decisions without an outcome, as the recorder names them.
_KINDS = ("arrays", "choices")


@dataclass(frozen=True)
class Row:
    """The figures of a room, and its lines, branches and conditions that tests leave out."""

    room: Room
    statements: int
    branches: int
    branches_run: int
    decisions: int
    conditions: int
    paired: int
    gaps: tuple[str, ...]

    @property
    def percent(self) -> float:
        """Share of the branches that tests run, rounded down to a tenth."""
        return 1000 * self.branches_run // self.branches / 10

    @property
    def is_enough(self) -> bool:
        """True if the room has the branches, and where needed the pairs, that it must have."""
        has_pairs = self.paired == self.conditions or not self.room.needs_pairs
        return self.percent >= LEAST_PERCENT and has_pairs


def measure(groups: Collection[str] = GROUPS.keys(), workers: int = 1) -> bool:
    """Run groups of tests, with the compiler off for kernels; True if all of them pass.

    Their data go to ``build/coverage/host/``; the data of other groups stay.
    """
    _FOLDER.mkdir(parents=True, exist_ok=True)
    files = [file for room in ROOMS for file in files_of(room)]
    # The settings of the project name other folders.
    _SETTINGS.write_text("\n    ".join(("[run]\nbranch = true\ninclude =", *files)) + "\n")
    with ThreadPoolExecutor(workers) as pool:
        return all(list(pool.map(_run, groups)))


def _run(group: str) -> bool:
    files = [file for room in ROOMS for file in files_of(room)]
    is_compiled = group in _COMPILED
    if is_compiled:
        files = [file for file in files if "/evaluation/" not in file]
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": str(int(not is_compiled)),
        VARIABLE: "\n".join((str(_FOLDER / f"{group}.vectors"), *map(module_of, files))),
    }
    command = [
        *(sys.executable, "-m", "coverage", "run", f"--rcfile={_SETTINGS}"),
        f"--data-file={_FOLDER / group}.data",
        *("-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "tools.conditions.plugin"),
        *(*GROUPS[group], *(f"--deselect={test}" for test in _LEFT_OUT)),
    ]
    return subprocess.run(command, cwd=ROOT, env=environment).returncode == 0


def rows() -> list[Row]:
    """Return the rows of the table by the data of all groups."""
    coverage = (sys.executable, "-m", "coverage")
    data, report = _FOLDER / "all", _FOLDER / "report.json"
    each = [str(_FOLDER / f"{group}.data") for group in GROUPS]
    for command in (
        ("combine", "--keep", f"--data-file={data}", *each),
        ("json", f"--data-file={data}", "-o", str(report)),
    ):
        verb, *arguments = command
        options = (f"--rcfile={_SETTINGS}", "-q")
        subprocess.run([*coverage, verb, *options, *arguments], cwd=ROOT, check=True)
    files = json.loads(report.read_text())["files"]
    recorded = [json.loads((_FOLDER / f"{group}.vectors").read_text()) for group in GROUPS]
    return [_row(room, files, recorded) for room in ROOMS]


def _row(room: Room, files: dict[str, Any], recorded: list[dict[str, Any]]) -> Row:
    arrays, choices = ({key for each in recorded for key in each[kind]} for kind in _KINDS)
    statements = branches = branches_run = decisions = conditions = missing = 0
    gaps: list[str] = []
    for file in files_of(room):
        summary = files[file]["summary"]
        statements += summary["num_statements"]
        branches += summary["num_branches"]
        branches_run += summary["covered_branches"]
        gaps += [f"{file}:{line}: not run" for line in files[file]["missing_lines"]]
        gaps += [
            f"{file}:{line}: never goes to {f'line {to}' if to > 0 else 'the end'}"
            for line, to in files[file]["missing_branches"]
        ]
        module, source = module_of(file), (ROOT / file).read_text(encoding="utf-8")
        for decision in instrument(module, source)[1]:
            key, is_choice = decision.key, decision.key in choices
            if key in arrays:
                continue
            vectors = {
                (tuple(values), outcome)
                for each in recorded
                for values, outcome in each["vectors"].get(key, ())
            }
            without = lacking(decision, vectors, is_choice=is_choice)
            decisions += 1
            conditions += len(decision.conditions) - is_choice
            missing += len(without)
            gaps += [
                f"{file}:{decision.line}: no pair for {decision.conditions[i]}" for i in without
            ]
    paired = conditions - missing
    return Row(room, statements, branches, branches_run, decisions, conditions, paired, tuple(gaps))
