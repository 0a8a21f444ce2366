"""Tasks of a benchmark, measured in processes, also with an altered module."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, TypeVar

from pathgene.host.errors import PathgeneError
from pathgene.host.machine import available_cores


Task = TypeVar("Task", bound=tuple[Any, ...])
Measured = TypeVar("Measured")

# Seconds for which a worker may close its boards after an error in another one.
_PATIENCE_S = 5.0


def measure(
    bench: str,
    tasks: Sequence[Task],
    work: Callable[..., Measured],
    *,
    name: Callable[[Task], str],
    keep: Callable[[Task, Measured], None] | None = None,
    failed: Callable[[Task, PathgeneError], None] | None = None,
    prepare: Callable[..., None] | None = None,
    prepare_arguments: tuple[Any, ...] = (),
    spawned: bool = False,
    processes: int | None = None,
) -> list[Measured]:
    """Measure tasks in processes and return their results in the tasks' order.

    An error or an interrupt cancels the tasks that have not begun, and ends those that have.

    Parameters
    ----------
    tasks : sequence of tuple
        Arguments of ``work``.
    name : callable
        Returns the name under which the end of a task is reported. Tasks with the same name are
        reported once, when all of them are done.
    keep : callable, optional
        Called with a task and its result as soon as the result is available.
    failed : callable, optional
        Called with a task and its :class:`PathgeneError`; the task then has no result, and the
        campaign continues. By default such an error ends it.
    prepare : callable, optional
        Runs once in each process, for example to compile code before anything is timed.
    spawned : bool
        Start fresh processes instead of copies of this one: needed if this process has had threads,
        or if ``prepare`` alters sources.
    processes : int, optional
        Tasks at a time; one per core by default.
    """
    started, owner = time.monotonic(), os.getpid()
    results: dict[int, Measured] = {}
    left = Counter(map(name, tasks))
    groups = len(left)
    context = get_context("spawn") if spawned else None
    count = processes or available_cores()
    before = set(active_children())
    with ProcessPoolExecutor(count, context, prepare, prepare_arguments) as pool:
        try:
            jobs = {pool.submit(work, *task): number for number, task in enumerate(tasks)}
            for job in as_completed(jobs):
                number = jobs[job]
                task = tasks[number]
                try:
                    results[number] = job.result()
                except PathgeneError as error:
                    if failed is None:
                        raise
                    failed(task, error)
                else:
                    if keep is not None:
                        keep(task, results[number])
                group = name(task)
                left[group] -= 1
                if not left[group]:
                    del left[group]
                    minutes = (time.monotonic() - started) / 60
                    print(
                        f"{bench}: {group} ({groups - len(left)} of {groups}, {minutes:.1f} min)",
                        file=sys.stderr,
                        flush=True,
                    )
        except BaseException:
            if os.getpid() != owner:
                # A worker that was interrupted before its start, and is still a copy of its parent.
                os._exit(1)
            pool.shutdown(wait=False, cancel_futures=True)
            _end(set(active_children()) - before)
            raise
    return [results[number] for number in sorted(results)]


def _end(workers: Collection[BaseProcess]) -> None:
    """End processes: by an interrupt, so that they close their boards, and then by force."""
    for worker in workers:
        with contextlib.suppress(ProcessLookupError):
            os.kill(worker.pid or 0, signal.SIGINT)
    deadline = time.monotonic() + _PATIENCE_S
    for worker in workers:
        worker.join(max(deadline - time.monotonic(), 0.0))
        worker.kill()
        worker.join()


@dataclass(frozen=True)
class Alteration:
    """A text that occurs once in the source of a module, and its replacement."""

    module: str
    old: str
    new: str

    def apply(self, cache: Path) -> None:
        """Import the altered module in this process before anything else imports it.

        Kernels are compiled into ``cache``, so that the usual kernels are not affected.

        Raises
        ------
        ValueError
            If the module has already been imported, or does not have the text exactly once.
        """
        found = importlib.util.find_spec(self.module)
        if found is None or found.origin is None or self.module in sys.modules:
            raise ValueError(f"{self.module} cannot be altered")
        source = Path(found.origin).read_text(encoding="utf-8")
        if source.count(self.old) != 1:
            raise ValueError(f"{self.module} has {source.count(self.old)} times {self.old!r}")
        os.environ["NUMBA_CACHE_DIR"] = str(cache)
        altered = importlib.util.module_from_spec(found)
        sys.modules[self.module] = altered
        exec(compile(source.replace(self.old, self.new), found.origin, "exec"), vars(altered))
        package, _, name = self.module.rpartition(".")
        setattr(sys.modules[package], name, altered)
