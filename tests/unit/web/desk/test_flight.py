"""Flights in processes of the desk: their pictures, orders and files."""

import math
import re
import shutil
import time

import pytest

from pathgene.host.errors import InputError
from pathgene.host.inputs import parse_json
from pathgene.host.problem.zones import Zone
from pathgene.host.web.desk.flight import AHEAD, CLEAR, FASTEST, Goal, Speed
from pathgene.host.web.desk.job import FlightJob
from pathgene.host.web.desk.jobs import Jobs
from pathgene.host.web.desk.saving import files_of


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
        until(lambda: job.latest or job.done)
        assert job.error is None
        return job

    return start


def said(job):
    return " ".join(job.said)


def news(job, name):
    return job.news.get(name, (0, []))[1]


def test_what_is_ordered_happens(planned, take_off):
    jobs, folder = planned
    job = take_off()
    assert news(job, "zones") == []
    assert [point["kind"] for point in news(job, "points")] == ["start", "goal"]
    assert [kind for kind, _ in job.versions] == ["path"]
    assert math.dist(job.versions[0][1][0][:2], CANYON["start"][:2]) < 1
    assert "path" not in job.news
    jobs.tell(job, AHEAD)
    until(lambda: "path" in job.news)
    assert [zone["name"] for zone in news(job, "zones")] == ["pop-up 1"]
    assert news(job, "path")["name"] == "ga-chip"
    (change,) = news(job, "changes")
    assert change["active_ms"] < 100
    assert len(job.versions) == 2
    # A zone over the goal; then all zones are removed, and the goal is changed.
    jobs.tell(job, Zone.circle(4700, 4600, 200))
    until(lambda: len(news(job, "zones")) == 2)
    jobs.tell(job, CLEAR)
    until(lambda: "zones pop-up 1 and pop-up 2 are gone" in said(job))
    assert news(job, "zones") == []
    jobs.tell(job, CLEAR)
    until(lambda: "No zone has appeared." in said(job))
    jobs.tell(job, Goal(4200.0, 4600.0))
    until(lambda: news(job, "points")[1]["x"] == 4200.0)
    jobs.tell(job, Goal(99_000.0, 0.0))
    until(lambda: re.search("goal.*map|map.*goal", said(job)))
    jobs.tell(job, Speed(FASTEST))
    until(lambda: job.done)
    assert (job.state, job.error) == ("saved", None)
    assert job.outcome["ended"] == "arrived"
    flight = parse_json((folder / "flight.json").read_text())
    assert flight["ended"] == "arrived"
    assert len(flight["changes"]) == len(news(job, "changes"))
    assert {"flight.json", "flight.png", "flight.gif"} <= set(files_of(folder))
    x, y = job.latest.aircraft["x"], job.latest.aircraft["y"]
    assert math.hypot(x - 4200, y - 4600) < 60
    assert len(job.trail) == pytest.approx(3 * job.latest.time_s, rel=0.02)


def test_things_happen_in_their_order_while_time_stands_still(planned, take_off):
    jobs, folder = planned
    before = set(folder.iterdir())
    job = take_off("astar", "")
    jobs.tell(job, Speed(0.0))
    time.sleep(0.5)
    still_s = job.latest.time_s
    for order in (Zone.circle(4000, 1000, 50), CLEAR, CLEAR, Goal(4500, 4600), Goal(4400, 4600)):
        jobs.tell(job, order)
    until(lambda: len(news(job, "changes")) == 4)
    assert "No zone has appeared." in said(job)
    assert news(job, "points")[1]["x"] == 4400.0
    assert job.latest.time_s - still_s < 0.5
    jobs.stop(job)
    until(lambda: job.done)
    assert job.error == "The flight was ended, and is not saved."
    assert set(folder.iterdir()) == before


def test_a_flight_is_as_fast_as_it_is_told(take_off, planned):
    jobs, _ = planned
    job = take_off("astar", "")
    jobs.tell(job, Speed(2.0))
    time.sleep(0.5)
    began_s, flown_s = time.monotonic(), job.latest.time_s
    time.sleep(3)
    flown_s, real_s = job.latest.time_s - flown_s, time.monotonic() - began_s
    jobs.stop(job)
    until(lambda: job.done)
    # A busy machine is slower.
    assert 0.5 * real_s < flown_s < 2.1 * real_s + 0.2


def test_flights_wait_for_no_plan_and_are_limited(planned, tmp_path):
    jobs, folder = planned
    plan = jobs.submit({**CANYON, "planner": "ga-pc", "generations": 10_000_000}, "long")
    flights = []
    for number in range(4):
        shutil.copytree(folder, tmp_path / str(number))
        flights.append(FlightJob(tmp_path / str(number), planner="astar", board=""))
        jobs.fly(flights[-1])
    with pytest.raises(InputError, match="4 flights are in progress"):
        jobs.fly(FlightJob(folder, planner="astar", board=""))
    with pytest.raises(InputError, match="flown already"):
        jobs.fly(FlightJob(tmp_path / "1", planner="astar", board=""))
    until(lambda: all(job.latest for job in flights))
    assert plan.state == "planning"
    for job in (plan, *flights):
        jobs.stop(job)
    until(lambda: all(job.done for job in (plan, *flights)))
    assert plan.state == "saved"


def test_what_cannot_be_flown_or_saved_is_said(planned, take_off, tmp_path):
    jobs, folder = planned
    job = FlightJob(tmp_path / "none", planner="astar", board="")
    jobs.fly(job)
    until(lambda: job.done)
    assert "none" in job.error
    shutil.copytree(folder, tmp_path / "gone")
    job = FlightJob(tmp_path / "gone", planner="astar", board="")
    jobs.fly(job)
    until(lambda: job.latest)
    shutil.rmtree(tmp_path / "gone")
    (tmp_path / "gone").write_text("A file in its place.")
    jobs.tell(job, Speed(FASTEST))
    until(lambda: job.done)
    assert job.outcome["ended"] == "arrived"
    assert job.error.startswith("The flight is not saved: ")
    assert "Internal" not in job.error
