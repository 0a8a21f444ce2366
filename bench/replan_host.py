"""The host's share of a replan by its parts: a profile of :mod:`pathgene.host.replanning`.

Functions are timed by wrappers, because a profiler doubles the time of code with many calls.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from statistics import median
from typing import Any
from unittest.mock import patch

from bench.replan_scenarios import draw_mission
from bench.report import Options, Report
from pathgene.host.device.chip import Chip
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Run
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.replanning import calibration
from pathgene.host.replanning.calibration import measure_host_s
from pathgene.host.replanning.departure import Departure
from pathgene.host.replanning.present import Present


#: Missions of the campaign of ``replan`` that are measured.
MISSIONS = (3, 15, 27, 39)

#: Parts, and the functions that are timed for each, without those inside them.
PARTS: dict[str, tuple[tuple[Any, str], ...]] = {
    "check of the current track": ((Present, "__init__"), (Present, "safe_until_m")),
    "problem from the departure": ((Departure, "problem"), (Evaluator, "__init__")),
    "map and record of the changed problem": ((ProblemOnChip, "changed"),),
    "commands and answers": ((ProblemOnChip, "run"),),
    "verdict on the straight line and the chip's paths": ((Run, "fitness"),),
    "result": ((Run, "result"),),
    "check of the new track": ((Departure, "joined"), (calibration, "fault_of")),
}

_REST = "the rest"


class Stopwatch:
    """Times the parts of replans, without the time in which the host waits.

    Attributes
    ----------
    replans : list of dict
        Seconds of each part, a dictionary for each replan.
    """

    def __init__(self) -> None:
        self.replans: list[dict[str, float]] = []
        self._chip: Chip | None = None
        self._inner_s = 0.0

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Replace the functions by timed ones."""
        with ExitStack() as stack:
            for part, functions in PARTS.items():
                for owner, name in functions:
                    timed = self._timed(getattr(owner, name), part)
                    stack.enter_context(patch.object(owner, name, timed))
            yield

    @contextmanager
    def watch(self, chip: Chip) -> Iterator[None]:
        """Time a replan on a chip."""
        self._chip, self._inner_s = chip, 0.0
        self.replans.append(dict.fromkeys((*PARTS, _REST), 0.0))
        began = self._now(chip)
        try:
            yield
        finally:
            self.replans[-1][_REST] = self._now(chip) - began - self._inner_s
            self._chip = None

    def _timed(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        @functools.wraps(function)
        def timed(*arguments: Any, **options: Any) -> Any:
            chip = self._chip
            if chip is None:
                return function(*arguments, **options)
            outer_s, self._inner_s = self._inner_s, 0.0
            began = self._now(chip)
            try:
                return function(*arguments, **options)
            finally:
                spent_s = self._now(chip) - began
                self.replans[-1][part] += spent_s - self._inner_s
                self._inner_s = outer_s + spent_s

        return timed

    @staticmethod
    def _now(chip: Chip) -> float:
        return time.perf_counter() - chip.link.traffic.waiting_s


def run(options: Options) -> Report:
    """Replan missions on the compiled model."""
    stopwatch = Stopwatch()
    with stopwatch.installed():
        for number in MISSIONS:
            measure_host_s(draw_mission(number), stopwatch.watch)
    report = Report(
        "The host's share of a replan by its parts",
        ("part", "ms, median", "ms, minimum"),
        notes=[
            f"{len(stopwatch.replans)} replans of {len(MISSIONS)} missions on the compiled model, "
            "by wall time, without the time in which the host waits for an answer."
        ],
    )
    for part in stopwatch.replans[0]:
        times = [1e3 * replan[part] for replan in stopwatch.replans]
        report.rows.append((part, median(times), min(times)))
    whole = [1e3 * sum(replan.values()) for replan in stopwatch.replans]
    report.rows.append(("all", median(whole), min(whole)))
    return report
