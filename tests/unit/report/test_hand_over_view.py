"""The end of a mission and its rally points on a plan view."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from pathgene.host.formats.flight_plan import Circling
from pathgene.host.report.hand_over_view import draw
from pathgene.host.report.handed_over import HandedOver
from pathgene.host.report.picture import Scene
from pathgene.host.report.picture import draw as draw_picture


NOTHING = np.empty((0, 3))
# The way leads off the map.
WAY = np.array([(3000.0, 3000.0, 300.0), (90_000.0, 3000.0, 400.0)])
CIRCLE = Circling(3500.0, 3000.0, 400.0, 150.0, 300.0)
MISSION = HandedOver(WAY, WAY, WAY, NOTHING, (CIRCLE,), np.array([(500.0, 500.0, 300.0)]))


@pytest.fixture
def axes():
    axes = Figure().add_subplot()
    axes.set(xlim=(0, 4), ylim=(0, 4))
    return axes


def test_circles_way_and_rally_points_are_drawn_to_scale(axes):
    labels = [handle.get_label() for handle in draw(axes, MISSION, 1000.0)]
    assert labels == ["end of the mission", "rally point"]
    rings = [each for each in axes.get_children() if isinstance(each, Circle)]
    assert [(ring.center, ring.radius) for ring in rings] == [((3.5, 3), 0.15), ((3.5, 3), 0.3)]
    way, rally = (np.array(line.get_xydata()) for line in axes.lines)
    assert way == pytest.approx(WAY[:, :2] / 1000)
    assert rally == pytest.approx(np.array([(0.5, 0.5)]))
    assert (axes.get_xlim(), axes.get_ylim()) == ((0, 4), (0, 4))


def test_a_mission_that_ends_at_its_goal_has_no_lines(axes):
    assert draw(axes, HandedOver(WAY, WAY, WAY[:1], NOTHING, (), NOTHING), 1000.0) == []
    assert not axes.lines


def test_the_picture_of_a_run_shows_its_mission(make_run):
    evaluator, result = make_run(shape=(61, 61))
    made = (evaluator, result.path, result.evaluation, result.history, "t", "s")
    for mission, entries in ((None, 0), (MISSION, 1)):
        figure = draw_picture(Scene(*made, mission=mission))
        labels = [text.get_text() for text in figure.legends[0].get_texts()]
        assert labels.count("end of the mission") == labels.count("rally point") == entries
