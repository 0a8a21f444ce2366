"""A comparison: loads the stored runs, executes the missing ones and stores them."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Generator, Sequence
from typing import TextIO

from pathgene.host import interrupts
from pathgene.host.compare.entrants import Entrant
from pathgene.host.compare.report import Field
from pathgene.host.compare.runs import Outcome, Task
from pathgene.host.compare.store import RunStore
from pathgene.host.progress import Bar


__all__ = ["Execute", "RunProgress", "complete", "kept"]

#: Executes tasks and yields outcomes as they arrive; closing it ends all tasks.
Execute = Callable[[Sequence[Task]], Generator[Outcome]]


class RunProgress:
    """Progress display of the runs: number done, best fitness, time left.

    Parameters
    ----------
    stream : TextIO
        As for :class:`pathgene.host.progress.Bar`.
    total, kept : int
        Total number of runs, and number of runs already stored.
    clock : callable
        Returns seconds.
    """

    def __init__(
        self, stream: TextIO, total: int, kept: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._bar = Bar(stream, total, clock)
        self._total, self._kept = total, kept
        self._clock = clock
        self._started_s = clock()
        self._done = self._failed = 0
        self._best = ""
        self._best_fitness = 0.0

    def begin(self) -> None:
        """Show the initial state: no run has ended yet."""
        self._show("")

    def update(self, outcome: Outcome) -> None:
        """Show that a run has ended."""
        self._done += 1
        if outcome.record is None:
            self._failed += 1
        elif outcome.record["fitness"] > self._best_fitness:
            self._best_fitness = outcome.record["fitness"]
            self._best = f"  best {self._best_fitness:.4f} by {outcome.task.entrant.label}"
        left = self._total - self._kept - self._done
        seconds = (self._clock() - self._started_s) / self._done * left
        says_left = left > 0 and not self._bar.shows_time_left
        self._show(f"  {_duration(seconds)} left" if says_left else "")

    def close(self) -> None:
        """End the line."""
        self._bar.close()

    def _show(self, left: str) -> None:
        done = self._kept + self._done
        failed = f"  {self._failed} failed" if self._failed else ""
        self._bar.show(done, f"run {done}/{self._total}{self._best}{failed}{left}")


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}"


def kept(store: RunStore, entrants: Sequence[Entrant], seeds: Sequence[int]) -> list[Field]:
    """Return the stored runs of each entrant."""
    fields = []
    for entrant in entrants:
        records = {seed: store.get(entrant, seed) for seed in seeds}
        fields.append(
            Field(entrant, {seed: record for seed, record in records.items() if record is not None})
        )
    return fields


def complete(
    fields: Sequence[Field], seeds: Sequence[int], store: RunStore, execute: Execute, stream: TextIO
) -> None:
    """Execute the runs that ``fields`` lacks; add each to ``store`` and to its field immediately.

    The planners take turns, so that they have run on the same seeds whenever the comparison ends.
    An exception ends all current runs.

    Raises
    ------
    JobError, InputError
        As ``execute`` and ``store`` do.
    """
    by_key = {part.entrant.key: part for part in fields}
    tasks = [
        Task(part.entrant, seed) for seed in seeds for part in fields if seed not in part.records
    ]
    if not tasks:
        return
    total = len(fields) * len(seeds)
    progress = RunProgress(stream, total, total - len(tasks))
    with contextlib.closing(progress), contextlib.closing(execute(tasks)) as outcomes:
        progress.begin()
        for outcome in outcomes:
            entrant, seed = outcome.task.entrant, outcome.task.seed
            part = by_key[entrant.key]
            if outcome.record is None:
                part.failures[seed] = outcome
            else:
                with interrupts.held():  # A stored run counts, too.
                    part.records[seed] = store.add(entrant, seed, outcome.record)
            progress.update(outcome)
