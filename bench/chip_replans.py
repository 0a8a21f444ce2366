"""Replanning on the chip: a disc appears ahead of the aircraft; its model continues from there."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from statistics import mean

import numpy as np
from numpy.typing import NDArray

from bench.campaign import measure
from bench.chip_runs import BOARD_URL, terrains
from bench.report import Options, Report
from bench.scenarios import missing, problem
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners import base as planners
from pathgene.host.planners.chip.schedule import chip_time
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone


#: Scenarios of each terrain.
SCENARIOS = 23
_FLIGHT_MS = 10
# Shares: the place of the aircraft along its path, and the radius relative to the straight line.
_PLACES, _RADII = (0.05, 0.6), (0.02, 0.08)
_CLEAR_RADII = 2.0
_TRIES = 1000
_STEPS = 512
_TRACK_STEP_M = 10.0
#: The retry takes the next seed, so the seeds of a row must not be consecutive.
_SEEDS_APART = 1000


@dataclass(frozen=True)
class Setting:
    """Rules of a problem, and the board. With a heading, the aircraft continues along its path."""

    rules: Rules | None
    heading: bool = False
    board: str = "model:?core=planner"


_NO_DEMANDS = Rules(clearance_m=0, corridor_m=0, zone_margin_m=0, reserve=0)
#: The evaluation in paper mode ignores headings, so these problems have rules without limits.
SETTINGS = {
    "paper mode": Setting(None),
    "by the rules": Setting(Rules()),
    "with a heading": Setting(_NO_DEMANDS, heading=True),
    "paper mode, ulx3s-85f": Setting(None, board=BOARD_URL),
    "with a heading, ulx3s-85f": Setting(_NO_DEMANDS, heading=True, board=BOARD_URL),
}


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    setting: str
    #: Number of seeds of the replan, each used in all scenarios.
    seeds: int = 1
    #: Count a path that the host has made feasible by a repair.
    repairs: bool = False
    #: Also count the second run, which follows if no repair succeeds.
    retries: bool = False
    #: Milliseconds of a run from new seeds; 0 means a replan.
    cold_ms: int = 0


#: The rows of the table.
ROWS = {
    "paper mode, two seeds": Row("paper mode", seeds=2),
    "paper mode, and a repair": Row("paper mode", seeds=2, repairs=True),
    "paper mode, and a retry": Row("paper mode", seeds=2, repairs=True, retries=True),
    "by the rules": Row("by the rules"),
    "with a heading, two seeds": Row("with a heading", seeds=2),
    "with a heading, and a repair": Row("with a heading", seeds=2, repairs=True),
    "with a heading, and a retry": Row("with a heading", seeds=2, repairs=True, retries=True),
    "paper mode, sizes of the ulx3s-85f, two seeds": Row("paper mode, ulx3s-85f", seeds=2),
    "with a heading, sizes of the ulx3s-85f, two seeds": Row("with a heading, ulx3s-85f", seeds=2),
    "paper mode from new seeds, 2 ms": Row("paper mode", cold_ms=2),
    "paper mode from new seeds, 5 ms": Row("paper mode", cold_ms=5),
}


@dataclass(frozen=True)
class Scenario:
    """A flight that must be replanned: the aircraft's place, its heading, and a new disc."""

    start: tuple[float, float, float]
    heading_deg: float
    disc: Zone


@dataclass(frozen=True)
class Outcome:
    """Runs of one plan: its ``fitness``, and whether it is ``feasible`` by the strict rule.

    ``cycles`` are the cycles of the runs, ``drawing`` the cycles of drawing the disc, and
    ``whole_ms`` the milliseconds of the plan: see
    :class:`pathgene.host.planners.chip.schedule.ChipTime`.
    """

    fitness: float
    feasible: bool
    cycles: int
    drawing: int
    whole_ms: float


@dataclass(frozen=True)
class Case:
    """A measured scenario: F of ``astar``, None if it finds no path, and one outcome per row."""

    astar: float | None
    outcomes: dict[str, list[Outcome]]


