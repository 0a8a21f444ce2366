"""A planner that plans during a flight, and the time that it would take on board.

The time is virtual: the time of the planner core is computed from cycles and bytes, and the time of
a CPU planner is a constant, measured once before the flight. With the same constants, a flight is
therefore the same on every machine.
"""

from __future__ import annotations

import importlib
import time
from dataclasses import dataclass, replace
from typing import Any

from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.machine import keep_memory
from pathgene.host.planners.chip.schedule import chip_time, line_s
from pathgene.host.planners.grid.astar import QUICK_SEARCHES
from pathgene.host.planners.grid.repairs import load_repairs
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.problem import Problem


__all__ = [
    "HOST_S",
    "PATIENCE_S",
    "REPAIR_S",
    "ROUND_TRIP_S",
    "Attempt",
    "InFlightPlanner",
    "PlanningTime",
]

#: The host's share of a plan on the chip, map changes and strict check, where nothing has measured
#: it; see :mod:`pathgene.host.replanning.calibration`.
HOST_S = 0.007
#: Extra time of the host for each repair of an infeasible path. A fixed figure; the benchmark
#: measures the sum of both.
REPAIR_S = 0.007
#: A request and its reply through a USB port, without line and chip. A fixed figure: the minimum
#: latency timer of common ports.
ROUND_TRIP_S = 0.001
#: How long a host in the air waits for a silent board.
PATIENCE_S = 0.1
#: Chip time of the plan before the flight, whose population replans continue from.
_CHIP_MS = 10
#: A plan is expected within this multiple of its usual time.
_SLACK = 1.3
#: The same for the chip: all runs of a replan, and the repair after each.
_CHIP_BUDGET_S = 0.125
_MEASURED = 2
_SEEDS_APART = 16


@dataclass(frozen=True)
class PlanningTime:
    """Virtual time of a plan, in seconds.

    Parameters
    ----------
    chip_s : float
        Time of cycles on the chip and bits on the line until the host has the paths.
    round_trips_s : float
        Latency of requests and replies, and time of the answer to STATUS after the last paths.
    """

    chip_s: float = 0.0
    round_trips_s: float = 0.0
    host_s: float = 0.0

    @property
    def total_s(self) -> float:
        """Sum of all parts."""
        return self.chip_s + self.round_trips_s + self.host_s

    def to_dict(self) -> dict[str, float]:
        """The time in milliseconds, as in a report."""
        return {
            "chip_ms": 1000 * self.chip_s,
            "round_trips_ms": 1000 * self.round_trips_s,
            "host_ms": 1000 * self.host_s,
            "total_ms": 1000 * self.total_s,
        }


@dataclass(frozen=True)
class Attempt:
    """An attempt to plan.

    Parameters
    ----------
    plan : Plan or None
        A feasible plan; None if there is none.
    reason : str
        Why there is no plan; empty if there is one.
    hopeless : bool
        Neither a different seed nor a different start would help.
    """

    plan: Plan | None
    time: PlanningTime
    planner: str
    reason: str = ""
    hopeless: bool = False

    def refused(self, reason: str, *, hopeless: bool = False) -> Attempt:
        """Return the attempt without its plan, which cannot be used."""
        return replace(self, plan=None, reason=reason, hopeless=hopeless)


