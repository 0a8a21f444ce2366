"""A changed problem on a chip that still has the population of the previous problem."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.runs import WARM_SLOPES, RunOptions
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Progress, Result, Run, Stop
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.chip.problem_record import whole_path
from pathgene.host.planners.chip.runs import ChipRuns
from pathgene.host.planners.chip.schedule import MOST_RUNS, SURFACES
from pathgene.host.planners.timed import plan_in_time
from pathgene.host.problem.zones import Zone


__all__ = ["ChipReplanner", "replan_options"]

#: Options of the first run. With four paths to read, its limit keeps chip and line within 3 ms in
#: 99 of 100 replans (``make bench BENCH=replan``).
_WARM = RunOptions(
    cycles=144_000,
    generations=195,
    until_feasible=True,
    slopes=WARM_SLOPES,
    seeds=32,
    share=5,
    warm=True,
    paths=4,
)
#: Options of a run from new seeds only, which is longer and uses other surfaces. It follows a first
#: run without a feasible path, and is the first run on a new map.
_COLD = RunOptions(cycles=280_000, generations=300, until_feasible=True, paths=4)


def replan_options(config: Config, seed: int, again: int = 0) -> RunOptions:
    """Return the options of a run that combines the earlier population with new seeds.

    Repeated runs, with ``again`` counted from 1, start from new seeds only.
    """
    usual = replace(_COLD, slopes=SURFACES[again % len(SURFACES)]) if again else _WARM
    return replace(
        usual,
        seed=(seed + again) % (1 << 64),
        give_up_rank=min(usual.give_up_rank, config.population - 1),
    )


class ChipReplanner:
    """Plans changed problems on a chip, from the population of the previous problem.

    A further replan of the same plan continues from its latest replan, whose population the chip
    has.

    The chip draws new zones on its map and runs for a millisecond, with an island of the earlier
    paths, without the waypoints before the start, and an island of new seeds. The host judges the
    paths by the strict rule. If none is feasible, it repairs the best and, after the first run, the
    second best (:func:`~pathgene.host.planners.grid.repairs.repair`), which takes milliseconds of
    processor time but no time on the chip and the line. If that fails, up to seven more runs of at
    most 2.8 ms follow, each from new seeds only. :meth:`finish` clears the zones that were removed
    while new ones were added.

    Zones with times are handled as in a plan (:func:`~pathgene.host.planners.timed.plan_in_time`):
    the map of the first search does not have them, and each further search adds the zones that the
    path of the previous search enters while they are active.

    Parameters
    ----------
    task : ProblemOnChip
        The previous problem, on a chip that is open.
    to_free : sequence of Zone
        New zones of a problem without a path, which :meth:`finish` clears. Drawing a zone again
        takes one command, but clearing a removed zone takes an upload of all its corners, and the
        new path would have to wait for that.
    """

    def __init__(self, task: ProblemOnChip, to_free: Sequence[Zone] = ()) -> None:
        self._task, self._to_free = task, to_free
        self._later: ChipReplanner | None = None

    @property
    def is_ready(self) -> bool:
        """False once the board is closed or another plan's run has replaced the population."""
        return self._latest._task.is_warm

    @property
    def _latest(self) -> ChipReplanner:
        """The last of the replans that followed this one, whose population the chip has."""
        if self._later is None:
            return self
        self._later = self._later._latest
        return self._later

    def finish(self) -> None:
        """Clear removed zones and ``to_free``; the next replan repeats any part that failed."""
        if self._latest is not self:
            self._latest.finish()
            return
        if self._to_free:
            problem = self._task.problem
            kept = tuple(zone for zone in problem.zones if zone not in self._to_free)
            self._task, self._to_free = self._task.changed(replace(problem, zones=kept)), ()
        with contextlib.suppress(JobError):
            self._task.free()

    def replan(self, evaluator: Evaluator, options: Options) -> Result:
        """Search; see :class:`pathgene.host.planners.base.Replanner`.

        The generations of the options are ignored. ``hardware`` and ``seconds`` of the result are
        as from :meth:`pathgene.host.planners.chip.ga_chip.ChipGeneticPlanner.plan`; ``hardware``
        counts all searches, and ``searches`` is their number.
        """
        searches = _Searches(self)
        result = plan_in_time(searches, evaluator, options)
        return replace(result, hardware=searches.hardware)

    def search(self, evaluator: Evaluator, options: Options) -> Result:
        """Search once, with a map on which zones with times are always active."""
        before = self._latest
        run = Run(evaluator, options)
        problem = evaluator.problem

        def judge_straight_line() -> None:
            """Record the line that leaves the start along its heading like the chip's paths."""
            if not run.history:
                straight = whole_path(problem, np.empty((0, 3)))
                run.record(0, run.fitness([straight], strict=True))

        try:
            with run.phase("map"):
                task = before._task.changed(problem)
            with run.search():
                # The chip searches at the same time.
                runs = ChipRuns(task, run, repairs=True, meanwhile=judge_straight_line)
                runs.search(_runs(task, options.seed))
            run.hardware = runs.hardware()
            run.seconds["board"] = runs.cycles / task.chip.config.clock_hz
        except JobError as error:
            run.failure = str(error)
        judge_straight_line()
        result = run.result()
        if not task.is_warm:
            return result
        to_free: list[Zone] = []
        if not result.evaluation.feasible:
            known = before._task.problem.zones
            to_free = [zone for zone in problem.zones if zone not in known]
        before._later = ChipReplanner(task, to_free)
        return replace(result, replanner=before._later)


class _Searches:
    """The searches of one replan, each of which continues from the previous one.

    Attributes
    ----------
    hardware : dict or None
        Counters of all searches; None if the last search failed.
    """

    def __init__(self, replanner: ChipReplanner) -> None:
        self._replanner = replanner
        self.hardware: dict[str, Any] | None = None
        self._count = 0

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search once more; see :class:`pathgene.host.planners.base.Planner`."""
        result = self._replanner.search(evaluator, options)
        self._count += 1
        if isinstance(result.replanner, ChipReplanner):
            self._replanner = result.replanner
        if result.hardware is None or self.hardware is None:
            self.hardware = result.hardware
        else:
            self.hardware = _summed(self.hardware, result.hardware)
        if self.hardware is not None:
            self.hardware["searches"] = self._count
        return result


def _summed(one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return the counters of two searches together, with the map of the second."""
    summed = dict(other)
    for key in ("plan_us", "generations", "drawing_cycles", "exchanges", "runs"):
        summed[key] = one[key] + other[key]
    for key in ("cycles", "bytes", "frames"):
        summed[key] = {name: one[key][name] + other[key][name] for name in other[key]}
    return summed


def _runs(task: ProblemOnChip, seed: int) -> Iterator[RunOptions]:
    """Return the options of the runs; waypoints on the steps of a different map are useless."""
    first = 0 if task.is_warm else 1
    for number in range(first, first + MOST_RUNS):
        yield replan_options(task.chip.config, seed, number)
