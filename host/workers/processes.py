"""Tasks in this process, or in several on this machine."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait
from typing import Any, TypeVar

from pathgene.host import interrupts
from pathgene.host.errors import JobError
from pathgene.host.machine import available_cores


__all__ = ["ending_children", "in_processes"]

# Maximum number of times that all processes are started, including restarts after a death.
_POOLS = 3

# Set in each process.
_state: Any
_function: Callable[[Any, Any], Any]

Data = TypeVar("Data")
State = TypeVar("State")
Task = TypeVar("Task")
Outcome = TypeVar("Outcome")


def in_processes(
    tasks: Sequence[Task],
    jobs: int,
    work: Callable[[State, Task], Outcome],
    prepare: Callable[[Data, int], State],
    data: Data,
) -> Generator[Outcome]:
    """Execute ``tasks``, ``jobs`` at a time; yield their outcomes as they arrive.

    A single job runs in this process. When a process dies, unfinished tasks start again in new
    processes. Closing the generator ends all processes immediately.

    Parameters
    ----------
    tasks : sequence
        Arguments of ``work``; they and the outcomes must be picklable.
    jobs : int
        Number of tasks executed at a time, 1 or more.
    work : callable
        A module-level function that returns the outcome, given a state and a task.
    prepare : callable
        A module-level function that returns the state of a process, given ``data`` and the number
        of threads that are its share of the cores.

    Raises
    ------
    JobError
        If processes die repeatedly, or none can be started.
    """
    threads = max(1, available_cores() // jobs)
    if jobs == 1:
        state = prepare(data, threads)
        yield from (work(state, task) for task in tasks)
        return
    left = dict(enumerate(tasks))
    for _ in range(_POOLS):
        with (
            contextlib.suppress(BrokenProcessPool),
            _pool(min(jobs, len(left)), work, prepare, data, threads) as pool,
        ):
            with interrupts.held():  # A process inherits this and never sees Ctrl-C.
                futures = {pool.submit(_work, task): number for number, task in left.items()}
            for future in as_completed(futures):
                outcome = future.result()
                del left[futures[future]]
                yield outcome
        if not left:
            return
    raise JobError(
        f"A process that ran planners died, {_POOLS} times; memory may be short, try "
        "fewer --jobs. Repeat the command to continue."
    )


@contextlib.contextmanager
def _pool(jobs: int, *arguments: Any) -> Iterator[ProcessPoolExecutor]:
    """Start processes that begin with ``arguments``; kill them if an exception leaves the block."""
    # Spawned, because a fork would copy the locks of threads that it does not copy.
    with interrupts.held():  # The tracker of its semaphores never sees Ctrl-C either.
        try:
            context = multiprocessing.get_context("spawn")
            pool = ProcessPoolExecutor(jobs, context, _begin, arguments)
        except OSError as error:
            # Its semaphores are files in /dev/shm.
            raise JobError(
                f"No processes can be started here ({error.strerror or error}); give --jobs 1, or "
                "make /dev/shm writable."
            ) from None
    try:
        with ending_children():
            yield pool
    finally:
        pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def ending_children() -> Iterator[None]:
    """Kill the processes that were started in the block when an exception leaves it."""
    others = multiprocessing.active_children()
    try:
        yield
    except BaseException:
        with interrupts.held():
            for process in multiprocessing.active_children():
                if process not in others:
                    process.kill()
        raise


def _begin(
    work: Callable[[Any, Any], Any], prepare: Callable[[Any, int], Any], data: Any, threads: int
) -> None:
    """Prepare a new process."""
    global _state, _function
    logging.basicConfig(format="pathgene: %(message)s")
    logging.getLogger("pathgene").setLevel(
        logging.INFO
    )  # Reports that a simulated board is being built.
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _state, _function = prepare(data, threads), work


def _end_with_parent() -> None:
    """Wait until the parent has died, by whatever cause, and then end this process."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait([parent.sentinel])
    os._exit(1)


def _work(task: Any) -> Any:
    return _function(_state, task)
