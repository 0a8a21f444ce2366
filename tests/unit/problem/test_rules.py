"""Rules of safe flight: ranges, and their place in a problem."""

import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem.rules import Rules


def test_defaults():
    assert Rules().to_dict() == {
        "clearance_m": 30.0,
        "corridor_m": 25.0,
        "ceiling_m": None,
        "ceiling_agl_m": None,
        "zone_margin_m": 25.0,
        "reserve": 0.1,
    }


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"clearance_m": -1}, "clearance must be 0 m or more, not -1 m"),
        ({"corridor_m": float("nan")}, "corridor must be a finite number"),
        ({"zone_margin_m": "wide"}, "zone margin must be a number"),
        ({"ceiling_agl_m": 30}, "above the clearance of 30 m, not 30 m"),
        ({"reserve": 1}, "from 0 to below 100 %, not 100 %"),
    ],
)
def test_out_of_range(values, sentence):
    with pytest.raises(InputError, match=sentence):
        Rules(**values)
