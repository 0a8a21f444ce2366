"""The picture of a flight."""

import numpy as np
import pytest
from matplotlib.offsetbox import AnchoredOffsetbox
from matplotlib.patches import FancyArrow
from matplotlib.text import Text

from pathgene.host.flight.fly import fly
from pathgene.host.flight.picture import draw
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from tests.support.host.pictures import assert_texts_apart


PATH = np.array([(1000, 1000, 150), (2500, 1600, 170), (3500, 1500, 150)], dtype=float)


@pytest.mark.parametrize("as_paper", [False, True])
@pytest.mark.parametrize("shape", [(41, 51), (41, 300), (300, 41)])
def test_shows_planned_and_flown(as_paper, shape):
    terrain = Terrain("land", np.full(shape, 20.0), 100, 100)
    report = fly(Problem(terrain, PATH[0], PATH[-1], as_paper=as_paper), PATH)
    figure = draw(report)
    figure.canvas.draw()
    plan, _, profile, errors = figure.axes
    labels = {line.get_label(): line for line in profile.lines}
    assert {"planned", "flown"} <= set(labels)
    assert ({"clearance", "half of it"} <= set(labels)) != as_paper
    if not as_paper:
        assert labels["clearance"].get_ydata() == pytest.approx(20 + 30)
        assert labels["half of it"].get_ydata() == pytest.approx(20 + 15)
    assert labels["flown"].get_ydata() == pytest.approx(report.flown.z)
    named = [line.get_label() for line in errors.lines if line.get_label()[0] != "_"]
    assert named == ["to the left", "up", *([] if as_paper else ["corridor, sideways"])]
    assert_texts_apart(figure)
    flown_km = plan.lines[-1].get_xdata()
    assert len(flown_km) == len(report.flown.x)
    texts = [text.get_text() for text in figure.texts]
    assert texts[0] == "Flown by Silver Fox-like in calm air"
    assert "Everything kept." in texts[1]


def wind_of(figure):
    """Return the directions of the arrows next to the scale, and the text of the wind."""
    (box,) = figure.axes[0].findobj(AnchoredOffsetbox)
    directions = []
    for arrow in box.findobj(FancyArrow):
        corners = arrow.get_xy()
        # An arrow's outline begins at its tip.
        east, north = corners[0] - corners.mean(axis=0)
        directions.append(np.degrees(np.arctan2(north, east)))
    said = [text.get_text() for text in box.findobj(Text) if "wind" in text.get_text()]
    return directions, said


def test_the_arrow_is_that_of_the_wind_flown():
    terrain = Terrain("land", np.full((41, 51), 20.0), 100, 100)
    for planned, flown, direction, said in (
        ((0.0, 0.0), (4.0, 0.0), 0, "wind 4 m/s"),
        ((4.0, 0.0), (0.0, -3.0), -90, "wind 3 m/s"),
    ):
        problem = Problem(terrain, PATH[0], PATH[-1], wind=planned)
        north, arrow = (found := wind_of(draw(fly(problem, PATH, wind=flown))))[0]
        assert north == pytest.approx(90)
        assert arrow == pytest.approx(direction, abs=1e-6)
        assert found[1] == [said]
    calm = draw(fly(Problem(terrain, PATH[0], PATH[-1], wind=(4.0, 0.0)), PATH, wind=(0.0, 0.0)))
    assert wind_of(calm) == ([pytest.approx(90)], [])
