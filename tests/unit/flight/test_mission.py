"""Exported missions, flown by the laws of an autopilot in JSBSim, from plan to verdict."""

import itertools
import json
import math
import re
import sys

import numpy as np
import pytest

from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.flight import fly as flights
from pathgene.host.flight import picture
from pathgene.host.flight.flight import Flight
from pathgene.host.flight.fly import draw, fly, write
from pathgene.host.flight.mission import _Carried
from pathgene.host.flight.models import MODELS
from pathgene.host.mission.autopilot.hand_over import HandOver
from pathgene.host.mission.ending import Ending
from pathgene.host.planners.base import Stop
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


Y, X = np.mgrid[:41, :61]
PATH = np.array([(1000, 1000, 330), (1900, 1600, 350), (3000, 1800, 330)], dtype=float)
HILLS = Terrain("hills", 150 + 20 * np.sin(X / 9) * np.cos(Y / 7), 100, 100)


def problem(**options):
    return Problem(at_origin(HILLS, 46.1, 7.6), PATH[0], PATH[-1], **options)


@pytest.fixture(scope="module")
def flown():
    """Return a flight by ArduPlane's laws, in wind."""
    return fly(problem(wind=(3.0, 2.0)), PATH, guidance="ardupilot")


def test_a_mission_with_room_is_kept(flown):
    verdict = flown.verdict
    assert (verdict.breaks, verdict.kept, verdict.arrived) == ([], True, True)
    assert (flown.guidance, flown.title, flown.notes) == ("ardupilot", "ArduPlane", [])
    # An autopilot cuts corners and is late in climbs, so it strays further than the ideal guidance.
    assert 1.0 < verdict.cross_track_max_m < 25.0


def test_the_flight_continues_on_the_circle_at_the_end(flown):
    track, end = flown.flown, np.isnan(flown.flown.cross_m)
    assert (track.t_s[-1] - flown.verdict.flight_time_s) == pytest.approx(120, abs=25)
    assert (track.along_m[end] == track.along_m[-1]).all()
    away = np.hypot(track.x - PATH[-1, 0], track.y - PATH[-1, 1])[-30 * 60 :]
    radius = flown.problem.aircraft.turn_radius_m
    assert radius < away.min() < away.max() < 2 * radius


def test_a_mission_without_room_at_its_end_is_refused():
    y, _ = np.mgrid[:41, :121]
    canyon = Terrain("canyon", np.where(abs(y - 20) <= 4, 150.0, 900.0), 25, 25)
    path = np.array([(200, 500, 300), (2500, 500, 300)], dtype=float)
    narrow = Problem(at_origin(canyon, 46.1, 7.6), path[0], path[-1])
    with pytest.raises(JobError, match=r"^The mission cannot end with a circle of \d+ m around"):
        fly(narrow, path, guidance="ardupilot")


def test_a_climb_that_is_exported_too_late_is_refused():
    rise = Terrain("rise", 150 + 0.17 * 100 * np.clip(X - 10, 0, 20), 100, 100)
    path = np.array([(1000, 2000, 200), (3000, 2000, 540), (4500, 2000, 540)], dtype=float)
    steep = Problem(at_origin(rise, 46.1, 7.6), path[0], path[-1], wind=(0.0, 5.0))
    with pytest.raises(
        JobError, match=r"^An autopilot that climbs late flies .* start \d+ m higher"
    ):
        fly(steep, path, guidance="ardupilot")


@pytest.mark.ci
def test_the_circle_at_the_end_is_judged(monkeypatch):
    """A plan that is altered after its check ends in a hill; the path itself is kept."""
    made = flights.flight_plan

    def lower(*arguments, **options):
        plan = made(*arguments, **options)
        object.__setattr__(plan.items[-1], "alt_m", 120.0)
        return plan

    monkeypatch.setattr(flights, "flight_plan", lower)
    ideal, real = (fly(problem(), PATH, guidance=name).verdict for name in ("ideal", "ardupilot"))
    assert ideal.kept
    assert real.arrived
    assert "under the ground" in real.breaks[0]


