"""Many cases in several processes, and their outcomes."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from multiprocessing import get_context
from typing import Any

from tools.faults.case import Case, draw
from tools.faults.chips import Board, chip_names
from tools.faults.disk_judge import DiskJudge
from tools.faults.disk_sessions import DISK_SESSIONS
from tools.faults.judge import Judge, Verdict
from tools.faults.line_judge import LineJudge
from tools.faults.planted import planted


#: Number of cases that a process takes at a time.
_CHUNK = 10


@dataclass
class Campaign:
    """Cases that were run, with their outcomes."""

    #: Numbers of cases by session and by how they ended, and of faults that happened, by name.
    sessions: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    #: Cases that broke a promise, each with the broken promise.
    violations: list[tuple[Case, str]] = field(default_factory=list)

    def add(self, case: Case, verdict: Verdict) -> None:
        """Add a case."""
        self.sessions[case.session] += 1
        self.outcomes[verdict.outcome] += 1
        self.faults += verdict.faults
        if verdict.violation:
            self.violations.append((case, verdict.violation))

    def to_json(self) -> dict[str, Any]:
        """Return everything in a form for JSON."""
        return {
            "sessions": dict(self.sessions),
            "outcomes": dict(self.outcomes),
            "faults": dict(self.faults),
            "violations": [
                {"case": case.to_json(), "violation": text} for case, text in self.violations
            ],
        }


def sessions(board: Board) -> list[str]:
    """Return the names of the sessions for a kind of board, which take turns."""
    return [*chip_names(board), *(DISK_SESSIONS if board is Board.MODEL else ())]


@cache
def _line_judge(board: Board) -> LineJudge:
    return LineJudge(board)


def judge_of(board: Board, session: str) -> Judge:
    """Return this process's judge of a session."""
    return DiskJudge() if session in DISK_SESSIONS else _line_judge(board)


def case_of(board: Board, seed: int) -> Case:
    """Return the case of a seed."""
    names = sessions(board)
    name = names[seed % len(names)]
    judge = judge_of(board, name)
    return draw(seed, name, lambda work: judge.extent(name, work))


def _judge(board: Board, seeds: Sequence[int], bug: str | None) -> list[tuple[Case, Verdict]]:
    # Sessions without faults also run without bugs.
    cases = [case_of(board, seed) for seed in seeds]
    with planted(bug) if bug else contextlib.nullcontext():
        return [(case, judge_of(board, case.session).judge(case)) for case in cases]


def run(
    board: Board, seeds: Iterable[int], jobs: int, bug: str | None = None
) -> Generator[tuple[Case, Verdict]]:
    """Run the cases of ``seeds``, ``jobs`` at a time; yield them in order.

    ``bug`` is one of :data:`tools.faults.planted.PLANTED`.
    """
    numbers = list(seeds)
    chunks = [numbers[first : first + _CHUNK] for first in range(0, len(numbers), _CHUNK)]
    if jobs == 1:
        for chunk in chunks:
            yield from _judge(board, chunk, bug)
        return
    pool = ProcessPoolExecutor(jobs, get_context("spawn"))
    try:
        waiting = [pool.submit(_judge, board, chunk, bug) for chunk in chunks]
        for future in waiting:
            yield from future.result()
    finally:
        pool.shutdown(cancel_futures=True)
