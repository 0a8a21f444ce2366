"""The host's share of a replan, measured on this machine before a flight.

The chip's time follows from cycles and bytes; the host's depends on the machine. A few replans of
the mission on the compiled model measure it, without the time of the model. The flight's own board
has no part in that, so a flight with the same share is the same flight.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from statistics import median

from pathgene.hdl.config import GeneticCore
from pathgene.host.device.boards import open_board, with_core
from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.machine import keep_memory
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.replanning.departure import depart, fault_of
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import pose_at, run_of


__all__ = ["measure_host_s"]

#: Chip time of the plan that is replanned, milliseconds.
_CHIP_MS = 10
#: Number of replans. The first ones load kernels and modules, and do not count.
_REPLANS, _FIRST = 13, 2
#: Beginnings of the plans and places of the zones, as shares of the path, and radius of a zone, as
#: a share of the straight line.
_STARTS, _ZONES, _RADIUS = (0.05, 0.2), (0.45, 0.7), 0.03
#: Distance from the aircraft to the beginning of a plan, metres.
_AHEAD_M = 3.0
#: The share is rounded to this many digits of a second, so that the printed number is exact.
_DIGITS = 5


def measure_host_s(
    mission: Problem, watch: Callable[[Chip], AbstractContextManager[object]] = nullcontext
) -> float | None:
    """Return the host's share of a replan without repair, seconds.

    It is the median of a few replans, in each of which a zone appears on the path of the mission
    ahead of the aircraft: all that a flight does from the change until the path can be passed on,
    from the check of the current track to the check of the new one. It is None if too few of them
    find a path in the first run.

    Parameters
    ----------
    watch : callable
        Receives the chip and returns a context manager in which a replan is measured.

    Raises
    ------
    JobError
        If the model cannot be opened.
    """
    # As in a flight: a replan must wait neither for SciPy, which this loads, nor for memory.
    importlib.import_module("pathgene.host.problem.no_fly_shape")
    keep_memory()
    measured = []
    with open_board(with_core("model:", GeneticCore.PLANNER)) as chip:
        search = Search("ga-chip", board=chip, chip_ms=_CHIP_MS, polish="off")
        evaluator = Evaluator(mission, threads=1)
        plan = search.run(evaluator)
        track = evaluator.track(plan.path).pieces
        for number in range(_REPLANS):
            zone, leaves_m = _change(plan, number / (_REPLANS - 1))
            waited_s, began = chip.link.traffic.waiting_s, time.perf_counter()
            try:
                with watch(chip):
                    present = Present(mission, (*mission.zones, zone), mission.goal, mission.wind)
                    present.safe_until_m(track, leaves_m - _AHEAD_M)
                    departure = depart(present, track, leaves_m, is_committed=True)
                    problem = departure.problem(present, mission.aircraft)
                    found = search.replan(plan, Evaluator(problem, threads=1))
                    path = found.evaluator.track(found.path).pieces
                    fault_of(departure.joined(path, leaves_m - _AHEAD_M), present)
            except InputError:
                # Start or goal is in the zone.
                continue
            spent_s = time.perf_counter() - began
            runs = [] if found.result.hardware is None else found.result.hardware["runs"]
            if [run["repairs"] for run in runs] == [0]:
                measured.append(spent_s - (chip.link.traffic.waiting_s - waited_s))
            # The next zone appears where there is none.
            search.replan(found, evaluator).finish()
    if len(measured) <= _FIRST:
        return None
    return round(median(measured[_FIRST:]), _DIGITS)


def _change(plan: Plan, share: float) -> tuple[Zone, float]:
    """Return a zone on the path of a plan, and a distance along it from which it lies ahead."""
    track = plan.evaluator.track(plan.path).pieces
    length_m = run_of(track)
    leaves_m, middle_m = (
        length_m * (low + share * (high - low)) for low, high in (_STARTS, _ZONES)
    )
    middle = pose_at(track, middle_m)
    problem = plan.evaluator.problem
    radius_m = _RADIUS * math.dist(problem.start[:2], problem.goal[:2])
    return Zone.circle(middle.x, middle.y, radius_m), leaves_m
