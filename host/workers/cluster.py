"""Tasks on a Dask cluster."""

from __future__ import annotations

import contextlib
import importlib
import logging
import pickle
import uuid
from collections.abc import Callable, Generator, Iterator, Sequence
from typing import Any, TypeVar

from pathgene.host import interrupts
from pathgene.host.errors import InputError, JobError
from pathgene.host.workers import LOCAL
from pathgene.host.workers.processes import ending_children


__all__ = ["on_cluster"]

Data = TypeVar("Data")
State = TypeVar("State")
Task = TypeVar("Task")
Outcome = TypeVar("Outcome")

_CONNECT_TIMEOUT_S = 10
# Maximum restart time of a lost worker of the local cluster. Dask's 15 seconds are too short for a
# busy machine, and without workers no run would ever end.
_PATIENCE = "1 hour"
# Longest wait for the workers to end, after the last run and after Ctrl-C.
_CLOSE_TIMEOUT_S, _INTERRUPT_TIMEOUT_S = 10.0, 1.0


def on_cluster(
    tasks: Sequence[Task],
    address: str,
    jobs: int,
    work: Callable[[State, Task], Outcome],
    prepare: Callable[[Data, int], State],
    data: Data,
    *,
    name: Callable[[Task], str],
    failed: Callable[[Task, str], Outcome],
) -> Generator[Outcome]:
    """Execute ``tasks`` on a Dask cluster; yield their outcomes as they arrive.

    The workers need this version of pathgene, but no files of this machine: data and tasks are sent
    by value. If a worker is lost, another one repeats its task; a task that loses four workers in a
    row counts as failed.

    Parameters
    ----------
    tasks, work, prepare, data
        As for :func:`pathgene.host.workers.processes.in_processes`; a worker has one thread.
    address : str
        Address of the scheduler, ``tcp://HOST:PORT``; :data:`LOCAL` starts a local cluster.
    jobs : int
        Number of workers of the local cluster.
    name : callable
        Returns a name of a task for the cluster's displays.
    failed : callable
        Returns the outcome of a task that the cluster could not execute, given the reason.

    Raises
    ------
    InputError
        If distributed is not installed, or no scheduler answers.
    JobError
        If the scheduler is lost.
    """
    distributed = _distributed()
    with contextlib.ExitStack() as stack:
        if address == LOCAL:
            stack.enter_context(ending_children())
            dask = importlib.import_module("dask.config")
            stack.enter_context(dask.set({"distributed.deploy.lost-worker-timeout": _PATIENCE}))
            address = stack.enter_context(_local_cluster(distributed, jobs))
        client = stack.enter_context(_client(distributed, address))
        stack.enter_context(client.as_current())
        # A task instead of scattered data, because the scheduler can repeat it if its worker is
        # lost.
        sent = client.submit(pickle.loads, pickle.dumps(data), key=f"data-{uuid.uuid4()}")
        futures = {
            client.submit(
                _work, work, prepare, sent, task, key=f"{name(task)}-{uuid.uuid4()}"
            ): task
            for task in tasks
        }
        for future in distributed.as_completed(list(futures)):
            if future.status == "finished":
                yield future.result()
            else:
                yield failed(futures[future], _reason(client, future, address))


def _work(
    work: Callable[[Any, Any], Any], prepare: Callable[[Any, int], Any], data: Any, task: Any
) -> Any:
    return work(prepare(data, 1), task)


def _distributed() -> Any:
    try:
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise InputError(
            "A Dask cluster needs the package distributed; install "
            "pathgene[cluster], or leave --scheduler out."
        ) from None
    # Distributed logs every connection; the errors that matter become messages of the command.
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)
    return distributed


@contextlib.contextmanager
def _local_cluster(distributed: Any, jobs: int) -> Iterator[str]:
    """Start a cluster of processes on this machine; yield its address."""
    with interrupts.held():  # The workers inherit this and never see Ctrl-C.
        cluster = distributed.LocalCluster(
            n_workers=0,
            threads_per_worker=1,
            processes=True,
            silence_logs=logging.CRITICAL,
            scheduler_kwargs={"dashboard": False},
        )
    wait_s = _CLOSE_TIMEOUT_S
    try:
        cluster.scale(jobs)
        yield cluster.scheduler_address
    except BaseException:
        wait_s = _INTERRUPT_TIMEOUT_S
        raise
    finally:
        cluster.shutdown_on_close = False  # Prevents a second call at interpreter exit.
        with contextlib.suppress(TimeoutError):
            cluster.close(timeout=wait_s)


def _client(distributed: Any, address: str) -> Any:
    try:
        return distributed.Client(address, timeout=_CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"No Dask scheduler answers at {address!r} ({error}); start one with "
            "'dask scheduler', or give 'local'."
        ) from None


def _reason(client: Any, future: Any, address: str) -> str:
    """Return why the cluster could not execute the task of a future."""
    if client.status != "running" or future.status == "cancelled":
        raise JobError(
            f"The Dask scheduler at {address!r} is lost; repeat the command to continue."
        )
    error = future.exception()
    return f"The cluster could not do it, {type(error).__name__}: {error}"