class InFlightPlanner:
    """A planner for use during a flight.

    Parameters
    ----------
    name : str
        A name in :data:`pathgene.host.planners.PLANNERS`.
    board : Chip, optional
        An open board, for planners that run on one.
    seed : int
        Seed of the first plan.
    seconds : float, optional
        Time of a plan on the processor, for ``ga-chip`` the host's share of a search. By default
        :meth:`prepare` measures it, and the share is :data:`HOST_S`. 0 stands for an ideal planner
        that takes no time, as a yardstick.

    Attributes
    ----------
    lost : str
        Why the board is no longer available; empty while it is available.
    """

    def __init__(
        self, name: str, *, board: Chip | None = None, seed: int = 0, seconds: float | None = None
    ) -> None:
        self.name, self.board, self.seed = name, board, seed
        self.constant_s = 0.0 if seconds is None else seconds
        self._given = seconds
        self.lost = ""
        self._search = self._searching(0)
        self._plan: Plan | None = None
        self._usual_s = self.constant_s

    @property
    def is_on_chip(self) -> bool:
        """True if the whole planner runs on the chip."""
        return self.name == "ga-chip"

    @property
    def budget_s(self) -> float:
        """Time within which a plan is expected; the path begins that far ahead."""
        if self.is_on_chip:
            return _CHIP_BUDGET_S
        return _SLACK * self._usual_s

    def prepare(self, evaluator: Evaluator) -> Plan:
        """Plan the mission before the flight: upload the map to the chip and time the processor.

        From then on the process keeps freed memory; see :mod:`pathgene.host.machine`.

        Raises
        ------
        InputError, JobError
            As for the planner.
        """
        # A replan must wait neither for SciPy, which this loads, nor for memory.
        importlib.import_module("pathgene.host.problem.no_fly_shape")

        keep_memory()

        measured = []
        count = 1 if self.board is not None or self._given is not None else _MEASURED
        for _ in range(count):
            began = time.perf_counter()
            self._plan = self._search.run(evaluator)
            measured.append(time.perf_counter() - began)
        plan = self._plan
        assert plan is not None
        if self.is_on_chip:
            # Nor for the modules of repairs.
            load_repairs(evaluator, plan.path)
        seconds = plan.result.seconds
        if self._given is None:
            self.constant_s = min(measured)
            if self.board is not None:
                # For a planner on chip and host, the host's own phases.
                self.constant_s = HOST_S if self.is_on_chip else _host_s(seconds)
        self._usual_s = self._time(plan).total_s
        return plan

    def lose_board(self) -> None:
        """Declare the board lost: every later attempt fails after the host's patience."""
        if self.board is not None:
            self.board.close()
            self.lost = "The board is lost."

    def attempt(self, problem: Problem, number: int) -> Attempt:
        """Plan a changed problem; ``number`` counts the attempts since the change, from 0."""
        waited = PlanningTime(host_s=PATIENCE_S)
        if self.lost:
            return Attempt(None, waited, self.name, self.lost)
        search = self._searching(number)
        before = self._plan
        assert before is not None, "prepare comes first"
        try:
            plan = search.replan(before, Evaluator(problem, threads=1))
        except InputError as error:
            # There may be a path from a different start.
            return Attempt(None, PlanningTime(host_s=self.constant_s), self.name, str(error))
        except JobError as error:
            self.lost = str(error)
            return Attempt(None, waited, self.name, self.lost)
        if plan.failure is not None:
            self.lost = plan.failure
            return Attempt(None, waited, self.name, self.lost)
        self._plan = plan
        taken, finishing = self._time(plan), self._finish(plan)
        if not plan.evaluation.feasible:
            # The next attempt waits for it.
            taken = PlanningTime(
                taken.chip_s + finishing.chip_s,
                taken.round_trips_s + finishing.round_trips_s,
                taken.host_s,
            )
            return Attempt(None, taken, self.name, "The planner found no feasible path.")
        return Attempt(plan, taken, self.name)

    def _finish(self, plan: Plan) -> PlanningTime:
        """Finish a plan on the board; return its time on the line."""
        if self.board is None:
            plan.finish()
            return PlanningTime()
        before = replace(self.board.link.traffic)
        plan.finish()
        traffic = self.board.link.traffic.since(before)
        line = line_s(traffic.bytes_to_board + traffic.bytes_from_board)
        return PlanningTime(line, ROUND_TRIP_S * traffic.exchanges)

    def _searching(self, number: int) -> Search:
        options: dict[str, Any] = {"seed": self.seed + _SEEDS_APART * number}
        if self.board is not None:
            options["board"] = self.board
        if self.is_on_chip:
            options |= {"chip_ms": _CHIP_MS, "polish": "off"}
        if self.name == "astar":
            # An aircraft cannot wait for the narrow searches, nor does the constant time hold them.
            options["generations"] = QUICK_SEARCHES
        return Search(self.name, **options)

    def _time(self, plan: Plan) -> PlanningTime:
        hardware = plan.result.hardware
        if hardware is None:
            return PlanningTime(host_s=self.constant_s)
        if self.is_on_chip:
            taken = chip_time(hardware)
            repairs = sum(done["repairs"] for done in hardware["runs"])
            return PlanningTime(
                taken.whole_s,
                taken.status_s + ROUND_TRIP_S * taken.exchanges,
                self.constant_s * hardware.get("searches", 1) + REPAIR_S * repairs,
            )
        line = line_s(sum(hardware["bytes"].values()))
        # One request per generation.
        trips_s = ROUND_TRIP_S * plan.result.generations
        return PlanningTime(plan.result.seconds["board"] + line, trips_s, self.constant_s)


def _host_s(seconds: dict[str, float]) -> float:
    """Return the processor's share of a plan on chip and host."""
    return sum(seconds.get(phase, 0.0) for phase in ("evaluation", "sort", "choice", "map"))
