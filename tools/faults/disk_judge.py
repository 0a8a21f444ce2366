"""Sessions that write files, on a disk with faults: a resumed comparison, and replaced runs."""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import functools
import io
import json
import multiprocessing
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.compare.entrants import parse_entrants, problem_digest
from pathgene.host.compare.runs import Outcome, Task, run_in_processes
from pathgene.host.compare.session import complete, kept
from pathgene.host.compare.store import RunStore
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.disk import using
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.report.run_files import SUMMARY, verify
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import write_report
from pathgene.host.terrain import Terrain
from tools.chips import SMALL, board_url
from tools.faults.case import Case, DiskExtent, DiskFault
from tools.faults.disk import SLOW, FaultyDisk, Killed
from tools.faults.judge import DifferentError, Judge, Verdict
from tools.faults.tracing import counted_lines, signal_of, signalled


#: Seeds of a comparison.
_SEEDS = range(4)


@functools.cache
def problem() -> Problem:
    """Return a flight over hills, around a zone."""
    x, y = np.meshgrid(np.arange(31), np.arange(21))
    terrain = Terrain(
        name="hills", elevation=300 + 100 * np.sin(x / 8) * np.cos(y / 6), dx_m=200.0, dy_m=200.0
    )
    zones = (Circle(3000, 2000, 400),)
    ends = (500, 500, 100), (5500, 3500, 100)
    return Problem(terrain, *ends, zones=zones, agl=True, as_paper=True)


class DiskSession(ABC):
    """Work in a folder, in attempts that continue where the last one ended."""

    #: Packages of ``host`` whose lines Ctrl-C may meet.
    packages: tuple[str, ...] = ()

    def prepare(self, folder: Path) -> None:
        """Prepare the folder for the first attempt."""
        return

    @abstractmethod
    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Execute the work. ``death`` is the number of results after which a worker is killed."""

    @abstractmethod
    def check(self, folder: Path, number: int, *, is_whole: bool, may_mix: bool) -> None:
        """Check the folder after an attempt.

        Parameters
        ----------
        folder : Path
            The folder.
        number : int
            Number of the attempt.
        is_whole : bool
            The attempt ended as without faults.
        may_mix : bool
            A process was killed, or reported that files could not be restored, since the last
            attempt that ended as without faults.

        Raises
        ------
        DifferentError
            If something in the folder is wrong or missing.
        """


class Comparison(DiskSession):
    """Runs of a planner on a board and of one without a board, each stored when it ends."""

    packages = ("compare", "files")

    def __init__(self) -> None:
        entrants = f"ga-fpga:board={board_url('model', SMALL)},fpa:population=8"
        self._entrants = parse_entrants(entrants, {"generations": 2}, {})
        self._digest = problem_digest(problem())

    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Execute the missing runs."""
        execute = functools.partial(_dying, death) if death is not None else _alone
        with RunStore(folder, self._digest) as store:
            fields = kept(store, self._entrants, _SEEDS)
            complete(fields, _SEEDS, store, execute, io.StringIO())

    def check(self, folder: Path, number: int, *, is_whole: bool, may_mix: bool) -> None:
        """Check that stored results are right, and complete after a whole attempt."""
        with RunStore(folder, self._digest) as store:
            fields = kept(store, self._entrants, _SEEDS)
        for part, right in zip(fields, self._right, strict=True):
            for seed, record in part.records.items():
                if _result(record) != right[seed]:
                    raise DifferentError(f"the stored run of seed {seed} is another")
            if is_whole and len(part.records) < len(_SEEDS):
                raise DifferentError(f"{len(_SEEDS) - len(part.records)} runs are not stored")

    @functools.cached_property
    def _right(self) -> list[dict[int, Any]]:
        tasks = [Task(entrant, seed) for entrant in self._entrants for seed in _SEEDS]
        found: dict[str, dict[int, Any]] = {entrant.key: {} for entrant in self._entrants}
        for outcome in _alone(tasks):
            assert outcome.record is not None, outcome.failure
            record = json.loads(json.dumps(outcome.record))
            found[outcome.task.entrant.key][outcome.task.seed] = _result(record)
        return list(found.values())


def _result(record: dict[str, Any]) -> Any:
    return record["fitness"], record["waypoints"], record["history"]


def _alone(tasks: Sequence[Task]) -> Generator[Outcome]:
    return _timeless(run_in_processes(problem(), tasks, 1))


def _timeless(outcomes: Generator[Outcome]) -> Generator[Outcome]:
    """Yield outcomes without seconds, so that the bytes written do not depend on the time."""
    with contextlib.closing(outcomes):
        for outcome in outcomes:
            assert outcome.record is not None, outcome.failure
            seconds = dict.fromkeys(outcome.record["seconds"], 0.0)
            yield dataclasses.replace(outcome, record={**outcome.record, "seconds": seconds})


def _dying(after: int, tasks: Sequence[Task]) -> Generator[Outcome]:
    """Execute tasks in two processes, and kill one of them after ``after`` outcomes."""
    before = multiprocessing.active_children()
    outcomes = _timeless(run_in_processes(problem(), tasks, 2))
    with contextlib.closing(outcomes):
        for number, outcome in enumerate(outcomes):
            if number == after:
                workers = [c for c in multiprocessing.active_children() if c not in before]
                workers[0].kill()
            yield outcome


