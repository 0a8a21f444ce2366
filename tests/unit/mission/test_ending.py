"""The end of a mission, as a user states it and as a summary keeps it."""

import re
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.ending import LOITER, Ending, ending_of, summary_ending, with_end
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain


GROUND = Terrain("plain", np.zeros((2, 2)), 1000.0, 1000.0, "EPSG:32632", (5e5, 5e6))
FORT = Circle(700.0, 600.0, 50.0, name="Fort")
HIGH = Circle(300.0, 600.0, 50.0, lower_m=80.0)
PLAIN = Problem(GROUND, (100.0, 100.0, 50.0), (900.0, 100.0, 50.0), zones=(FORT, HIGH))
LATITUDE, LONGITUDE = GROUND.to_geographic(300.0, 400.0)


@pytest.mark.parametrize(
    ("values", "ending"),
    [
        ({}, None),
        ({"end": "loiter"}, LOITER),
        ({"end": "rtl"}, Ending("rtl")),
        ({"land": (300.0, 400.0, -90.0)}, Ending("land", (300.0, 400.0, 270.0))),
        ({"end": "land", "land": [300.0, 400.0, 360.0]}, Ending("land", (300.0, 400.0, 0.0))),
    ],
)
def test_a_summary_keeps_the_end(values, ending):
    made = ending_of(values, PLAIN)
    assert made == ending
    assert summary_ending(Path("summary.json"), with_end({}, made)) == (ending or LOITER)


def test_a_landing_has_its_place_on_earth_or_on_the_map():
    kind, land = "land", (300.0, 400.0, 45.0)
    made = ending_of({"land_geo": (LATITUDE, LONGITUDE, 45.0)}, PLAIN)
    assert made.kind == kind
    assert made.land == pytest.approx(land, abs=1e-6)


def test_refuses_numbers_that_are_none():
    with pytest.raises(InputError, match="The landing must be 3 finite numbers"):
        ending_of({"land": (1.0, 2.0, float("nan"))}, PLAIN)


def test_refuses_a_landing_in_a_zone_and_allows_one_below_a_zone():
    sentence = (
        r"^The landing at \(740, 610\) is inside the no-fly zone Fort; give another place "
        r"\(--land\)\.$"
    )
    with pytest.raises(InputError, match=sentence):
        ending_of({"land": (740.0, 610.0, 90.0)}, PLAIN)
    assert ending_of({"land": (300.0, 610.0, 90.0)}, PLAIN).kind == "land"


def test_refuses_headings_beyond_a_turn():
    sentence = (
        r"The heading of the landing must be from -360 to 360 degrees from north, not 1e\+308"
    )
    with pytest.raises(InputError, match=sentence):
        ending_of({"land": (1.0, 2.0, 1e308)}, PLAIN)


@pytest.mark.parametrize(("x", "shown"), [(-5.0, "-5"), (1000.5, "1000.5"), (1e308, "1e+308")])
def test_refuses_a_landing_off_the_map(x, shown):
    sentence = f"The landing at ({shown}, 2) is outside the map, which reaches to (1000, 1000);"
    with pytest.raises(InputError, match=re.escape(sentence)):
        ending_of({"land": (x, 2.0, 90.0)}, PLAIN)
