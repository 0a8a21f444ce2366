"""The process of a job: it plans a problem and saves the plan, flies one, or mends a mission."""

from __future__ import annotations

import contextlib
import importlib
import os
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from pathgene.host.errors import PathgeneError
from pathgene.host.planners.base import Stop
from pathgene.host.web.desk.flight import FlyTask, fly
from pathgene.host.web.desk.mending import MendTask, mend_mission
from pathgene.host.web.desk.messages import STOP, Ending, Failed, Saved, Sender


__all__ = ["Found", "PlanTask", "Progressed", "work"]

# The page of the desk has priority if there are few cores.
_NICENESS = 10
_HEEDED_POLL_S = 0.05
# Time between two progress messages: more often than any page draws.
_PERIOD_S = 1 / 30


@dataclass(frozen=True)
class PlanTask:
    """A problem to plan.

    Parameters
    ----------
    values : mapping
        Its values by the names in :data:`pathgene.host.options.table.OPTIONS`.
    """

    values: Mapping[str, Any]
    folder: Path


@dataclass(frozen=True)
class Progressed:
    """Generations since the last message.

    Parameters
    ----------
    rows : list of (int, float, float)
        Generation, best fitness of all generations, mean fitness.
    paths : list of (int, ndarray)
        Generation and best path, (n, 3) metres, of each generation that improves the path.
    """

    rows: list[tuple[int, float, float]]
    paths: list[tuple[int, NDArray[Any]]]


@dataclass(frozen=True)
class Found:
    """The end of a search; its plan is not saved yet.

    Parameters
    ----------
    path : dict
        Its path as in a scene: see :func:`pathgene.host.web.scene.path_scene`.
    """

    summary: dict[str, Any]
    path: dict[str, Any]


def work(connection: Connection) -> None:
    """Wait for a task on ``connection``, execute it, and send its results.

    If the desk closes its end, a search ends as after :data:`pathgene.host.web.desk.messages.STOP`,
    and its plan is saved.
    """
    os.nice(_NICENESS)
    # Loaded before the task arrives.
    for name in ("mission.planning", "web.scene", "web.desk.saving"):
        importlib.import_module(f"pathgene.host.{name}")

    try:
        task = connection.recv()
    except EOFError:
        return
    sender = Sender(connection)
    try:
        if isinstance(task, FlyTask):
            fly(task, connection, sender)
        elif isinstance(task, MendTask):
            threading.Thread(target=_end_with, args=(connection,), daemon=True).start()
            mend_mission(task, sender)
        else:
            _plan(task, connection, sender)
    except PathgeneError as error:
        sender.send(Failed(str(error)))
    except Exception as error:
        sender.send(Failed(f"Internal error, {type(error).__name__}: {error}; please report it."))
    connection.close()


def _end_with(connection: Connection) -> None:
    """End this process as soon as the desk has ended: there is nothing to save."""
    with contextlib.suppress(EOFError, OSError):
        connection.recv()
    os._exit(1)


def _plan(task: PlanTask, connection: Connection, sender: Sender) -> None:
    from pathgene.host.mission.autopilot.hand_over import choices_of
    from pathgene.host.mission.build import mission_of, search_of
    from pathgene.host.mission.drawn import mission_of_plan
    from pathgene.host.mission.planning import plan_mission
    from pathgene.host.web.desk.saving import draw_picture, save
    from pathgene.host.web.scene import mission_scene, path_scene

    stop, observer = Stop(), _Observer(sender)
    threading.Thread(target=_listen, args=(connection, stop, sender), daemon=True).start()
    search = search_of(task.values)
    plan = plan_mission(mission_of(task.values), search, progress=observer, stop=stop)
    observer.flush()
    least_m = plan.summary["minimum_clearance_m"]
    path = path_scene(plan.evaluator, plan.path, plan.planner, least_m=least_m)
    wanted = choices_of(task.values, plan.evaluator.problem)
    path["mission"] = mission_scene(mission_of_plan(plan, wanted))
    sender.send(Found(plan.summary, path))
    sender.send(Saved(save(plan, task.values, task.folder)))
    # Nobody is waiting for it.
    draw_picture(plan, task.values, task.folder)


class _Observer:
    """Observer of a search that sends its progress, at most 30 times a second."""

    def __init__(self, sender: Sender) -> None:
        self._sender = sender
        self._sent_s = 0.0
        self._seen = Progressed([], [])
        self._better: NDArray[Any] | None = None

    def __call__(self, generation: int, best: float, mean: float) -> None:
        self._seen.rows.append((generation, best, mean))
        if self._better is not None:
            self._seen.paths.append((generation, self._better))
            self._better = None
        if time.monotonic() - self._sent_s >= _PERIOD_S:
            self.flush()

    def improved(self, path: NDArray[Any]) -> None:
        self._better = path

    def flush(self) -> None:
        """Send the remaining progress."""
        if self._seen.rows:
            self._sender.send(self._seen)
        self._seen = Progressed([], [])
        self._sent_s = time.monotonic()


def _listen(connection: Connection, stop: Stop, sender: Sender) -> None:
    """Request the end of the search when the desk asks for it, or has ended itself."""
    with contextlib.suppress(EOFError, OSError):
        while connection.recv() != STOP:
            pass
    stop.request()
    while not stop.heeded:
        time.sleep(_HEEDED_POLL_S)
    sender.send(Ending())
