"""A planned path flown while events happen: prepared, flown, judged, written."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from pathgene.hdl.config import GeneticCore
from pathgene.host.device.boards import entered
from pathgene.host.device.chip import Chip
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import json_bytes
from pathgene.host.files.replacement import replace_files
from pathgene.host.planners.base import Stop
from pathgene.host.problem.problem import Problem
from pathgene.host.replanning.calibration import measure_host_s
from pathgene.host.replanning.outcome import Replanned, judge
from pathgene.host.replanning.planner import HOST_S, InFlightPlanner
from pathgene.host.replanning.scenario import Scenario, check_mission
from pathgene.host.replanning.session import Session
from pathgene.host.report.run_files import FLIGHT


__all__ = ["FALLBACK", "draw", "fly_scenario", "on_board", "save", "underway", "write"]

#: The CPU planner that takes over if a board is lost.
FALLBACK = "astar"
#: The core of the board of each planner that has one.
_CORES = {"ga-chip": GeneticCore.PLANNER, "ga-fpga": GeneticCore.PAPER}


def on_board(planner: str, board: str) -> AbstractContextManager[Chip | None]:
    """Return a context manager of the board that a planner needs, or of None if it needs none.

    Raises
    ------
    InputError, JobError
        As for :func:`pathgene.host.device.boards.open_board`.
    """
    # The search refuses an unknown planner.
    if planner not in _CORES:
        return nullcontext()
    return entered(board, core=_CORES[planner])


def fly_scenario(
    mission: Problem,
    path: ArrayLike,
    scenario: Scenario,
    *,
    planner: str,
    board: str,
    stop: Stop | None = None,
    **options: Any,
) -> Replanned:
    """Fly a path of ``mission`` through a scenario to its end, or until ``stop`` ends it.

    A signal handler that raises :class:`KeyboardInterrupt` after the request also ends a plan in
    progress. Further parameters, and errors, are as for :func:`underway`.

    Raises
    ------
    KeyboardInterrupt
        If ``stop`` ends the flight before the start of the path.
    """
    stop = Stop() if stop is None else stop
    with underway(mission, path, scenario, planner=planner, board=board, **options) as (
        session,
        report,
    ):
        try:
            while not (session.ended or stop.requested):
                session.step()
        except KeyboardInterrupt:
            if not stop.requested:
                raise
        stop.heeded = True
        if not session.pilot.samples:
            raise KeyboardInterrupt
        return report()


@contextmanager
def underway(
    mission: Problem,
    path: ArrayLike,
    scenario: Scenario,
    *,
    planner: str,
    board: str,
    seconds: float | None = None,
    gusts: str = "none",
    seed: int = 0,
    say: Callable[[str], object] = lambda _: None,
) -> Iterator[tuple[Session, Callable[[], Replanned]]]:
    """Return a context manager that begins a flight and finally makes its report.

    Parameters
    ----------
    mission : Problem
        The problem that the path was planned for, with the rules of safe flight.
    path : array_like
        Its waypoints, (n, 3) metres.
    board : str
        URL of its board; ignored by a planner without one.
    seconds : float, optional
        Processor time of a plan, for the planner core the host's share; measured before the flight
        by default.
    gusts, seed
        Turbulence, and the common seed of turbulence and planner.

    Raises
    ------
    InputError
        If the scenario, the planner or the board is bad, or the plan cannot be replanned.
    JobError
        If the board cannot be started.
    """
    check_mission(mission, scenario)
    evaluator = Evaluator(mission, threads=1)
    with on_board(planner, board) as chip:
        if seconds is None and planner == "ga-chip":
            seconds = _host_s(mission, say)
        plans = InFlightPlanner(planner, board=chip, seed=seed, seconds=seconds)
        plans.prepare(evaluator)
        fallback = None
        if chip is not None:
            # Any board may fail.
            fallback = InFlightPlanner(FALLBACK, seed=seed)
            fallback.prepare(evaluator)
        session = Session(
            mission,
            path,
            plans,
            scenario,
            fallback=fallback,
            gusts=gusts,
            seed=seed,
            say=say,
        )
        yield (
            session,
            lambda: Replanned(
                session, judge(session), planner, board if chip else None, plans.constant_s
            ),
        )


def _host_s(mission: Problem, say: Callable[[str], object]) -> float | None:
    """Return the host's share of a replan on this machine; None if it cannot be measured."""
    try:
        share_s = measure_host_s(mission)
    except JobError as error:
        say(f"The host's share of a replan is assumed, {1000 * HOST_S:g} ms: {error}")
        return None
    if share_s is None:
        say(f"The host's share of a replan is assumed, {1000 * HOST_S:g} ms: too few have a path.")
        return None
    say(
        f"The host's share of a replan is {1000 * share_s:g} ms on this machine; "
        f"--planner-seconds {share_s:g} repeats this flight elsewhere."
    )
    return share_s


def save(report: Replanned, directory: Path) -> list[Path]:
    """Write ``flight.json``, ``flight.png`` and ``flight.gif``; return their paths."""
    return [write(report, directory), *draw(report, directory)]


def write(report: Replanned, directory: Path) -> Path:
    """Write ``flight.json``, and remove misleading pictures of an earlier flight."""
    replace_files(directory, {FLIGHT[0]: json_bytes(report.to_dict())}, gone=FLIGHT)
    return directory / FLIGHT[0]


def draw(report: Replanned, directory: Path) -> list[Path]:
    """Write ``flight.png`` and ``flight.gif``; return their paths."""
    # Loads matplotlib, which flying does not need.
    from pathgene.host.replanning import animation, picture
    from pathgene.host.report import style

    written = [directory / name for name in FLIGHT[1:]]
    style.save(picture.draw(report), written[0])
    animation.write(report, written[1])
    return written
