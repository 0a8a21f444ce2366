"""Runs a plan's searches on a chip, evaluates their paths and records statistics."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.protocol.codes import UNITS
from pathgene.hdl.protocol.planner import PathClass
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.runs import BestPaths, RunStatus
from pathgene.host.device.transport import Traffic
from pathgene.host.planners.base import Run
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.planners.grid.repairs import repair
from pathgene.host.stages import stage


__all__ = ["ChipRuns"]


class ChipRuns:
    """The runs of one plan; see :class:`pathgene.host.planners.chip.ga_chip.ChipGeneticPlanner`.

    Parameters
    ----------
    polishes : bool
        Each path is also polished; see :func:`pathgene.host.planners.chip.polish.polished`.
    repairs : bool
        If no path of a run is feasible, the best is repaired and, after the first run, the second
        best too; see :func:`pathgene.host.planners.grid.repairs.repair`.
    meanwhile : callable
        Called in each run, when its commands have been sent.
    """

    def __init__(
        self,
        task: ProblemOnChip,
        run: Run,
        *,
        polishes: bool = False,
        repairs: bool = False,
        meanwhile: Callable[[], object] = lambda: None,
    ) -> None:
        self._task, self._run, self._meanwhile = task, run, meanwhile
        self._polishes, self._repairs = polishes, repairs
        self._traffic_before = self._traffic_noted = replace(task.chip.link.traffic)
        self._done: list[dict[str, Any]] = []
        self._cycles = dict.fromkeys((*UNITS, "total"), 0)
        # How to ease the map before the next run.
        self._change = 0

    @property
    def cycles(self) -> int:
        """Cycles of all runs."""
        return self._cycles["total"]

    def move_to(self, task: ProblemOnChip) -> None:
        """Continue on another map of the same problem."""
        self._task, self._change = task, 0

    def search(self, first: Iterable[RunOptions], further: Sequence[RunOptions] = ()) -> bool:
        """Execute ``first`` runs until a path is feasible, then the later runs.

        A stop criterion ends the search. After a first run without a path, the map is lowered
        around the ends. Returns whether the search is over: a path is feasible, or a criterion has
        ended it.
        """
        for options in first:
            if self._change:
                self._task.ease(self._change)
            best, is_found = self._do(options, is_last=not further)
            if self._is_stopped:
                return True
            if is_found:
                break
            # The chip found no route from end to end, or only one that the host does not accept.
            self._change = -1 if best.classes[0] is PathClass.FEASIBLE else 1
        else:
            return False
        for number, options in enumerate(further, 1):
            self._do(options, is_last=number == len(further))
            if self._is_stopped:
                break
        return True

    def _do(self, options: RunOptions, *, is_last: bool) -> tuple[BestPaths, bool]:
        """Execute a run and judge its paths; return them, and whether one is feasible."""
        run, task, before = self._run, self._task, self._generations
        with run.phase("link"):
            status, best = task.run(options, functools.partial(self._ends, before), self._meanwhile)
        for unit in UNITS:
            self._cycles[unit] += getattr(status, unit)
        self._cycles["total"] += status.cycles
        self._done.append(
            {
                "seed": options.seed,
                "warm": options.warm,
                "guided": options.guided,
                "generations": status.generations,
                "cycles": status.cycles,
                "ease": task.eased,
                "classes": [each.name.lower() for each in best.classes],
                "waypoints": [len(path) for path in best.paths],
                "limit": options.cycles,
                "looks": task.looks,
                "waits": dict(vars(task.waits)),
                "bytes": self._bytes_since(self._traffic_noted),
                "repairs": 0,
            }
        )
        self._traffic_noted = replace(task.chip.link.traffic)
        paths = [task.metres(path) for path in best.paths]
        fitness = run.fitness(paths, strict=True)
        if self._polishes and (is_last or fitness.max() <= 1 or self._is_stopped):
            fitness = np.concatenate((fitness, self._polished(paths)))
        if self._repairs and fitness.max() <= 1 and not self._is_stopped:
            fitness = np.append(fitness, self._repaired(paths))
        run.record(self._generations, fitness)
        return best, bool(fitness.max() > 1)

    @property
    def _generations(self) -> int:
        return sum(done["generations"] for done in self._done)

    @property
    def _is_stopped(self) -> bool:
        return self._run.stopped_by() not in (None, "generations")

    def _ends(self, before: int, status: RunStatus) -> bool:
        """Report the progress of a run; return True if a stop criterion ends it."""
        self._run.show(before + status.generations)
        stop = self._run.stop
        return (stop is not None and stop.requested) or self._run.out_of_time

    def _repaired(self, paths: list[NDArray[np.float64]]) -> float:
        """Repair paths and evaluate them until one is feasible; return the fitness of the last one.

        After the first run these are the two best paths; after later runs only the best, because
        another run is worth more than the second path.
        """
        run, fitness = self._run, 0.0
        most = 2 if len(self._done) == 1 else 1
        with run.phase("repair"):
            for path in paths[:most]:
                self._done[-1]["repairs"] += 1
                mended = repair(run.evaluator, path)
                if mended is not None:
                    fitness = float(run.fitness([mended], strict=True)[0])
                if fitness > 1:
                    break
        return fitness

    def _polished(self, paths: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Evaluate the polished paths; return the fitness of each, (m,)."""
        # It loads HiGHS.
        from pathgene.host.planners.chip.polish import polished

        run = self._run
        stage("lowering the paths")
        with run.phase("polish"):
            fitted = polished(run.evaluator.problem, paths)
        return run.fitness(fitted, strict=True) if fitted else np.zeros(0)

    def _bytes_since(self, before: Traffic) -> dict[str, int]:
        traffic = self._task.chip.link.traffic.since(before)
        return {"to_board": traffic.bytes_to_board, "from_board": traffic.bytes_from_board}

    def hardware(self) -> dict[str, Any]:
        """Return the block ``hardware`` of a summary."""
        chip, before = self._task.chip, self._traffic_before
        traffic = chip.link.traffic.since(before)
        return {
            "clock_hz": chip.config.clock_hz,
            "build_id": f"{chip.config.build_id:08x}",
            "map": self._task.grid.report(),
            "cycles": dict(self._cycles),
            "plan_us": 1e6 * self.cycles / chip.config.clock_hz,
            "bytes": self._bytes_since(before),
            "frames": {
                "repeated": traffic.frames_repeated,
                "damaged": traffic.frames_damaged,
            },
            "generations": self._generations,
            "drawing_cycles": self._task.drawing_cycles,
            "exchanges": traffic.exchanges,
            "runs": self._done,
        }
