"""Flights of exported missions by every guidance: rows, the valley and refusals."""

import math

import numpy as np
import pytest

from bench import guided_flights
from bench.following import follow
from bench.guided_flights import GUIDANCES, GuidedRow, measure_missing, report, rows
from bench.store import Store
from pathgene.host.errors import InputError, JobError
from pathgene.host.mission.autopilot.late import LateClimbError


VALLEY = GuidedRow("valley", "silver-fox", "calm")


def test_the_valley_is_as_steep_as_the_aircraft():
    task = VALLEY.problem()
    is_feasible, path = VALLEY.plan(task)
    assert is_feasible
    runs, rises = np.diff(path[:, 0]), np.diff(path[:, 2])
    steepest = np.degrees(np.arctan(rises / runs))
    assert (steepest.min(), steepest.max()) == pytest.approx((-30, 10), abs=1e-3)
    x = np.arange(path[1, 0], path[-2, 0], 1.0)
    above = np.interp(x, path[:, 0], path[:, 2]) - [task.terrain.ground(each, 3000.0) for each in x]
    assert 35.0 - 1e-6 < above.min() < above.max() < 50.0
    # In a tail wind the same rates of climb and descent are gentler over the ground.
    along = GuidedRow("valley", "silver-fox", "along").plan
    is_feasible, gentle = along(GuidedRow("valley", "silver-fox", "along").problem())
    assert is_feasible
    assert gentle[-1, 0] > path[-1, 0] + 500


@pytest.mark.ci
def test_dives_and_climbs_keep_half_of_the_clearance():
    for guidance in GUIDANCES:
        result = guided_flights._measure(VALLEY, guidance)
        assert result["kept"], guidance
        assert result["clearance_share"] > 0.7, guidance


def test_a_refused_mission_is_named_so(monkeypatch, tmp_path):
    def refuse(*arguments, **options):
        raise JobError("No room.")

    monkeypatch.setattr(guided_flights, "fly", refuse)
    result = guided_flights._measure(VALLEY, "px4")
    assert result == {
        "found": True,
        "followed": [],
        "kept": False,
        "refused": "refused",
        "breaks": ["No room."],
    }
    store = Store(tmp_path / "flights.json", "bench/flight_rows.py")
    store.keep(VALLEY.name, "px4", result)
    made = report(store, [VALLEY])
    assert made.rows == [["valley silver-fox calm", "-", *[""] * 6, "refused", "-", "-"]]
    assert made.notes[0].startswith("Kept of 1: 0 with ideal, 0 with ardupilot, 0 with px4.")
    assert made.notes[-1] == "Flights not measured yet: 2."
    assert made.failed


def test_rows_are_named_and_measured_once(tmp_path):
    every = rows()
    assert len({row.name for row in every}) == len(every) == len(rows("guidance"))
    assert rows("no such row") == []
    store = Store(tmp_path / "flights.json", "bench/flight_rows.py")
    for guidance in GUIDANCES:
        store.keep(VALLEY.name, guidance, {"found": False, "kept": False})
    measure_missing(store, [VALLEY])
    assert report(store, [VALLEY]).rows == []


def test_sentences_of_refusals_are_followed():
    task = VALLEY.problem()

    def attempt(problem, _):
        if problem.start[2] == task.start[2]:
            raise LateClimbError("Start higher.", 7)
        return problem.start[2]

    done = follow(lambda: task, lambda _: (True, np.zeros(3)), attempt)
    assert (done.result, done.followed, done.refusal) == (
        task.start[2] + 7,
        ["start 7 m higher"],
        "",
    )

    def refuse(*_):
        raise JobError("No.")

    done = follow(lambda: task, lambda _: (True, np.zeros(3)), refuse)
    assert (done.result, done.followed, done.refusal) == (None, [], "No.")

    def impossible():
        raise InputError("Start in the ground.")

    done = follow(impossible, lambda _: (False, math.nan), refuse)
    assert (done.result, done.refusal, done.note) == (None, "", "Start in the ground.")
