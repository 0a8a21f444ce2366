"""Many problems planned at once; each result is kept as soon as it is available."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import os
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pathgene.host.device.boards import known_config
from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import prepare_directory
from pathgene.host.formats.registry import check_formats, parse_formats
from pathgene.host.inputs import opened, parse_json, read_text
from pathgene.host.machine import available_cores
from pathgene.host.mission.autopilot.hand_over import choices_of, hand_over_of
from pathgene.host.mission.build import mission_of, search_of
from pathgene.host.mission.drawn import drawn_mission
from pathgene.host.mission.ending import ending_of, with_end
from pathgene.host.mission.export import exported_with_room
from pathgene.host.mission.legs import shortcoming
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.planning import plan_mission
from pathgene.host.options.table import options_of
from pathgene.host.planners.base import Result
from pathgene.host.planning import Plan, Search
from pathgene.host.remarks import Reading
from pathgene.host.report.run_files import SUMMARY, verify
from pathgene.host.report.summary import describe_readings, version
from pathgene.host.report.write import write_report
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.stated import STATEMENTS
from pathgene.host.workers.cluster import on_cluster
from pathgene.host.workers.processes import in_processes
from pathgene.host.workers.shared import packed, unpacked


__all__ = ["Job", "Outcome", "execute", "kept_summary", "names_of", "save"]

#: Values that affect the output, not the plan.
_OUTPUT = {option.name for option in options_of("output")}
# Values that a terrain depends on.
_OF_TERRAIN = (
    *("terrain", "cell", "fill_voids", "max_cells", "self_contained", "origin", "as_paper"),
    *STATEMENTS,
)
# Maximum number of problems that a GPU plans at once, and of nodes of their maps, 16 or 24 bytes
# each.
_MOST_TOGETHER, _MOST_NODES = 64, 50_000_000


@dataclass(frozen=True)
class Job:
    """A problem of a batch.

    Parameters
    ----------
    name : str
        Name of the problem and of its folder.
    values : mapping
        Values of the file, overridden by values of the command line.
    """

    name: str
    file: str
    values: Mapping[str, Any]

    @functools.cached_property
    def key(self) -> str:
        """Digest of everything that the result depends on: values, files named in them, pathgene.

        The same problem with a different comment or in a different folder has the same key.
        """
        values = {
            name: value
            for name, value in self.values.items()
            if name not in _OUTPUT and value is not None
        }
        values["zones"] = [
            {**zone, "file": _content(zone["file"])} if "file" in zone else zone
            for zone in values.get("zones") or ()
        ]
        for name in ("terrain", "uav"):
            if isinstance(values.get(name), str):
                values[name] = _content(values[name])
        text = json.dumps({**values, "pathgene": version()}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:20]

    @property
    def land(self) -> str:
        """Key that jobs over the same terrain share."""
        values = {name: self.values.get(name) for name in _OF_TERRAIN}
        return json.dumps(values, sort_keys=True)

    def make(
        self,
        say: Callable[[Reading, Reading], None] | None = None,
        terrain: Terrain | None = None,
    ) -> tuple[MissionProblem, Search]:
        """Return the mission and the search.

        Parameters
        ----------
        terrain : Terrain, optional
            The terrain of the job, if it is loaded already.
        say : callable, optional
            Gets the reports on files; see :func:`pathgene.host.mission.build.mission_of`.

        Raises
        ------
        InputError
            If the values are bad, or the planner needs a board on a port of this machine.
        """
        mission = mission_of(self.values, terrain, say=say)
        check_formats(self.formats, mission.problem.terrain)
        hand_over_of(self.values)
        ending_of(self.values, mission.problem)
        return mission, search_of(self.values)

    @property
    def formats(self) -> tuple[str, ...]:
        """Formats of the files for other programs."""
        text = self.values.get("write")
        return parse_formats(text) if text else ()


@dataclass(frozen=True)
class _Task:
    """A job in the form that is sent to a process: by value, without files."""

    number: int
    mission: MissionProblem
    values: Mapping[str, Any]


@dataclass(frozen=True)
class _Sent:
    """A task as it is sent to a process, which has the terrains already."""

    number: int
    content: bytes


@dataclass(frozen=True)
class Outcome:
    """The result of a job.

    Parameters
    ----------
    summary : dict or None
        Content of ``summary.json``; None if the job failed before finding a path.
    failure : str or None
        The message of the failure; None after a success.
    bad_input : bool
        The failure is caused by the problem.
    read : dict or None
        The report on the files that were read before a failure, as in a summary.
    terrain : Terrain or None
        The terrain, if it could be loaded.
    """

    number: int
    summary: dict[str, Any] | None = None
    result: Result | None = None
    failure: str | None = None
    bad_input: bool = False
    read: dict[str, Any] | None = None
    terrain: Terrain | None = None


def names_of(files: Sequence[str]) -> list[str]:
    """Return a name for each problem file, including its folder if two files have the same name.

    Raises
    ------
    InputError
        If two names are still equal.
    """
    paths = [Path(file) for file in files]
    stems = [path.stem for path in paths]
    names = [
        f"{_folder(path)}-{path.stem}" if stems.count(path.stem) > 1 else path.stem
        for path in paths
    ]
    for number, name in enumerate(names):
        if name in names[:number]:
            first = files[names.index(name)]
            raise InputError(
                f"The results of {first} and {files[number]} would have one name, {name!r}; rename "
                "one of the files."
            )
    return names


def execute(
    jobs: Sequence[Job], count: int, scheduler: str | None
) -> Generator[tuple[Job, Outcome]]:
    """Plan jobs, ``count`` at a time; yield each job with its outcome as it ends.

    Jobs of one leg on a GPU are planned together in this process if their searches differ only in
    the seed. A bad problem is reported as an outcome and does not stop the batch.

    Parameters
    ----------
    count : int
        Processes, or workers of a local cluster.
    scheduler : str, optional
        Address of a Dask scheduler; see :func:`pathgene.host.workers.cluster.on_cluster`.

    Raises
    ------
    InputError, JobError
        If no scheduler answers or it is lost, or processes die again and again.
    """
    tasks = []
    terrains: dict[str, Terrain] = {}
    together: dict[object, list[_Task]] = {}
    reads: dict[int, dict[str, Any]] = {}

    def whole(outcome: Outcome) -> tuple[Job, Outcome]:
        if outcome.summary is None:
            outcome = dataclasses.replace(outcome, read=reads.get(outcome.number))
        job = jobs[outcome.number]
        return job, dataclasses.replace(outcome, terrain=terrains.get(job.land))

    for number, job in enumerate(jobs):

        def say(*readings: Reading, number: int = number) -> None:
            reads[number] = describe_readings(*readings)

        try:
            mission, search = job.make(say, terrains.get(job.land))
            terrains.setdefault(job.land, mission.problem.terrain)
            if scheduler is not None and search.board and known_config(search.board) is None:
                raise InputError(
                    "A board at this machine cannot be reached from a cluster; leave --scheduler "
                    "out."
                )
        except InputError as error:
            yield whole(Outcome(number, failure=str(error), bad_input=True))
            continue
        task = _Task(number, mission, job.values)
        if scheduler is None and mission.legs == 1 and search.kind is not None:
            together.setdefault(search.kind, []).append(task)
        else:
            tasks.append(task)
    for alike in together.values():
        for some in _parts(alike):
            for outcome in _plan_together(some):
                yield whole(outcome)
    if not tasks:
        return
    count = min(count, len(tasks))
    outcomes: Generator[Outcome]
    shared = list(terrains.values())
    if scheduler is None and count == 1:
        outcomes = in_processes(tasks, count, _plan, _threads, None)
    elif scheduler is None:
        outcomes = in_processes(_sent(tasks, shared), count, _plan_sent, _Shared, shared)
    else:
        outcomes = on_cluster(
            _sent(tasks, shared),
            scheduler,
            count,
            _plan_sent,
            _Shared,
            shared,
            name=lambda task: f"problem-{task.number}",
            failed=lambda task, reason: Outcome(task.number, failure=reason),
        )
    try:
        for outcome in outcomes:
            yield whole(outcome)
    finally:
        outcomes.close()


def kept_summary(directory: Path, job: Job) -> dict[str, Any] | None:
    """Return the summary of an earlier run of the same job in ``directory``, if there is one.

    A run does not count if one of its files was altered or belongs to another run.
    """
    file = directory / job.name / SUMMARY
    try:
        summary: dict[str, Any] = parse_json(read_text(file))
        same = summary["batch"]["key"] == job.key
        verify(file, summary)
    except (OSError, ValueError, KeyError, TypeError, InputError):
        return None
    return summary if same else None


def save(directory: Path, job: Job, outcome: Outcome, warn: Callable[[str], None]) -> None:
    """Write the files of a plan into the job's folder.

    Raises
    ------
    InputError
        If they cannot be written.
    """
    assert outcome.summary is not None
    assert outcome.result is not None
    folder = directory / job.name
    prepare_directory(folder)
    whole = mission_of(job.values, outcome.terrain).whole
    ending = ending_of(job.values, whole)
    formats = [name for name in job.formats if name != "geojson"]  # Every run has it.
    feasible, path = outcome.result.evaluation.feasible, outcome.result.path
    wanted = choices_of(job.values, whole)
    evaluator = Evaluator(whole)
    others, missing = exported_with_room(
        whole, path, formats, warn, feasible=feasible, wanted=wanted
    )
    if missing is not None:
        warn(missing)
    write_report(
        folder,
        evaluator,
        outcome.result,
        {**with_end(outcome.summary, ending), "batch": {"file": job.file, "key": job.key}},
        warn,
        picture=job.values.get("picture") is not False,
        grid=job.values.get("grid") is not False,
        others=others,
        mission=lambda: drawn_mission(whole, evaluator.track(path), wanted) if feasible else None,
    )


@dataclass(frozen=True)
class _Shared:
    """The terrains of all tasks, and the threads of a process."""

    terrains: Sequence[Terrain]
    threads: int


def _sent(tasks: Sequence[_Task], terrains: Sequence[Terrain]) -> list[_Sent]:
    return [_Sent(task.number, packed(task, terrains)) for task in tasks]


def _plan_sent(shared: _Shared, sent: _Sent) -> Outcome:
    """Plan a task that was sent."""
    task: _Task = unpacked(sent.content, shared.terrains)
    return _plan(shared.threads, task)


def _threads(_: None, threads: int) -> int:
    return threads


def _plan(threads: int, task: _Task) -> Outcome:
    """Plan a task; return an error as its outcome."""
    try:
        plan = plan_mission(
            task.mission,
            search_of(task.values),
            evaluator=functools.partial(Evaluator, threads=threads),
        )
    except PathgeneError as error:
        return Outcome(task.number, failure=str(error), bad_input=isinstance(error, InputError))
    except Exception as error:
        sentence = f"Internal error, {type(error).__name__}: {error}; please report it."
        return Outcome(task.number, failure=sentence)
    return _outcome(task, plan)


def _parts(tasks: Sequence[_Task]) -> Generator[Sequence[_Task]]:
    """Split tasks into parts that fill a GPU and whose maps fit into memory."""
    begin = nodes = 0
    for at, task in enumerate(tasks):
        nodes += task.mission.whole.terrain.elevation.size
        if at > begin and (nodes > _MOST_NODES or at - begin == _MOST_TOGETHER):
            yield tasks[begin:at]
            begin, nodes = at, task.mission.whole.terrain.elevation.size
    yield tasks[begin:]


def _plan_together(tasks: Sequence[_Task]) -> Sequence[Outcome]:
    """Plan tasks together; if one of them fails, plan each on its own."""
    try:
        searches = [search_of(task.values) for task in tasks]
        plans = searches[0].run_together(
            [Evaluator(task.mission.problem) for task in tasks],
            [search.options.seed for search in searches],
        )
    except Exception:  # Planned alone, each task reports whether it fails, and why.
        return [_plan(available_cores(), task) for task in tasks]
    return [_outcome(task, plan) for task, plan in zip(tasks, plans, strict=True)]


def _outcome(task: _Task, plan: Plan) -> Outcome:
    failure = plan.failure or shortcoming(plan.summary)
    result = dataclasses.replace(plan.result, archive=[])
    return Outcome(task.number, plan.summary, result, failure)


def _folder(path: Path) -> str:
    """Return the name of the folder that a file is in."""
    return Path(os.path.realpath(path)).parent.name


def _content(name: str) -> str:
    """Return a digest of a file's content; a name that is not a file is returned unchanged."""
    try:
        with opened(Path(name)) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, InputError):
        return name
