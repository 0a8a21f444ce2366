"""One run of one planner, wherever it is executed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from host.compare.entrants import Entrant
from host.errors import InputError, PathgeneError
from host.evaluation import Evaluator
from host.planners.base import Result
from host.report.summary import describe_run, version


__all__ = ["Outcome", "Task", "execute"]

# Entrants that have run in this process: what they need is compiled and loaded.
_warm: set[str] = set()


@dataclass(frozen=True)
class Task:
    """A run to be done.

    Parameters
    ----------
    entrant : Entrant
        Planner and options.
    seed : int
        Of the run.
    pathgene : str
        The version that is to do it: another would mix two programs in one table.
    """

    entrant: Entrant
    seed: int
    pathgene: str = dataclasses.field(default_factory=version)


@dataclass(frozen=True)
class Outcome:
    """What became of a task.

    Parameters
    ----------
    task : Task
        Which.
    record : dict or None
        :func:`host.report.summary.describe_run` of the run; None if it failed.
    failure : str or None
        Why it failed, in a sentence.
    bad_input : bool
        Whether the options or the problem are to blame.
    """

    task: Task
    record: dict[str, Any] | None = None
    failure: str | None = None
    bad_input: bool = False


def execute(evaluator: Evaluator, task: Task) -> Outcome:
    """Do a run; what goes wrong in it is told in the outcome, so that it costs no other run.

    The first run of an entrant in a process is preceded by one of a single generation, which is
    not timed: the seconds of no run contain the compilation and loading of its program.
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
    return entrant.make().plan(evaluator, options)