def run(options: Options) -> Report:
    """Measure the rows with ``only`` in their names, all by default."""
    rows = {name: row for name, row in ROWS.items() if options.only in name}
    if not rows:
        raise InputError(f"No row has {options.only!r} in its name; there are {', '.join(ROWS)}.")
    count = min(options.seeds, SCENARIOS)
    tasks = [
        (
            setting,
            terrain,
            count,
            {name: row for name, row in rows.items() if row.setting == setting},
        )
        for setting in dict.fromkeys(row.setting for row in rows.values())
        for terrain in terrains()
    ]
    found = measure(
        "chip-replans",
        [(task,) for task in tasks],
        _measure,
        name=lambda task: f"{task[0][0]}, {task[0][1]}",
    )
    cases = list(chain.from_iterable(found))
    report = Report(
        f"Replanning on the chip: {count} scenarios of each terrain, 100 MHz, 8 lanes",
        (
            "replan",
            "feasible, where astar finds a path",
            "mean F against astar",
            "kilocycles, mean",
            "kilocycles, p99",
            "drawing, mean",
            "drawing, most",
            "ms with the line, mean",
            "ms, p99",
        ),
        notes=[
            "A path of 10 ms is flown. At a random place between 5 and 60 % of it a disc of 2 to "
            "8 % of the straight line appears around a point of the path ahead, its edge at least "
            "two turning radii from aircraft and goal, and the start moves to the aircraft. "
            "Cycles from PROBLEM to BEST by the chip's counter. The last columns add the bytes of "
            "both directions at 3 Mbaud: BLOCK, MAP near the ends, PROBLEM, RUN, and BEST until "
            "the run is over. Not counted: answers that come while commands are sent or the run "
            "works, drawing meanwhile, the upload for new seeds. A repair mends the best path or "
            "the second on the host: another way at an end, or other altitudes. A retry follows "
            "where no repair helps: a run of at most 2.8 ms from new seeds.",
            *missing(),
        ],
    )
    for name in rows:
        measured = [(case.astar, each) for case in cases for each in case.outcomes.get(name, [])]
        report.rows.append((name, *_cells(measured, warm=not rows[name].cold_ms)))
        report.data[name] = [
            {"astar": astar, **dataclasses.asdict(each)} for astar, each in measured
        ]
    return report


def _cells(measured: Sequence[tuple[float | None, Outcome]], *, warm: bool) -> tuple[object, ...]:
    """Return the cells of a row for all outcomes, each next to the F of ``astar``."""
    known = [(astar, each) for astar, each in measured if astar is not None]
    gains = [each.fitness - astar for astar, each in known if each.feasible]
    every = [each for _, each in measured]
    kilocycles = [each.cycles / 1000 for each in every]
    whole = [each.whole_ms for each in every]
    drawn = [each.drawing / 1000 for each in every]
    share = f" ({100 * len(gains) / len(known):.1f} %)" if known else ""
    return (
        f"{len(gains)} of {len(known)}{share}",
        f"{mean(gains):+.4f}" if gains else "-",
        f"{mean(kilocycles):.1f}",
        f"{np.percentile(kilocycles, 99):.1f}",
        *((f"{mean(drawn):.1f}", f"{max(drawn):.1f}") if warm else ("-", "-")),
        *((f"{mean(whole):.2f}", f"{np.percentile(whole, 99):.2f}") if warm else ("-", "-")),
    )


def scenario(flown: Problem, path: NDArray[np.float64], seed: Sequence[int]) -> Scenario:
    """Draw the scenario of a flight along the points of its track; all draws follow from ``seed``.

    Raises
    ------
    InputError
        If the path leaves no room for a disc.
    """
    source = np.random.default_rng(list(seed))
    straight_m = math.dist(flown.start[:2], flown.goal[:2])
    along = np.concatenate(([0.0], np.hypot(*np.diff(path[:, :2], axis=0).T).cumsum()))
    reason: InputError | None = None
    for _ in range(_TRIES):
        place_m = source.uniform(*_PLACES) * along[-1]
        radius_m = source.uniform(*_RADII) * straight_m
        start = _point(path, along, place_m)
        ahead = np.array(
            [_point(path, along, at) for at in np.linspace(place_m, along[-1], _STEPS)]
        )
        clear_m = radius_m + _CLEAR_RADII * flown.limits.turn_radius_m
        is_clear = np.logical_and.reduce(
            [
                np.hypot(*(ahead[:, :2] - np.array(end[:2])).T) >= clear_m
                for end in (start, flown.goal)
            ]
        )
        if not is_clear.any():
            continue
        x, y, _ = source.choice(ahead[is_clear]).tolist()
        segment = min(int(np.searchsorted(along, place_m, "right")), len(path) - 1)
        east, north, _ = path[segment] - path[segment - 1]
        found = Scenario(start, math.degrees(math.atan2(east, north)), Zone.circle(x, y, radius_m))
        try:
            # The aircraft may be in the margin of a zone.
            changed_problem(flown, [found.disc], found.start)
        except InputError as error:
            reason = error
            continue
        return found
    raise reason or InputError("The path leaves no room for a disc.")


