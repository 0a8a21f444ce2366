"""Choices of a user about a flight plan."""

import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.autopilot.hand_over import HandOver


@pytest.mark.parametrize(
    ("choice", "sentence"),
    [
        (
            {"fence_corners": 2},
            "The corners of fences must be 3 to 65,535, not 2 (--fence-corners).",
        ),
        (
            {"simplify_m": 101.0},
            "The tolerance of the legs must be 0 to 100 m, not 101 (--simplify).",
        ),
        (
            {"simplify_m": float("nan")},
            "The tolerance of the legs must be 0 to 100 m, not nan (--simplify).",
        ),
    ],
)
def test_refuses_a_choice_out_of_range(choice, sentence):
    with pytest.raises(InputError) as error:
        HandOver(**choice)
    assert str(error.value) == sentence
