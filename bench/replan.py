"""Replans in flight: 1,000 scenarios flown in JSBSim with every planner and a yardstick.

The yardstick is the best of all planners, called at the same instant, from the same state and
heading, and without any planning time (:mod:`bench.yardstick`): a flight that it survives can be
survived. It flies one scenario in ten, and all in which another row does not arrive, because a
flight that has arrived needs no proof that it can. Results are stored as they arrive, so that an
interrupted run can continue.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench import pages
from bench.campaign import measure
from bench.own_paths import own_path
from bench.replan_report import MODEL, arrived, report
from bench.replan_scenarios import KINDS, draw_mission, draw_scenario
from bench.report import Options, Report
from bench.store import Store
from bench.yardstick import AMPLE_MS, Yardstick
from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import prepare_directory
from pathgene.host.planning import Plan, Search
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.replanning import picture
from pathgene.host.replanning.calibration import measure_host_s
from pathgene.host.replanning.departure import Departure, depart, fault_of
from pathgene.host.replanning.fly import FALLBACK, on_board
from pathgene.host.replanning.outcome import Replanned, judge
from pathgene.host.replanning.pilot import Change
from pathgene.host.replanning.planner import Attempt, InFlightPlanner
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.session import Session
from pathgene.host.report import style


_SEEDS = range(2)


@dataclass(frozen=True)
class Question:
    """The state in which a flight asked for a new path."""

    departure: Departure
    present: Present
    #: The aircraft with its remaining fuel.
    aircraft: Aircraft
    #: Distance along the track from which it is checked again.
    since_m: float


def is_there_a_path(question: Question, chip: Chip) -> bool:
    """Return whether a chip's planner, with ample time, or ``astar`` finds a path."""
    departure = question.departure
    led = depart(question.present, departure.track, departure.leaves_m, is_committed=False)
    committed = depart(question.present, departure.track, departure.leaves_m, is_committed=True)
    searches = [(led, Search("astar"))]
    for seed in _SEEDS:
        own = {"board": chip, "chip_ms": AMPLE_MS, **own_path("ga-chip")}
        searches.append((committed, Search("ga-chip", seed=seed, **own)))
    return any(_finds(search, start, question) for start, search in searches)


def _finds(search: Search, departure: Departure, question: Question) -> bool:
    try:
        evaluator = Evaluator(departure.problem(question.present, question.aircraft), threads=1)
        plan = search.run(evaluator)
    except InputError:
        # Start or goal is in a zone, or in the ground.
        return False
    if not plan.evaluation.feasible:
        return False
    path = evaluator.track(plan.path).pieces
    return not fault_of(departure.joined(path, question.since_m), question.present)


#: Scenarios of a run.
SCENARIOS = 1_000
#: The yardstick's row.
YARDSTICK = "yardstick"
# The row of the chip's model.
_CHIP = MODEL
# Its planner and its board, which also check whether a path exists.
_MODEL = "ga-chip", "model:?core=planner"
#: Rows: planner, board, and n if the row flies one in n scenarios.
ROWS: dict[str, tuple[str, str, int]] = {
    YARDSTICK: ("astar", "", 10),
    _CHIP: (*_MODEL, 1),
    "ga-chip, sim:": ("ga-chip", "sim:?core=planner", 10),
    "astar": ("astar", "", 10),
    "fpa-2opt": ("fpa-2opt", "", 10),
    "ga-fpga, model:": ("ga-fpga", "model:", 10),
}
# Number of scenarios per task, so that a board is opened for several at once.
_BATCH = 12
_STORE = Path("build/bench/replans.json")
_PICTURES = Path("build/bench/replans")
_WORST = 10
# Key of the host's share in the store, and number of the mission that it is measured on.
_SHARE, _CALIBRATION = ("host", "share"), 3
_SOURCES = (
    "bench/replan.py",
    "bench/replan_scenarios.py",
    "bench/yardstick.py",
    "hdl/config.py",
    "hdl/protocol",
    "host/device",
    "host/evaluation",
    "host/flight",
    "host/planners",
    "host/problem",
    "host/replanning",
    "host/terrain",
    "sim/model",
)
Result = dict[str, Any]