def _point(
    path: NDArray[np.float64], along: NDArray[np.float64], at: float
) -> tuple[float, float, float]:
    x, y, z = (float(np.interp(at, along, path[:, axis])) for axis in range(3))
    return x, y, z


def _measure(task: tuple[str, str, int, dict[str, Row]]) -> list[Case]:
    """Measure the scenarios of a terrain, on one open board."""
    setting, terrain, count, rows = task
    of_setting = SETTINGS[setting]
    flown = Evaluator(dataclasses.replace(problem(terrain), rules=of_setting.rules), threads=1)
    cases = []
    with open_board(of_setting.board) as chip:
        for number in range(count):
            flight = _fly(chip, flown, number)
            if not flight.evaluation.feasible:
                continue  # Nobody flies it.
            track = flown.track(flight.path).sample(_TRACK_STEP_M)
            points = np.column_stack((track.x, track.y, track.z))
            drawn = scenario(flown.problem, points, (number, *terrain.encode()))
            heading = drawn.heading_deg if of_setting.heading else None
            changed = changed_problem(flown.problem, [drawn.disc], drawn.start, heading)
            evaluator = Evaluator(changed, threads=1)
            found = make("astar").plan(
                evaluator, planners.Options(generations=PLANNERS["astar"].generations)
            )
            outcomes = _outcomes(chip, rows, flown, evaluator, number)
            cases.append(
                Case(found.evaluation.fitness if found.evaluation.feasible else None, outcomes)
            )
    return cases


def _outcomes(
    chip: Chip, rows: Mapping[str, Row], flown: Evaluator, evaluator: Evaluator, number: int
) -> dict[str, list[Outcome]]:
    """Plan a scenario by every row."""
    outcomes: dict[str, list[Outcome]] = {name: [] for name in rows}
    for seed in range(max((row.seeds for row in rows.values() if not row.cold_ms), default=0)):
        # Plan the flight again, because a replan continues from its map and its population.
        replanner = _fly(chip, flown, number).replanner
        assert replanner is not None
        result = replanner.replan(evaluator, planners.Options(seed=_SEEDS_APART * seed))
        for name, row in rows.items():
            if not row.cold_ms and seed < row.seeds:
                outcomes[name].append(_outcome(result, row))
    for name, row in rows.items():
        if row.cold_ms:
            result = _on_chip(chip, evaluator, row.cold_ms, number)
            outcomes[name].append(_outcome(result, row))
    return outcomes


def _fly(chip: Chip, flown: Evaluator, number: int) -> planners.Result:
    """Plan a flight: the same path and population whatever map the chip had before."""
    # The first run scans the blocks that differ, and that takes time from its generations.
    _on_chip(chip, flown, 1, number)
    return _on_chip(chip, flown, _FLIGHT_MS, number)


def _on_chip(chip: Chip, evaluator: Evaluator, chip_ms: int, seed: int) -> planners.Result:
    """Plan from new seeds by runs of a few milliseconds."""
    planner = make("ga-chip", board=chip, chip_ms=chip_ms, polish="off")
    generations = PLANNERS["ga-chip"].generations
    return planner.plan(evaluator, planners.Options(seed=seed, generations=generations))


def _outcome(result: planners.Result, row: Row) -> Outcome:
    """Return the outcome of the first run alone, or of all the steps that the row counts."""
    assert result.hardware is not None
    runs = result.hardware["runs"]
    counted = runs if row.retries else runs[:1]
    # A repair only follows a run that has found nothing, and a second run only follows a failed
    # repair.
    is_counted = len(counted) == len(runs) and (row.repairs or runs[0]["repairs"] == 0)
    return Outcome(
        result.evaluation.fitness,
        result.evaluation.feasible and is_counted,
        sum(done["cycles"] for done in counted),
        result.hardware["drawing_cycles"],
        1000 * chip_time(result.hardware, len(counted)).whole_s,
    )