@pytest.mark.ci
@pytest.mark.parametrize(
    ("ending", "last"),
    [
        (Ending("land", (3000.0, 900.0, 240.0)), (3000.0, 900.0)),
        (Ending("rtl"), tuple(PATH[0, :2])),
    ],
    ids=["land", "rtl"],
)
def test_landings_and_returns_are_flown(ending, last):
    report = fly(problem(), PATH, guidance="ardupilot", wanted=HandOver(ending=ending))
    assert report.verdict.arrived
    flown = report.flown
    near = math.dist((flown.x[-1], flown.y[-1]), last)
    # A landing is recorded up to its glide, a return to its circle and two minutes of it.
    assert near < 1200
    if ending.kind == "rtl":
        way_s = math.dist(PATH[0], PATH[-1]) / 25
        assert flown.t_s[-1] - report.verdict.flight_time_s > way_s + 100
    if ending.kind == "land":
        assert report.verdict.kept
        assert 150 < flown.z[-1] < 300


@pytest.mark.ci
def test_px4_is_told_not_to_ask_for_a_landing():
    report = fly(problem(), PATH, guidance="px4")
    assert report.verdict.arrived
    (note,) = report.notes
    assert "Landing waypoint/pattern required" in note
    assert note.endswith("flown with MIS_TKO_LAND_REQ 0.")


@pytest.mark.ci
def test_px4_gets_the_tolerance_of_heights_that_an_upload_advises():
    path = PATH + np.array([(0, 0, 0), (0, 0, 120), (0, 0, 120)])
    steep = Problem(at_origin(HILLS, 46.1, 7.6), path[0], path[-1])
    report = fly(steep, path, guidance="px4")
    assert re.match(r"NAV_FW_ALT_RAD is \d+, as pathgene upload --set-", report.notes[0])
    assert report.verdict.kept
    # Without that tolerance it circles at waypoints, far beside the track.
    assert report.verdict.cross_track_max_m < 30


@pytest.mark.ci
def test_the_file_names_the_guidance_and_the_picture_the_autopilot(flown, tmp_path):
    write(flown, tmp_path)
    content = json.loads((tmp_path / "flight.json").read_text())
    assert (content["guidance"], content["items"]) == ("ardupilot", flown.items)
    assert content["track"]["cross_m"][-1] is None
    assert draw(flown, tmp_path)[0].exists()
    assert picture._titles(flown)[0].endswith(", with ArduPlane's laws")


def test_pitch_counts_from_its_trim():
    model, figures = MODELS["silver-fox"], aircraft.load("silver-fox")
    track = Evaluator(problem(), threads=1).track(PATH)
    flight = Flight(track.pieces, problem().terrain, figures, model)
    craft = _Carried(flight, model, math.radians(4.0))
    assert craft.state.pitch_rad == flight.state.pitch_rad - math.radians(4.0)
    for _ in range(30):
        craft.step(0.0, math.radians(2.0), 0.4)
    assert math.degrees(flight.state.pitch_rad) == pytest.approx(6.0, abs=1.2)
    assert math.degrees(craft.state.pitch_rad) == pytest.approx(2.0, abs=1.2)
    assert len(craft.samples) == 90


def test_a_refusal_of_the_autopilot_is_a_sentence(monkeypatch):
    made = flights.flight_plan

    def far(*arguments, **options):
        plan = made(*arguments, **options)
        object.__setattr__(plan.items[0], "lat", 95.0)
        return plan

    monkeypatch.setattr(flights, "flight_plan", far)
    with pytest.raises(JobError, match=r"\(invalid param5 x\)"):
        fly(problem(), PATH, guidance="ardupilot")


def test_bad_guidance_is_one_sentence(monkeypatch):
    with pytest.raises(InputError, match=r"^There is no guidance 'inav'; choose from ideal, ardu"):
        fly(problem(), PATH, guidance="inav")
    nowhere = Problem(Terrain("hills", np.zeros(X.shape), 100, 100), PATH[0], PATH[-1])
    with pytest.raises(InputError, match="place on Earth"):
        fly(nowhere, PATH, guidance="ardupilot")


def test_a_missing_extra_is_one_sentence(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("pathgene.sim.autopilot")]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if name.startswith("pymavlink.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pymavlink", None)
    message = (
        r"^--guidance ardupilot needs the extra pathgene\[mavlink\]: "
        r"pip install 'pathgene\[mavlink\]'\.$"
    )
    with pytest.raises(InputError, match=message):
        fly(problem(), PATH, guidance="ardupilot")


@pytest.mark.ci
def test_an_interrupted_flight_is_judged_so_far():
    asked = itertools.count()
    stop = Stop(lambda: next(asked) > 1300)
    report = fly(problem(), PATH, guidance="ardupilot", stop=stop)
    assert report.verdict.breaks == ["The flight was interrupted before it reached the goal."]
    with pytest.raises(KeyboardInterrupt):
        fly(problem(), PATH, guidance="ardupilot", stop=Stop(lambda: True))
