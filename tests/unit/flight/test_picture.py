"""The picture of a flight."""

import numpy as np
import pytest

from host.flight.fly import fly
from host.flight.picture import draw
from host.problem import Problem
from host.terrain import Terrain


PATH = np.array([(1000, 1000, 150), (2500, 1600, 170), (3500, 1500, 150)], dtype=float)


@pytest.mark.parametrize("as_paper", [False, True])
@pytest.mark.parametrize("shape", [(41, 51), (41, 300), (300, 41)])
def test_shows_planned_and_flown(as_paper, shape):
    terrain = Terrain("land", np.full(shape, 20.0), 100, 100)
    report = fly(Problem(terrain, PATH[0], PATH[-1], as_paper=as_paper), PATH)
    figure = draw(report)
    plan, _, profile, errors = figure.axes
    labels = {line.get_label(): line for line in profile.lines}
    assert {"planned", "flown", "surface"} <= set(labels)
    assert ("half the clearance" in labels) != as_paper
    assert labels["flown"].get_ydata() == pytest.approx(report.flown.z)
    assert [line.get_label() for line in errors.lines[1:]] == ["to the left", "up"]
    flown_km = plan.lines[-1].get_xdata()
    assert len(flown_km) == len(report.flown.x)
    texts = [text.get_text() for text in figure.texts]
    assert texts[0] == "Flown by Silver Fox-like in calm air"
    assert "Everything kept." in texts[1]
