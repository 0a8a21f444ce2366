"""Picture, animation and file of a flight with replans."""

import json
import re

import numpy as np
import pytest
from PIL import Image

from pathgene.host.replanning import animation, picture
from pathgene.host.replanning.fly import fly_scenario, save
from pathgene.host.replanning.planner import HOST_S
from pathgene.host.replanning.scenario import Event, NewZone, Placed, Scenario
from pathgene.host.report.style import FLOWN, NOFLY


@pytest.fixture(scope="module")
def report(mission, straight):
    """A flight with a zone ahead, and one over the aircraft."""
    scenario = Scenario(
        (
            Event(30.0, (NewZone(Placed("path", 250.0, 1500.0)),)),
            Event(90.0, (NewZone(Placed("aircraft", 150.0)),)),
        )
    )
    return fly_scenario(
        mission,
        straight,
        scenario,
        planner="ga-chip",
        board="model:?core=planner",
        seconds=HOST_S,
    )


def dots(image, colour):
    """Return how many dots of an image are near a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    return int((np.abs(np.asarray(image, dtype=int)[..., :3] - wanted).max(axis=2) < 12).sum())


def test_all_files_are_written_and_tell_the_flight(report, tmp_path):
    (tmp_path / "flight.gif").write_bytes(b"of an earlier flight")
    written = save(report, tmp_path)
    assert [file.name for file in written] == ["flight.json", "flight.png", "flight.gif"]
    table = json.loads(written[0].read_text())
    assert (table["kept"], table["ended"], table["planner"]) == (True, "arrived", "ga-chip")
    assert table["board"] == "model:?core=planner"
    first, second = table["changes"]
    attempt = first["attempts"][0]
    assert attempt["total_ms"] == pytest.approx(
        attempt["chip_ms"] + attempt["round_trips_ms"] + attempt["host_ms"]
    )
    assert second["inside_m"] == pytest.approx(150, abs=1)
    assert len(table["track"]["x"]) == len(table["track"]["t_s"])
    assert [leg["kind"] for leg in table["legs"]].count("way-out") == 1
    drawn = Image.open(written[1])
    assert dots(drawn, NOFLY) > 200
    with Image.open(written[2]) as moving:
        assert moving.n_frames > 60
        assert written[2].stat().st_size < 4_000_000


def test_the_picture_has_all_versions_of_the_path(report):
    figure = picture.draw(report)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[-3:] == ["later paths", "circle, way out", "flown"]
    assert "first path" in labels
    title, subtitle = picture.titles(report)
    assert "replanned in flight by ga-chip" in title
    assert "2 changes, new paths after" in subtitle
    # A version begins where the aircraft took it.
    points = picture.version_points(report, 1)
    assert np.hypot(points[0, 0] - (1500 + 23 * 30), points[0, 1] - 4500) < 40


def test_a_zone_is_there_from_when_it_appears(report):
    images, durations = animation.frames(report)
    assert len(images) == len(durations) > 60
    assert sum(durations) < 20_000
    early, late = images[5], images[-1]
    assert dots(late, NOFLY) > dots(early, NOFLY) + 50
    assert dots(late, FLOWN) > dots(early, FLOWN)
    # A new path is shown with the parts of its time.
    said = [words for _, _, words in animation._times(report) if words.startswith("New path")]
    pattern = (
        r"New path after ([\d.]+) ms: [\d.]+ m flown\.\nchip and line ([\d.]+) ms, counted; "
        r"round trips ([\d.]+) ms and host (\d+) ms, assumed"
    )
    assert len(said) == 2
    for words in said:
        whole, *parts = map(float, re.fullmatch(pattern, words).groups())
        assert whole == pytest.approx(sum(parts), abs=1)
    # Each change, and each new path, is shown for longer.
    assert sum(duration > 1000 for duration in durations) == 4
