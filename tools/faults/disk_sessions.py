"""Sessions that write files, and the checks of their folders: a comparison, and replaced runs."""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import functools
import io
import json
import multiprocessing
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.compare.entrants import parse_entrants, problem_digest
from pathgene.host.compare.report import Field
from pathgene.host.compare.runs import Outcome, Task, run_in_processes
from pathgene.host.compare.session import complete, kept
from pathgene.host.compare.store import RunStore
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.report.read import read_run
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import write_report
from pathgene.host.terrain import Terrain
from tools.chips import SMALL, board_url
from tools.faults.judge import DifferentError


#: Maximum number of attempts in a case: with three faults, and two without.
MAXIMUM_ATTEMPTS = 5
#: Seeds of a comparison.
_SEEDS = range(4)
_SUMMARY = "summary.json"

Files = dict[str, bytes]


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


@dataclass(frozen=True)
class Ending:
    """The end of an attempt, which decides the files that its folder may have."""

    #: Number of the attempt, from 1, and of the last one whose files a loss of power cannot undo.
    number: int
    oldest: int
    #: The attempt ended as without faults.
    is_whole: bool
    #: A signal ended it, before or after its files were written.
    is_interrupted: bool = False
    #: The disk has refused a call.
    is_refused: bool = False
    #: The process was killed, or the disk also refused to restore files.
    is_broken: bool = False
    #: The disk refused to restore files, and has them still.
    is_kept: bool = False
    #: The power was lost, and the disk had refused to sync the folder.
    is_forgotten: bool = False