class Replacement(DiskSession):
    """Runs that write their files into the same folder, each replacing the previous files."""

    packages = ("files", "report")

    def prepare(self, folder: Path) -> None:
        """Write an older run."""
        self.attempt(folder, 0, None)

    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Write the files of a run; files of additional formats differ from run to run."""
        evaluator, results = self._results
        result = results[number % len(results)]
        summary = summarise(
            evaluator, result, planner="ga-pc", board=None, seed=number, source={"name": "hills"}
        )
        others = {"path.plan": b"plan"} if number % 2 else {"path.kml": b"kml" * 5000}
        write_report(folder, evaluator, result, summary, _no_warning, picture=False, others=others)

    def check(self, folder: Path, number: int, *, is_whole: bool, may_mix: bool) -> None:
        """Check that the folder has the files of a single run, or says that it does not."""
        visible = {file.name for file in folder.iterdir() if file.name[0] != "."}
        if not visible and not is_whole:
            return
        if SUMMARY not in visible:
            # The first run of a folder: it contains no sign of a run.
            if may_mix:
                return
            raise DifferentError("files without a summary")
        summary = json.loads((folder / SUMMARY).read_text())
        is_mixed = visible != {*summary["files"], SUMMARY}
        try:
            verify(folder / SUMMARY, summary)
        except InputError:
            is_mixed = True
        else:
            # A missing file does not make a mixture, but nothing here removes files.
            if may_mix and visible < {*summary["files"], SUMMARY}:
                raise DifferentError("a file is missing, and the summary is taken for whole")
        if is_mixed and not may_mix:
            raise DifferentError("files of two runs")
        if is_whole and summary["seed"] != number:
            raise DifferentError("files of an earlier run")

    @functools.cached_property
    def _results(self) -> tuple[Evaluator, list[Any]]:
        evaluator = Evaluator(problem(), threads=1)
        planner = make("ga-pc")
        results = (planner.plan(evaluator, Options(generations=2, seed=seed)) for seed in (0, 1))
        return evaluator, [dataclasses.replace(result, seconds={}) for result in results]


def _no_warning(text: str) -> None:
    raise DifferentError(f"a warning: {text}")


@contextlib.contextmanager
def in_folder() -> Iterator[Path]:
    """Return a new folder that is removed at the end of the block."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


#: Sessions by name.
DISK_SESSIONS: dict[str, type[DiskSession]] = {"comparison": Comparison, "files": Replacement}


class DiskJudge(Judge):
    """Judges sessions that write files.

    Each attempt must end as it does without faults, with a documented error, by Ctrl-C, or because
    its process is killed. The files on the disk must then be whole, or be marked as incomplete. The
    last attempt, without faults, continues from there and must end as if nothing had happened.
    """

    def extent(self, session: str, work: int) -> DiskExtent:
        """Return how long a session is without faults."""
        return _extent(session)

    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a session; see :class:`tools.faults.judge.Judge`."""
        session = _session(case.session)
        ends: list[str] = []
        may_mix = False
        with in_folder() as folder:
            session.prepare(folder)
            # A signal may also end the attempt without faults.
            for number, fault in enumerate((*case.disk, None, None), 1):
                disk = FaultyDisk()
                if fault is not None:
                    disk = FaultyDisk(
                        fault.at,
                        error=fault.error,
                        lasting=fault.lasting,
                        kill=fault.kill,
                        seed=case.seed,
                    )
                is_first = number == 1
                signal_at = case.signal_at if is_first else None
                death = case.death_after if is_first else None
                end = _attempt(session, folder, number, disk, signal_at, death)
                if fault is not None and (disk.failed or disk.slowed):
                    if fault.kill:
                        end = "killed"  # A signal that was held back until now.
                    verdict.faults[f"disk: {_name(fault)}"] += 1
                if end != "done":
                    may_mix |= end in ("killed", "not put back")
                    session.check(folder, number, is_whole=False, may_mix=may_mix)
                else:
                    session.check(folder, number, is_whole=True, may_mix=False)
                    may_mix = False
                ends.append(end)
            if any(file.name[0] == "." for file in folder.iterdir()):
                raise DifferentError("a temporary file is left")
        if case.signal_at is not None:
            verdict.faults[signal_of(case.signal_at).name] += 1
        if case.death_after is not None:
            verdict.faults["worker killed"] += 1
        verdict.outcome = ends[0]


def _name(fault: DiskFault) -> str:
    if fault.kill:
        return "killed"
    return "slow" if fault.error == SLOW else errno.errorcode[fault.error]


def _attempt(
    session: DiskSession,
    folder: Path,
    number: int,
    disk: FaultyDisk,
    signal_at: int | None,
    death: int | None,
) -> str:
    """Execute an attempt; return how it ended."""
    try:
        with using(disk), signalled(signal_at, session.packages):
            session.attempt(folder, number, death)
    except Killed:
        return "killed"
    except KeyboardInterrupt as error:
        # Held back until the files were abandoned.
        return "not put back" if "put back" in str(error.__context__) else "interrupted"
    except (InputError, JobError) as error:
        if not disk.failed:
            raise
        return "not put back" if "put back" in str(error) else type(error).__name__
    return "done"


@cache
def _session(name: str) -> DiskSession:
    return DISK_SESSIONS[name]()


@cache
def _extent(name: str) -> DiskExtent:
    session, disk = _session(name), FaultyDisk()
    with in_folder() as folder:
        session.prepare(folder)
        with using(disk), counted_lines(session.packages) as lines:
            session.attempt(folder, 1, None)
    return DiskExtent(len(disk.calls), lines[0])