def run(options: Options) -> Report:
    """Fly the first ``--seeds`` scenarios; ``--only`` selects rows by name.

    The tables of all rows are written to docs/replanning.md.

    Raises
    ------
    InputError
        If no row has this in its name.
    """
    rows = {name: row for name, row in ROWS.items() if options.only in name or name == YARDSTICK}
    if options.only and len(rows) == 1 and options.only not in YARDSTICK:
        raise InputError(f"No row has {options.only!r} in its name; there are {', '.join(ROWS)}.")
    count = SCENARIOS if options.seeds == Options.seeds else options.seeds
    _STORE.parent.mkdir(parents=True, exist_ok=True)
    kept = Store(_STORE, *_SOURCES)
    host_s = _host_s(kept)

    def keep(task: tuple[str, list[int], float | None], results: list[Result]) -> None:
        name, numbers, _ = task
        for number, result in zip(numbers, results, strict=True):
            kept.keep(name, str(number), result)

    def fly(wanted: dict[str, list[int]]) -> None:
        tasks = []
        for name, numbers in wanted.items():
            left = [number for number in numbers if kept.get(name, str(number)) is None]
            tasks += [
                (name, left[first : first + _BATCH], host_s)
                for first in range(0, len(left), _BATCH)
            ]
        # All planners of a scenario, one after another.
        tasks.sort(key=lambda task: task[1][0])
        print(f"replan: {sum(len(task[1]) for task in tasks)} flights", file=sys.stderr, flush=True)
        measure(
            "replan",
            tasks,
            fly_row,
            name=lambda task: f"{task[0]}, {task[1][0]} to {task[1][-1]}",
            keep=keep,
        )

    fly(
        {
            name: [number for number in range(count) if number // len(KINDS) % every == 0]
            for name, (_, _, every) in rows.items()
        }
    )
    others = [_results(kept, name, count) for name in rows if name != YARDSTICK]
    doubtful = {number for some in others for number, each in some.items() if not arrived(each)}
    fly({YARDSTICK: sorted(doubtful)})
    yardstick = _results(kept, YARDSTICK, count)
    if not options.only:
        results = {name: _results(kept, name, count) for name in ROWS}
        pages.keep("replan", report(results, yardstick, count))
    table = report({name: _results(kept, name, count) for name in rows}, yardstick, count)
    failed = [each["scenario"] for each in table.data["failures"] if each["row"] == _CHIP]
    _draw_worst(failed, kept, count, host_s)
    return table


def _host_s(kept: Store) -> float | None:
    """Return the host's share of a replan, measured once for a campaign; None if it is assumed."""
    known = kept.get(*_SHARE)
    if known is None:
        share_s = measure_host_s(draw_mission(_CALIBRATION))
        known = {"machine_s": share_s}
        kept.keep(*_SHARE, known)
    found: float | None = known["machine_s"]
    print(f"replan: the host's share is {found} s", file=sys.stderr, flush=True)
    return found


def fly_row(name: str, numbers: Sequence[int], host_s: float | None = None) -> list[Result]:
    """Fly scenarios by the planner of a row; return the results.

    Parameters
    ----------
    host_s : float, optional
        The host's share of a replan on the chip; by default it is assumed.
    """
    planner, board, _ = ROWS[name]
    results = []
    with ExitStack() as stack:
        chip = stack.enter_context(on_board(planner, board)) if board else None
        first_chip = chip
        if planner != "ga-chip":
            first_chip = stack.enter_context(on_board(*_MODEL))
        ample = stack.enter_context(on_board(*_MODEL))
        assert ample is not None
        for number in numbers:
            if chip is not None and chip.closed:
                chip = stack.enter_context(on_board(planner, board))
                first_chip = chip if planner == "ga-chip" else first_chip
            assert first_chip is not None
            results.append(_fly(name, number, chip, first_chip, ample, host_s))
    return results


def _fly(
    name: str,
    number: int,
    chip: Chip | None,
    first_chip: Chip,
    ample: Chip,
    host_s: float | None,
) -> Result:
    """Fly one scenario; with ``ample``, check if a path exists where none was found immediately."""
    mission = draw_mission(number)
    evaluator = Evaluator(mission, threads=1)
    first = _first_plan(evaluator, first_chip, number)
    if not first.evaluation.feasible:
        return {"flown": False}
    assert first.evaluation.flight_time_s is not None
    drawn = draw_scenario(number, mission, first.evaluation.flight_time_s)
    at_once = ample if name == YARDSTICK else None
    flown = _flown(name, number, mission, evaluator, first, chip, drawn.scenario, host_s, at_once)
    if isinstance(flown, str):
        return {"flown": True, "error": flown, "alive": False, "ended": "error"}
    outcome, session = flown.outcome, flown.session
    assert isinstance(session, _Timed)
    return {
        "flown": True,
        "host_s": flown.constant_s,
        "kind": drawn.kind,
        "terrain": drawn.terrain,
        "alive": outcome.alive,
        "ended": outcome.ended,
        "breaks": outcome.breaks,
        "clearance": round(outcome.clearance_flown_m, 2),
        "share": round(min(outcome.clearance_share, 1e6), 3),
        "zone": None if math.isinf(outcome.zone_distance_m) else round(outcome.zone_distance_m, 2),
        "ready": round(outcome.ready_share, 3),
        "changes": [_change(change, session, ample) for change in session.changes],
    }


def _first_plan(evaluator: Evaluator, chip: Chip, number: int) -> Plan:
    """Return the plan that every planner flies, made by the chip or else by astar."""
    planner = InFlightPlanner("ga-chip", board=chip, seed=number)
    # A map that is new to the chip costs cycles in its first run. With an extra first run, no
    # flight depends on earlier flights.
    planner.prepare(evaluator)
    plan = planner.prepare(evaluator)
    return plan if plan.evaluation.feasible else Search(FALLBACK, seed=number).run(evaluator)


def _flown(
    name: str,
    number: int,
    mission: Problem,
    evaluator: Evaluator,
    first: Plan,
    chip: Chip | None,
    scenario: Any,
    host_s: float | None = None,
    at_once: Chip | None = None,
) -> Replanned | str:
    """Fly a scenario, by the yardstick's planner if there is a chip for it, ``at_once``."""
    planner, board, _ = ROWS[name]
    plans: InFlightPlanner
    if at_once is not None:
        plans = Yardstick(at_once, seed=number)
    else:
        seconds = host_s if planner == "ga-chip" else None
        plans = InFlightPlanner(planner, board=chip, seed=number, seconds=seconds)
    try:
        plans.prepare(evaluator)
        fallback = None
        if any(event.board_lost for event in scenario.events):
            fallback = InFlightPlanner(FALLBACK, seconds=plans.constant_s if chip is None else None)
            fallback.prepare(evaluator)
        session = _Timed(mission, first.path, plans, scenario, fallback=fallback)
        session.run()
    except (InputError, JobError) as error:
        return str(error)
    return Replanned(session, judge(session), planner, board or None, plans.constant_s)


def _change(change: Change, session: _Timed, ample: Chip) -> Result:
    told = change.to_dict()
    question = session.questions.get(id(change))
    kept = ("at_s", "what", "needed", "active_ms", "flown_m", "held", "fitness")
    parts = ("planner", "chip_ms", "round_trips_ms", "host_ms", "total_ms", "reason")
    return {
        **{key: told[key] for key in kept},
        "measured_ms": session.host_ms.get(id(change)),
        "at_once": question is not None
        and (told["attempts"][0]["found"] or is_there_a_path(question, ample)),
        "attempts": [[attempt[key] for key in parts] for attempt in told["attempts"]],
    }


class _Timed(Session):
    """A flight that measures the host's computing time for a new path, without waits for a board.

    ``host_ms`` of the latest path and immediate ``questions`` are indexed by the identity of a
    change.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        self.host_ms: dict[int, float] = {}
        self.questions: dict[int, Question] = {}
        super().__init__(*args, **options)

    def _plan(self, change: Change, now: float) -> None:
        before, began = len(change.attempts), time.perf_counter()
        super()._plan(change, now)
        seconds = time.perf_counter() - began
        for _, attempt in change.attempts[before:]:
            if attempt.plan is not None:
                waited_s = attempt.plan.result.seconds.get("link", 0.0)
                self.host_ms[id(change)] = 1000 * (seconds - waited_s)

    def _attempted(self, planner: InFlightPlanner, departure: Departure) -> Attempt:
        change, pilot = self._change, self.pilot
        assert change is not None
        if change.needed and change.at_s == pilot.time_s:
            since_m = departure.leaves_m if pilot.kind == "way-out" else pilot.along_m
            self.questions[id(change)] = Question(departure, self._present, pilot.aircraft, since_m)
        return super()._attempted(planner, departure)


def _results(kept: Store, name: str, count: int) -> dict[int, Result]:
    found = {number: kept.get(name, str(number)) for number in range(count)}
    return {number: result for number, result in found.items() if result and result["flown"]}


def _draw_worst(failed: Sequence[int], kept: Store, count: int, host_s: float | None) -> None:
    """Draw the worst flights of the chip's model: failures, further losses, minimum clearances."""
    others = _results(kept, _CHIP, count)
    lowest = sorted(
        others, key=lambda number: (others[number]["alive"], others[number].get("share", math.inf))
    )
    worst = list(dict.fromkeys((*failed, *lowest)))[:_WORST]
    if not worst:
        return
    prepare_directory(_PICTURES)
    planner, board, _ = ROWS[_CHIP]
    for number in worst:
        mission = draw_mission(number)
        evaluator = Evaluator(mission, threads=1)
        with on_board(planner, board) as chip:
            assert chip is not None
            first = _first_plan(evaluator, chip, number)
            assert first.evaluation.flight_time_s is not None
            drawn = draw_scenario(number, mission, first.evaluation.flight_time_s)
            flown = _flown(_CHIP, number, mission, evaluator, first, chip, drawn.scenario, host_s)
        if isinstance(flown, Replanned):
            style.save(picture.draw(flown), _PICTURES / f"{number:04d}.png")
