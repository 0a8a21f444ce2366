"""Runs of the planner on a chip for one plan: the paths judged by the host, and the books."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hdl.protocol.planner import PathClass
from hdl.protocol.runs import RunOptions
from host.device.link import Traffic
from host.device.runs import RunStatus
from host.planners.base import Run
from host.planners.problem_on_chip import ProblemOnChip


__all__ = ["ChipRuns"]

_UNITS = ("breed", "score", "walk", "sort", "wavefront")


class ChipRuns:
    """The runs of one plan; see :class:`host.planners.ga_chip.ChipGeneticPlanner`.

    Parameters
    ----------
    task : ProblemOnChip
        The problem.
    run : Run
        The record of the plan.
    polishes : bool
        Each path is given the lowest altitudes, too.
    """

    def __init__(self, task: ProblemOnChip, run: Run, *, polishes: bool) -> None:
        self._task, self._run, self._polishes = task, run, polishes
        self._traffic_before = self._traffic_noted = replace(task.chip.link.traffic)
        self._done: list[dict[str, Any]] = []
        self._cycles = dict.fromkeys((*_UNITS, "total"), 0)

    @property
    def cycles(self) -> int:
        """Cycles of all runs."""
        return self._cycles["total"]

    def search(self, runs: Iterable[RunOptions]) -> None:
        """Send the problem; do runs until a path is feasible or a stop criterion is met."""
        run, task = self._run, self._task
        with run.phase("link"):
            task.send()
        generations = change = 0
        for number, options in enumerate(runs):
            with run.phase("link"):
                if number:
                    task.ease(change)
                status, best = task.run(options, functools.partial(self._ends, generations))
            generations += status.generations
            for unit in _UNITS:
                self._cycles[unit] += getattr(status, unit)
            self._cycles["total"] += status.cycles
            self._done.append(
                {
                    "seed": options.seed,
                    "warm": options.warm,
                    "generations": status.generations,
                    "cycles": status.cycles,
                    "ease": task.eased,
                    "classes": [each.name.lower() for each in best.classes],
                    "waypoints": [len(path) for path in best.paths],
                    "bytes": self._bytes_since(self._traffic_noted),
                }
            )
            self._traffic_noted = replace(task.chip.link.traffic)
            paths = [task.metres(path) for path in best.paths]
            fitness = run.fitness(paths, strict=True)
            if self._polishes:
                fitness = np.concatenate((fitness, self._polished(paths)))
            run.record(generations, fitness)
            if fitness.max() > 1 or run.stopped_by() not in (None, "generations"):
                return
            # The chip found no way from end to end, or one that only it believes.
            found = best.classes[0] is PathClass.FEASIBLE
            change = -1 if found else 1

    def _ends(self, before: int, status: RunStatus) -> bool:
        """Tell the progress of a run; return True if a stop criterion ends it."""
        self._run.show(before + status.generations)
        stop = self._run.stop
        return (stop is not None and stop.requested) or self._run.out_of_time

    def _polished(self, paths: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Evaluate the paths with the lowest altitudes; return the fitness of each, (m,)."""
        # They load SciPy.
        from host.planners.altitudes import lowest_altitudes
        from host.planners.grid_search import Prices

        run = self._run
        with run.phase("polish"):
            prices = Prices(run.evaluator.problem)
            lowest = [
                lowest_altitudes(run.evaluator.problem, prices, path[:, :2]) for path in paths
            ]
        fitted = [path for path in lowest if path is not None]
        return run.fitness(fitted, strict=True) if fitted else np.zeros(0)

    def _bytes_since(self, before: Traffic) -> dict[str, int]:
        traffic = self._task.chip.link.traffic
        return {
            "to_board": traffic.bytes_to_board - before.bytes_to_board,
            "from_board": traffic.bytes_from_board - before.bytes_from_board,
        }

    def hardware(self) -> dict[str, Any]:
        """Return the block ``hardware`` of a summary."""
        chip, before = self._task.chip, self._traffic_before
        traffic = chip.link.traffic
        return {
            "clock_hz": chip.config.clock_hz,
            "build_id": f"{chip.config.build_id:08x}",
            "map": self._task.grid.report(),
            "cycles": dict(self._cycles),
            "plan_us": 1e6 * self.cycles / chip.config.clock_hz,
            "bytes": self._bytes_since(before),
            "frames": {
                "repeated": traffic.frames_repeated - before.frames_repeated,
                "damaged": traffic.frames_damaged - before.frames_damaged,
            },
            "generations": sum(done["generations"] for done in self._done),
            "runs": self._done,
        }
