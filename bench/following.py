"""The sentences of a refused export, followed: a higher start, a higher goal or another one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError, JobError
from pathgene.host.mission.autopilot.ends import NoRoomError
from pathgene.host.mission.autopilot.late import LateClimbError
from pathgene.host.problem.problem import Problem


__all__ = ["Followed", "follow"]

Result = TypeVar("Result")
Path = NDArray[np.float64]

# Sentences that are followed.
_MOST_FOLLOWED = 6


@dataclass
class Followed(Generic[Result]):
    """The result of a mission, and the sentences that led to it.

    Parameters
    ----------
    result : object, optional
        None if no path was found, or the last attempt was refused.
    followed : list of str
        Changes of the mission that the sentences asked for.
    refusal : str
        The sentence of the last refusal, or empty.
    note : str
        Why the first problem has no path, if a sentence says so.
    """

    result: Result | None = None
    followed: list[str] = field(default_factory=list)
    refusal: str = ""
    note: str = ""


def follow(
    make: Callable[[], Problem],
    plan: Callable[[Problem], tuple[bool, Path]],
    attempt: Callable[[Problem, Path], Result],
) -> Followed[Result]:
    """Plan a mission and attempt it, again after each refusal that says how to mend it.

    Parameters
    ----------
    make, plan, attempt : callable
        Return the problem, the verdict on a path of it and that path, and the result of the path.
        An attempt that is refused raises JobError.
    """
    done: Followed[Result] = Followed()
    try:
        task = make()
        while True:
            feasible, path = plan(task)
            if not feasible:
                if done.refusal:
                    done.refusal = f"no path is found as it is advised: {done.refusal}"
                break
            try:
                done.result = attempt(task, path)
            except JobError as error:
                done.refusal = str(error)
                if len(done.followed) >= _MOST_FOLLOWED:
                    break
                if isinstance(error, LateClimbError):
                    task = replace(task, start=_raised(task.start, error.raise_m))
                    done.followed.append(f"start {error.raise_m} m higher")
                elif isinstance(error, NoRoomError) and error.goal is not None:
                    raise_m = error.goal.raise_m
                    is_there = error.goal.place[:2] == task.goal[:2]
                    task = replace(task, goal=error.goal.place, start=_raised(task.start, raise_m))
                    done.followed.append("goal higher" if is_there else "goal elsewhere")
                    if raise_m:
                        done.followed.append(f"start {raise_m} m higher")
                else:
                    break
            else:
                done.refusal = ""
                break
    except InputError as error:
        if not done.refusal:
            done.note = str(error)
    return done


def _raised(end: tuple[float, float, float], by_m: float) -> tuple[float, float, float]:
    x, y, z = end
    return x, y, z + by_m
