"""Flights in processes of the desk: what is seen, what can be ordered, what is saved."""

import math
import re
import time

import pytest

from host.errors import InputError
from host.inputs import parse_json
from host.problem.zones import Zone
from host.web.desk.flight import AHEAD, CLEAR, FASTEST, Goal, Speed
from host.web.desk.job import FlightJob
from host.web.desk.jobs import Jobs
from host.web.desk.saving import files_of


pytestmark = pytest.mark.ci  # Flies.
CANYON = {
    "terrain": "canyon",
    "start": (300.0, 300.0, 60.0),
    "goal": (4700.0, 4600.0, 60.0),
    "agl": True,
    "planner": "astar",
}


def until(condition, limit_s=180.0):
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.01)


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """The jobs of a desk, and the folder of a saved plan of it."""
    jobs = Jobs(tmp_path_factory.mktemp("desk"), at_once=1, waiting=2)
    job = jobs.submit(CANYON, "canyon")
    until(lambda: job.done)
    yield jobs, job.folder
    jobs.close()


@pytest.fixture
def take_off(planned):
    """Function that flies the plan by a planner."""
    jobs, folder = planned

    def start(planner="ga-chip", board="model:"):
        job = FlightJob(folder, planner=planner, board=board)
        jobs.fly(job)
        until(lambda: job.seen or job.done)
        assert job.error is None
        return job

    return start


def said(job):
    return " ".join(sentence for each in job.seen for sentence in each.said)


def changes(job):
    told = [each.changes for each in job.seen if each.changes]
    return told[-1] if told else []


def test_what_is_ordered_happens(planned, take_off):
    jobs, folder = planned
    job = take_off()
    first = job.seen[0]
    assert first.zones == []
    assert [point["kind"] for point in first.points] == ["start", "goal"]
    assert [kind for kind, _ in first.versions] == ["path"]
    assert math.dist(first.versions[0][1][0][:2], CANYON["start"][:2]) < 1
    jobs.tell(job, AHEAD)
    until(lambda: changes(job) and changes(job)[-1]["active_ms"] is not None)
    (zones,) = [each.zones for each in job.seen[1:] if each.zones is not None]
    assert [zone["name"] for zone in zones] == ["pop-up 1"]
    (path,) = [each.path for each in job.seen if each.path]
    assert path["name"] == "ga-chip"
    assert changes(job)[-1]["active_ms"] < 100
    # A zone over the goal; then all are gone, and the goal is another.
    jobs.tell(job, Zone.circle(4700, 4600, 200))
    until(lambda: len(changes(job)) == 2)
    jobs.tell(job, CLEAR)
    until(lambda: "a zone is gone" in said(job))
    assert [each.zones for each in job.seen if each.zones is not None][-1] == []
    jobs.tell(job, CLEAR)
    until(lambda: "No zone has appeared." in said(job))
    jobs.tell(job, Goal(4200.0, 4600.0))
    until(lambda: [each for each in job.seen[1:] if each.points])
    jobs.tell(job, Goal(99_000.0, 0.0))
    until(lambda: re.search("goal.*map|map.*goal", said(job)))
    jobs.tell(job, Speed(FASTEST))
    until(lambda: job.done)
    assert (job.state, job.error) == ("saved", None)
    assert job.outcome["ended"] == "arrived"
    flight = parse_json((folder / "flight.json").read_text())
    assert flight["ended"] == "arrived"
    assert len(flight["changes"]) == len(changes(job))
    assert {"flight.json", "flight.png", "flight.gif"} <= set(files_of(folder))
    times = [each.time_s for each in job.seen]
    assert times == sorted(times)
    x, y = job.seen[-1].aircraft["x"], job.seen[-1].aircraft["y"]
    assert math.hypot(x - 4200, y - 4600) < 60


def test_time_stands_still_and_a_flight_that_is_ended_leaves_nothing(planned, take_off):
    jobs, folder = planned
    before = set(folder.iterdir())
    job = take_off("astar", "")
    jobs.tell(job, Speed(0.0))
    count = len(job.seen)
    until(lambda: len(job.seen) > count + 10)
    still = {each.time_s for each in job.seen[-5:]}
    assert len(still) == 1
    jobs.stop(job)
    until(lambda: job.done)
    assert job.error == "The flight was ended, and is not saved."
    assert set(folder.iterdir()) == before


def test_flights_wait_for_no_plan_and_are_limited(planned, take_off):
    jobs, _ = planned
    plan = jobs.submit({**CANYON, "planner": "ga-pc", "generations": 10_000_000}, "long")
    flights = [take_off("astar", "") for _ in range(4)]
    with pytest.raises(InputError, match="4 flights go on"):
        take_off("astar", "")
    assert plan.state == "planning"
    for job in (plan, *flights):
        jobs.stop(job)
    until(lambda: all(job.done for job in (plan, *flights)))
    assert plan.state == "saved"


def test_what_cannot_be_flown_is_said(planned):
    jobs, folder = planned
    job = FlightJob(folder.parent / "none", planner="astar", board="")
    jobs.fly(job)
    until(lambda: job.done)
    assert "none" in job.error
