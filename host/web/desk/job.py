"""The jobs of the desk as its pages see them: a plan, a flight, a mission being mended."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal

from numpy.typing import NDArray

from pathgene.host.web.desk.flight import USUAL, Flown, FlyTask, Landed
from pathgene.host.web.desk.mending import MendedFile, MendTask
from pathgene.host.web.desk.messages import Ending, Failed, Saved
from pathgene.host.web.desk.worker import Found, PlanTask, Progressed


__all__ = ["NEWS", "FlightJob", "Job", "MendJob", "PlanJob", "SavedJob", "State"]

#: Parts of a flight that are sent only after a change.
NEWS = ("zones", "points", "path", "changes")

#: See :class:`Job`.
State = Literal["waiting", "planning", "flying", "mending", "found", "saved", "failed"]


@dataclass(eq=False, kw_only=True)
class Job(ABC):
    """Work of a process of the desk. Only the desk's threads write to this object.

    Attributes
    ----------
    state : str
        ``waiting`` in the queue; ``planning``, ``flying`` or ``mending``; ``found``, for a mended
        mission the end, and otherwise not yet saved; ``saved``, ``failed``.
    error : str or None
        A sentence that says why there is no result, or no file of it.
    ending : bool
        Its search has ended because of that request.
    """

    #: The state while the task is executed, and the word for the job in sentences.
    at_work: ClassVar[State]
    word: ClassVar[str]

    state: State = "waiting"
    error: str | None = None
    stopping: bool = False
    ending: bool = False

    @property
    @abstractmethod
    def task(self) -> object:
        """The task of the process."""

    @property
    def done(self) -> bool:
        """True once nothing more will arrive."""
        return self.state in ("saved", "failed")

    def take(self, message: object) -> None:
        """Record a message of the process."""
        if isinstance(message, Ending):
            self.ending = True
        elif isinstance(message, Failed):
            self.error, self.state = message.sentence, "failed"


@dataclass(eq=False, kw_only=True)
class SavedJob(Job):
    """A job whose result is saved.

    Parameters
    ----------
    folder : Path
        Folder in which the result is saved.

    Attributes
    ----------
    notes : list of str
        Sentences about facts that the files cannot express.
    """

    folder: Path = field(kw_only=False)
    notes: list[str] = field(default_factory=list)

    def take(self, message: object) -> None:
        """Record a message of the process."""
        super().take(message)
        if isinstance(message, Saved):
            self.notes, self.state = message.notes, "saved"


@dataclass(eq=False, kw_only=True)
class MendJob(Job):
    """A mission that is being mended; its state is ``found`` once it has a ``result``.

    Parameters
    ----------
    wanted : MendTask
        The mission.
    """

    at_work = "mending"
    word = "mending"

    wanted: MendTask
    result: MendedFile | None = None

    @property
    def task(self) -> MendTask:
        """The task of the process."""
        return self.wanted

    @property
    def done(self) -> bool:
        """True once nothing more will arrive."""
        return self.state in ("found", "failed")

    def take(self, message: object) -> None:
        """Record a message of the process."""
        super().take(message)
        if isinstance(message, MendedFile):
            self.result, self.state = message, "found"


@dataclass(eq=False, kw_only=True)
class PlanJob(SavedJob):
    """A plan in progress; its folder is empty until its state is ``saved``.

    Parameters
    ----------
    statement : str, optional
        The problem in the form of :meth:`pathgene.host.web.desk.sheet.Sheet.statement`.

    Attributes
    ----------
    rows : list of (int, float, float)
        Generation, best and mean fitness; only ever appended to.
    paths : list of (int, ndarray)
        Generation and best path, (n, 3) metres; only ever appended to.
    summary : dict or None
        The summary of the plan, once there is one.
    """

    at_work = "planning"
    word = "plan"

    values: Mapping[str, Any]
    statement: str | None = None
    rows: list[tuple[int, float, float]] = field(default_factory=list)
    paths: list[tuple[int, NDArray[Any]]] = field(default_factory=list)
    summary: dict[str, Any] | None = None
    path: dict[str, Any] | None = None

    @property
    def task(self) -> PlanTask:
        """The task of the process."""
        return PlanTask(self.values, self.folder)

    def take(self, message: object) -> None:
        """Record a message of the process."""
        super().take(message)
        if isinstance(message, Progressed):
            # A page that sees a row must also see its path.
            self.paths += message.paths
            self.rows += message.rows
        elif isinstance(message, Found):
            self.summary, self.path, self.state = message.summary, message.path, "found"


@dataclass(eq=False, kw_only=True)
class FlightJob(SavedJob):
    """A flight of the saved plan in its folder.

    Parameters
    ----------
    planner, board : str
        The planner to use in flight, and its board.

    Attributes
    ----------
    trail, versions, said : list
        All entries of :class:`pathgene.host.web.desk.flight.Flown` to date; append-only.
    news : dict of str to (int, object)
        Current zones, points, path and changes, each with an increasing number.
    speed : float
        Speed of the flight, as a multiple of the speed of the aircraft.
    """

    at_work = "flying"
    word = "flight"

    planner: str
    board: str
    seed: int = 0
    latest: Flown | None = None
    trail: list[list[float]] = field(default_factory=list)
    versions: list[tuple[str, list[list[float]]]] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    news: dict[str, tuple[int, Any]] = field(default_factory=dict)
    speed: float = USUAL
    watchers: set[object] = field(default_factory=set)
    outcome: dict[str, Any] | None = None

    @property
    def task(self) -> FlyTask:
        """The task of the process."""
        return FlyTask(self.folder, self.planner, self.board, self.seed)

    def take(self, message: object) -> None:
        """Record a message of the process."""
        super().take(message)
        if isinstance(message, Flown):
            self.trail += message.trail
            self.versions += message.versions
            self.said += message.said
            for name in NEWS:
                if (value := getattr(message, name)) is not None:
                    self.news[name] = (self.news.get(name, (0, None))[0] + 1, value)
            self.latest = message
        elif isinstance(message, Landed):
            self.outcome, self.state = message.outcome, "found"
