"""The jobs of the desk: plans in processes of their own, some at a time, the others in a queue."""

from __future__ import annotations

import contextlib
import multiprocessing
import secrets
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Literal

from numpy.typing import NDArray

from host import interrupts
from host.errors import InputError
from host.web.desk.worker import STOP, Ending, Failed, Found, Progressed, Saved, Task, work


__all__ = ["Job", "Jobs", "State"]

# After a stop, the longest wait for the end of a generation, and at the end of the desk for the
# choice of the path and the files.
_PATIENCE_S, _SAVING_S = 10.0, 60.0

#: See :class:`Job`.
State = Literal["waiting", "planning", "found", "saved", "failed"]


@dataclass(eq=False)
class Job:
    """A plan in the making, and what is known of it. Only the desk's threads write to it.

    Parameters
    ----------
    values : mapping
        Values of the problem.
    folder : Path
        Where it is saved; nothing is there before its state is ``saved``.

    Attributes
    ----------
    state : str
        ``waiting`` in the queue, ``planning``, ``found`` but not yet saved, ``saved``, ``failed``.
    rows : list of (int, float, float)
        Generation, best and mean fitness; only ever appended to.
    paths : list of (int, ndarray)
        Generation and best path, (n, 3) metres; only ever appended to.
    summary : dict or None
        The summary of the plan, once there is one.
    path : dict or None
        Its path as in a scene.
    notes : list of str
        What the files cannot say.
    error : str or None
        The sentence on why there is no plan, or no file of it.
    stopping : bool
        Its end has been requested.
    ending : bool
        Its search has ended for that.
    """

    values: Mapping[str, Any]
    folder: Path
    state: State = "waiting"
    rows: list[tuple[int, float, float]] = field(default_factory=list)
    paths: list[tuple[int, NDArray[Any]]] = field(default_factory=list)
    summary: dict[str, Any] | None = None
    path: dict[str, Any] | None = None
    notes: list[str] = field(default_factory=list)
    error: str | None = None
    stopping: bool = False
    ending: bool = False

    @property
    def done(self) -> bool:
        """True once nothing more comes."""
        return self.state in ("saved", "failed")

    def take(self, message: object) -> None:
        """Note a message of the process."""
        if isinstance(message, Progressed):
            # A page that sees a row sees its path, too.
            self.paths += message.paths
            self.rows += message.rows
        elif isinstance(message, Ending):
            self.ending = True
        elif isinstance(message, Found):
            self.summary, self.path, self.state = message.summary, message.path, "found"
        elif isinstance(message, Saved):
            self.notes, self.state = message.notes, "saved"
        elif isinstance(message, Failed):
            self.error, self.state = message.sentence, "failed"


class _Process:
    """A process that loads the planners and waits for a task."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection: Connection
        self.connection, other = context.Pipe()
        self.process: BaseProcess = context.Process(target=work, args=(other,), daemon=True)
        with interrupts.kept_from_children():
            self.process.start()
        other.close()

    def end(self) -> None:
        """Let it end by itself, as it does without a task."""
        self.connection.close()


class Jobs:
    """The jobs of a desk. One process is always ready, so that a plan starts at once.

    Parameters
    ----------
    directory : Path
        The folder in which each plan gets one.
    at_once : int
        Jobs that plan at a time, 1 or more.
    waiting : int
        Most jobs in the queue.

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
        self._queue: deque[Job] = deque()
        self._running: dict[Job, _Process] = {}
        self._threads: list[threading.Thread] = []
        self._closed = False
        self._spare = _Process()

    def submit(self, values: Mapping[str, Any], name: str) -> Job:
        """Plan a problem as soon as there is room; return its job.

        Parameters
        ----------
        values : mapping
            Values of the problem by the names in :data:`host.mission.keys.KEYS`.
        name : str
            What the folder of the plan is called besides the time.

        Raises
        ------
        InputError
            If too many jobs wait.
        """
        stamp = time.strftime("%Y%m%d-%H%M%S")
        job = Job(values, self._directory / f"{stamp}-{name}-{secrets.token_hex(2)}")
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
        """Let a job end with the best path so far; one in the queue ends without a plan."""
        with self._lock:
            job.stopping = True
            running = self._running.get(job)
            if running is None:
                with contextlib.suppress(ValueError):
                    self._queue.remove(job)
                    job.take(Failed("It was stopped before it began."))
                return
        with contextlib.suppress(OSError):
            running.connection.send(STOP)
        killer = threading.Timer(_PATIENCE_S, self._kill, (job,))
        killer.daemon = True
        killer.start()

    @property
    def active(self) -> list[Job]:
        """The jobs that plan or wait, in the order in which they came."""
        with self._lock:
            return [*self._running, *self._queue]

    def ahead_of(self, job: Job) -> int:
        """Return how many jobs wait before a waiting one."""
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
        """Start what there is room for; the lock is held."""
        while self._queue and len(self._running) < self._at_once and not self._closed:
            job = self._queue.popleft()
            if not self._spare.process.is_alive():
                self._spare = _Process()  # It was killed while it waited.
            self._running[job], self._spare = self._spare, _Process()
            job.state = "planning"
            thread = threading.Thread(target=self._run, args=(job, self._running[job]), daemon=True)
            self._threads = [each for each in self._threads if each.is_alive()] + [thread]
            thread.start()

    def _run(self, job: Job, process: _Process) -> None:
        """Receive what a process sends until it has ended, then start the next job."""
        try:
            process.connection.send(Task(job.values, job.folder))
            while not job.done:
                job.take(process.connection.recv())
        except (EOFError, OSError):
            reason = (
                "was stopped, and did not end" if job.stopping else "ended; memory may be short"
            )
            job.take(Failed(f"The process of this plan {reason}."))
        with self._lock:
            del self._running[job]
            self._start()
        # It may still draw the picture. Nothing is sent to it any more.
        process.process.join()
        process.connection.close()

    def _kill(self, job: Job) -> None:
        """End a process that has not heeded a stop; one that has is left to save its path."""
        with self._lock:
            running = self._running.get(job)
            if running is not None and job.state == "planning" and not job.ending:
                running.process.kill()