class DiskSession(ABC):
    """Work in a folder, in attempts that continue where the last one ended."""

    #: Packages of ``host`` whose lines Ctrl-C may meet.
    packages: tuple[str, ...] = ()

    @abstractmethod
    def learn(self) -> None:
        """Note the results of the work without faults."""

    def prepare(self, folder: Path) -> None:
        """Prepare the folder for the first attempt."""
        return

    @abstractmethod
    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Execute the work. ``death`` is the number of results after which a worker is killed."""

    @abstractmethod
    def check(self, folder: Path, ending: Ending) -> None:
        """Check the bytes in the folder after an attempt, and that the product reads them rightly.

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
        self._right: dict[tuple[str, int], Any] = {}
        # Runs that the product has stored, because it waited for the next one.
        self._stored: set[tuple[str, int]] = set()

    def learn(self) -> None:
        """Note the result of each run."""
        tasks = [Task(entrant, seed) for entrant in self._entrants for seed in _SEEDS]
        for outcome in _alone(tasks):
            assert outcome.record is not None, outcome.failure
            record = json.loads(json.dumps(outcome.record))
            self._right[_name(outcome.task)] = _result(record)

    def prepare(self, folder: Path) -> None:
        """Forget the runs of an earlier case."""
        self._stored = set()
        self._counted: list[Field] = []

    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Execute the missing runs."""
        run = functools.partial(_dying, death) if death is not None else _alone
        with RunStore(folder, self._digest) as store:
            fields = self._counted = kept(store, self._entrants, _SEEDS)
            self._check_lock(folder)
            complete(fields, _SEEDS, store, functools.partial(self._noting, run), io.StringIO())

    def _check_lock(self, folder: Path) -> None:
        """Check that no other process could open the stored runs."""
        with (folder / "runs.jsonl").open("rb") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return
        raise DifferentError("the stored runs are not locked")

    def _noting(
        self, run: Callable[[Sequence[Task]], Generator[Outcome]], tasks: Sequence[Task]
    ) -> Generator[Outcome]:
        """Yield outcomes; note each as stored when the next one is requested."""
        if again := self._stored.intersection(map(_name, tasks)):
            raise DifferentError(f"{len(again)} stored runs are repeated")
        with contextlib.closing(run(tasks)) as outcomes:
            for outcome in outcomes:
                yield outcome
                self._stored.add(_name(outcome.task))

    def check(self, folder: Path, ending: Ending) -> None:
        """Check that stored results are right, and complete after a whole attempt."""
        file = folder / "runs.jsonl"
        found: dict[tuple[str, int], Any] = {}
        for line in file.read_bytes().split(b"\n") if file.exists() else ():
            with contextlib.suppress(ValueError):  # A part of a line.
                record = json.loads(line)
                name = record["key"], record["seed"]
                if name in found:
                    raise DifferentError(f"the run of seed {name[1]} is stored twice")
                found[name] = _result(record)
        for name, result in found.items():
            if result != self._right[name]:
                raise DifferentError(f"the stored run of seed {name[1]} is another")
        if ending.is_forgotten:
            self._stored &= set(found)
        if lost := self._stored - set(found):
            raise DifferentError(f"{len(lost)} stored runs are lost")
        counted = sum(len(part.records) for part in self._counted)
        if ending.is_interrupted and not ending.is_refused and counted != len(found):
            raise DifferentError(f"{counted} runs are counted, and {len(found)} are stored")
        if ending.is_whole and (missing := set(self._right) - set(found)):
            raise DifferentError(f"{len(missing)} runs are not stored")
        with in_folder() as copy:  # The product ends a truncated line when it opens the file.
            shutil.copytree(folder, copy, dirs_exist_ok=True)
            with RunStore(copy, self._digest) as store:
                fields = kept(store, self._entrants, _SEEDS)
        read = {
            (part.entrant.key, seed): _result(record)
            for part in fields
            for seed, record in part.records.items()
        }
        if read != found:
            raise DifferentError("other runs are read than are stored")


def _name(task: Task) -> tuple[str, int]:
    return task.entrant.key, task.seed


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

    def __init__(self) -> None:
        # The files of each attempt's run, and the files found after the last attempt.
        self._right: list[Files] = []
        self._before: Files = {}
        # The disk has refused to restore files since the last whole run: some may be hidden.
        self._was_kept = False

    def learn(self) -> None:
        """Note the bytes of each run's files."""
        for number in range(MAXIMUM_ATTEMPTS + 1):
            with in_folder() as folder:
                self.attempt(folder, number, None)
                self._right.append(_visible(folder))

    def prepare(self, folder: Path) -> None:
        """Write an older run."""
        for name, content in self._right[0].items():
            (folder / name).write_bytes(content)
        self._before, self._was_kept = self._right[0], False

    def attempt(self, folder: Path, number: int, death: int | None) -> None:
        """Write the files of a run; files of additional formats differ from run to run."""
        evaluator, results = self._results
        result = results[number % len(results)]
        source = {"source": "hills", "fill_voids": False, "cell_m": None}
        summary = summarise(
            evaluator, result, planner="ga-pc", board=None, seed=number, source=source
        )
        others = {"path.plan": b"plan"} if number % 2 else {"path.kml": b"kml" * 5000}
        write_report(folder, evaluator, result, summary, _no_warning, picture=False, others=others)

    def check(self, folder: Path, ending: Ending) -> None:
        """Check that the folder has the files of a single run, or that the product refuses it."""
        found, before, right = _visible(folder), self._before, self._right[ending.number]
        self._before = found
        self._was_kept = ending.is_kept or (self._was_kept and not ending.is_whole)
        if ending.is_kept:
            present = [file.read_bytes() for file in folder.iterdir()]
            if lost := [name for name, content in before.items() if content not in present]:
                raise DifferentError(f"{lost[0]} is lost")
        if found == right and (ending.is_whole or ending.is_interrupted or ending.is_broken):
            mixed = False
        elif ending.is_whole:
            raise DifferentError(f"after a whole run, {_difference(found, right)}")
        elif ending.is_broken:
            mixed = self._is_mixed(folder, found, range(ending.oldest, ending.number + 1))
        elif found != before:
            raise DifferentError(f"after a failure, {_difference(found, before)}")
        else:
            mixed = found not in self._right
        try:
            read_run(folder / _SUMMARY)
        except InputError as error:
            if not mixed:
                raise DifferentError(f"the files of one run are refused: {error}") from None
            if not any(str(folder / name) in str(error) for name in self._foreign(folder, found)):
                raise DifferentError(f"a mixture is refused for another reason: {error}") from None
        else:
            if mixed:
                raise DifferentError("files of two runs are taken for the files of one")

    def _is_mixed(self, folder: Path, found: Files, numbers: Sequence[int]) -> bool:
        """Return whether files belong to several of the runs; each must belong to one."""
        runs = [self._right[number] for number in numbers]
        for name, content in found.items():
            if all(run.get(name) != content for run in runs):
                raise DifferentError(f"{name} has the bytes of no run")
        if _SUMMARY not in found:
            raise DifferentError("there are files, but no summary")
        if found in runs:
            return False
        self._foreign(folder, found)
        return True

    def _foreign(self, folder: Path, found: Files) -> list[str]:
        """Return the names of files that are not of the summary's run, and of its hidden ones."""
        run = next(run for run in self._right if run[_SUMMARY] == found[_SUMMARY])
        foreign = [name for name, content in found.items() if run.get(name) != content]
        missing = [name for name in run if name not in found]
        present = [file.read_bytes() for file in folder.iterdir()]
        hidden = [name for name in missing if run[name] in present]
        if not foreign and (not hidden or len(hidden) < len(missing) or not self._was_kept):
            raise DifferentError("a file of the run is missing")
        return foreign + hidden

    @functools.cached_property
    def _results(self) -> tuple[Evaluator, list[Any]]:
        evaluator = Evaluator(problem(), threads=1)
        planner = make("ga-pc")
        results = (planner.plan(evaluator, Options(generations=2, seed=seed)) for seed in (0, 1))
        return evaluator, [dataclasses.replace(result, seconds={}) for result in results]


def _visible(folder: Path) -> Files:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.name[0] != "."}


def _difference(found: Files, right: Files) -> str:
    """Return the first file that is missing, surplus or different, in words."""
    for name in sorted({*found, *right}):
        if name not in found:
            return f"{name} is missing"
        if name not in right:
            return f"{name} is left"
        if found[name] != right[name]:
            return f"{name} has other bytes"
    raise ValueError("no difference")


def _no_warning(text: str) -> None:
    raise DifferentError(f"a warning: {text}")


@contextlib.contextmanager
def in_folder() -> Iterator[Path]:
    """Return a new folder that is removed at the end of the block."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


#: Sessions by name.
DISK_SESSIONS: dict[str, type[DiskSession]] = {"comparison": Comparison, "files": Replacement}
