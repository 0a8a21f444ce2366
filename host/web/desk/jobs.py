"""Runs the jobs of the desk in separate processes: a few plans at a time, more in a queue."""

from __future__ import annotations

import contextlib
import multiprocessing
import queue
import secrets
import threading
import time
from collections import deque
from collections.abc import Mapping
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from pathgene.host import interrupts
from pathgene.host.errors import InputError
from pathgene.host.web.desk.flight import ENDED
from pathgene.host.web.desk.job import FlightJob, Job, MendJob, PlanJob, SavedJob
from pathgene.host.web.desk.messages import STOP, Failed
from pathgene.host.web.desk.worker import work


__all__ = ["Jobs"]

# Longest wait for the end of a generation after a stop, and for the choice of the path and the
# files at the end of the desk.
_PATIENCE_S, _SAVING_S = 10.0, 60.0
# Maximum flights at a time, and maximum missions that are mended at a time.
_MOST_FLIGHTS = _MOST_MENDED = 4
_STOPPED = "Mending was stopped; the mission is as before."


class _Process:
    """A process that loads the planners and waits for a task."""

    def __init__(self) -> None:
        self._outbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        context = multiprocessing.get_context("spawn")
        self.connection: Connection
        self.connection, other = context.Pipe()
        self.process: BaseProcess = context.Process(target=work, args=(other,), daemon=True)
        with interrupts.kept_from_children():
            self.process.start()
        other.close()

    def begin(self, task: object) -> None:
        """Give the process its task."""
        self.tell(task)
        # A process that does not read only blocks this thread.
        threading.Thread(target=self._post, daemon=True).start()

    def tell(self, message: object) -> None:
        """Send a message after all earlier ones."""
        self._outbox.put(message)

    def _post(self) -> None:
        with contextlib.suppress(OSError):
            while (message := self._outbox.get()) is not None:
                self.connection.send(message)

    def end(self) -> None:
        """Let the process end by itself, as it does without a task."""
        self._outbox.put(None)
        self.connection.close()


