"""One run of one planner, wherever it is executed."""

from __future__ import annotations

import dataclasses
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Any

from pathgene.host.compare.entrants import Entrant
from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Result
from pathgene.host.planners.timed import plan_in_time
from pathgene.host.problem.problem import Problem
from pathgene.host.report.summary import describe_run, version
from pathgene.host.workers.cluster import on_cluster
from pathgene.host.workers.processes import in_processes


__all__ = ["Outcome", "Task", "execute", "run_in_processes", "run_on_cluster"]

# Entrants that have run in this process: their code is compiled and loaded.
_warm: set[str] = set()


@dataclass(frozen=True)
class Task:
    """A run to be executed.

    Parameters
    ----------
    pathgene : str
        Version that must execute the run, because runs of different versions are not comparable.
    """

    entrant: Entrant
    seed: int
    pathgene: str = dataclasses.field(default_factory=version)


@dataclass(frozen=True)
class Outcome:
    """The outcome of a task.

    Parameters
    ----------
    record : dict or None
        :func:`pathgene.host.report.summary.describe_run` of the run; None if it failed.
    failure : str or None
        The reason for the failure, in a sentence.
    bad_input : bool
        The failure is caused by the options or the problem.
    """

    task: Task
    record: dict[str, Any] | None = None
    failure: str | None = None
    bad_input: bool = False


def run_in_processes(problem: Problem, tasks: Sequence[Task], jobs: int) -> Generator[Outcome]:
    """Execute runs of one problem; see :func:`pathgene.host.workers.processes.in_processes`."""
    return in_processes(tasks, jobs, execute, _evaluator, problem)


def run_on_cluster(
    problem: Problem, tasks: Sequence[Task], address: str, jobs: int
) -> Generator[Outcome]:
    """Execute runs of one problem; see :func:`pathgene.host.workers.cluster.on_cluster`."""
    return on_cluster(
        tasks,
        address,
        jobs,
        execute,
        _evaluator,
        problem,
        name=lambda task: f"{task.entrant.planner}-{task.seed}",
        failed=lambda task, reason: Outcome(task, failure=reason),
    )


def _evaluator(problem: Problem, threads: int) -> Evaluator:
    return Evaluator(problem, threads=threads)


def execute(evaluator: Evaluator, task: Task) -> Outcome:
    """Execute a run; return an error as its outcome, so that later runs still take place.

    An untimed run of one generation precedes the first run of an entrant in a process, so that
    recorded times include no compilation or loading.
    """
    entrant = task.entrant
    try:
        if version() != task.pathgene:
            raise InputError(
                f"Worker and client must be of one version, not pathgene {version()} "
                f"and {task.pathgene}."
            )
        if entrant.key not in _warm:
            _plan(evaluator, entrant, task.seed, generations=1)
            _warm.add(entrant.key)
        result = _plan(evaluator, entrant, task.seed)
    except PathgeneError as error:
        return Outcome(task, failure=str(error), bad_input=isinstance(error, InputError))
    except Exception as error:
        return Outcome(
            task, failure=f"Internal error, {type(error).__name__}: {error}; please report it."
        )
    if result.failure is not None:
        return Outcome(task, failure=result.failure)
    return Outcome(task, record=describe_run(result))


def _plan(evaluator: Evaluator, entrant: Entrant, seed: int, **changes: Any) -> Result:
    options = dataclasses.replace(entrant.options, seed=seed, **changes)
    return plan_in_time(entrant.make(), evaluator, options)