class Jobs:
    """The jobs of a desk. One process is always ready, so that a plan starts immediately.

    Parameters
    ----------
    directory : Path
        The folder in which each plan gets a subfolder.
    at_once : int
        Number of jobs that plan at a time, 1 or more.
    waiting : int
        Maximum jobs in the queue.

    Raises
    ------
    InputError
        If ``at_once`` is below 1.
    """

    def __init__(self, directory: Path, *, at_once: int = 2, waiting: int = 16) -> None:
        if at_once < 1:
            raise InputError(f"The desk must do 1 job at a time or more, not {at_once} (--jobs).")
        self._directory, self._at_once, self._most_waiting = directory, at_once, waiting
        self._lock = threading.Lock()
        self._queue: deque[PlanJob] = deque()
        self._running: dict[Job, _Process] = {}
        self._threads: list[threading.Thread] = []
        self._closed = False
        self._spare = _Process()

    def fly(self, job: FlightJob) -> None:
        """Start a flight; it neither waits for other jobs nor delays plans.

        Raises
        ------
        InputError
            If too many flights are in progress, or the same plan is already being flown.
        """
        with self._lock:
            flights = [each for each in self._running if isinstance(each, FlightJob)]
            if self._closed:
                raise InputError("The desk is ending.")
            if any(each.folder == job.folder for each in flights):
                raise InputError("This plan is flown already; Saved plans shows its flight.")
            if len(flights) >= _MOST_FLIGHTS:
                raise InputError(f"{len(flights)} flights are in progress, the maximum; end one.")
            self._begin(job)

    def mend(self, job: MendJob) -> None:
        """Mend a mission; it neither waits for other jobs nor delays plans.

        Raises
        ------
        InputError
            If too many missions are being mended.
        """
        with self._lock:
            mended = sum(isinstance(each, MendJob) for each in self._running)
            if self._closed:
                raise InputError("The desk is ending.")
            if mended >= _MOST_MENDED:
                raise InputError(f"{mended} missions are being mended, the maximum; wait for one.")
            self._begin(job)

    def tell(self, job: Job, message: object) -> None:
        """Send a message to the process of a job, if there still is one."""
        with self._lock:
            if job in self._running:
                self._running[job].tell(message)

    def submit(
        self, values: Mapping[str, Any], name: str, *, statement: str | None = None
    ) -> PlanJob:
        """Plan a problem as soon as there is room; return its job.

        Parameters
        ----------
        values : mapping
            Values of the problem by the names in :data:`pathgene.host.options.table.OPTIONS`.
        name : str
            Second part of the plan folder's name, after the time.
        statement : str, optional
            As for :class:`PlanJob`.

        Raises
        ------
        InputError
            If too many jobs wait.
        """
        stamp = time.strftime("%Y%m%d-%H%M%S")
        folder = self._directory / f"{stamp}-{name}-{secrets.token_hex(2)}"
        job = PlanJob(folder, values=values, statement=statement)
        with self._lock:
            if self._closed or len(self._queue) >= self._most_waiting:
                raise InputError(
                    f"{len(self._queue)} plans are waiting, and no more may; wait for one, or "
                    "stop one."
                )
            self._queue.append(job)
            self._start()
        return job

    def stop(self, job: Job) -> None:
        """Let a plan end with its best path. Other jobs and queued plans end without a result."""
        with self._lock:
            job.stopping = True
            if job not in self._running:
                if isinstance(job, PlanJob) and job in self._queue:
                    self._queue.remove(job)
                    job.take(Failed("It was stopped before it began."))
                return
            if isinstance(job, MendJob):
                # There is no result until the end.
                self._running[job].process.kill()
                return
        self.tell(job, STOP)
        killer = threading.Timer(_PATIENCE_S, self._kill, (job,))
        killer.daemon = True
        killer.start()

    @property
    def active(self) -> list[SavedJob]:
        """The flights, and the jobs that plan or wait, in order of submission."""
        with self._lock:
            running = [job for job in self._running if isinstance(job, SavedJob)]
            return [*running, *self._queue]

    def ahead_of(self, job: PlanJob) -> int:
        """Return how many jobs wait before a given waiting job."""
        with self._lock, contextlib.suppress(ValueError):
            return self._queue.index(job)
        return 0

    def close(self) -> None:
        """Stop all jobs, and wait until the best path of each is saved."""
        with self._lock:
            self._closed = True
            left = [*self._queue, *self._running]
            threads = list(self._threads)
        for job in left:
            self.stop(job)
        deadline = time.monotonic() + _SAVING_S
        for thread in threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        with self._lock:
            for process in self._running.values():
                process.process.kill()
            self._spare.end()

    def _start(self) -> None:
        """Start as many jobs as there is room for. The lock is held."""
        while self._queue and self._plans < self._at_once and not self._closed:
            self._begin(self._queue.popleft())

    @property
    def _plans(self) -> int:
        return sum(isinstance(job, PlanJob) for job in self._running)

    def _begin(self, job: Job) -> None:
        """Give a job the spare process; the lock is held."""
        if not self._spare.process.is_alive():
            self._spare = _Process()  # The process was killed while it waited.
        self._running[job], self._spare = self._spare, _Process()
        job.state = job.at_work
        self._running[job].begin(job.task)
        thread = threading.Thread(target=self._run, args=(job, self._running[job]), daemon=True)
        self._threads = [each for each in self._threads if each.is_alive()] + [thread]
        thread.start()

    def _run(self, job: Job, process: _Process) -> None:
        """Receive the messages of a process until it has ended, then start the next job."""
        try:
            while not job.done:
                job.take(process.connection.recv())
        except (EOFError, OSError):
            reason = (
                "was stopped, and did not end" if job.stopping else "ended; memory may be short"
            )
            sentence = f"The process of this {job.word} {reason}."
            if job.stopping and isinstance(job, FlightJob | MendJob):
                sentence = ENDED if isinstance(job, FlightJob) else _STOPPED
            job.take(Failed(sentence))
        with self._lock:
            del self._running[job]
            self._start()
        # The process may still be drawing the picture. It gets no more messages.
        process.process.join()
        process.end()

    def _kill(self, job: Job) -> None:
        """Kill a process that did not respond to a stop; one that did may still save its path."""
        with self._lock:
            running = self._running.get(job)
            if running is not None and job.state == job.at_work and not job.ending:
                running.process.kill()
