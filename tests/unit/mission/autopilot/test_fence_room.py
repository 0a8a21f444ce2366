"""Fences that an autopilot has no room for."""

import dataclasses

import pytest

from pathgene.host.errors import JobError
from pathgene.host.formats.flight_plan import FenceCircle, FencePolygon
from pathgene.host.mission.autopilot.fence_room import fence_notes, no_room
from tests.unit.mission.autopilot.own_autopilot import uploaded


ARDUPILOT, PX4 = 3, 12


def polygon(corners):
    """Return a zigzag of corners far away from the mission."""
    return FencePolygon(
        tuple((40.0 + 1e-3 * (number % 2), 7.0 + 1e-4 * number) for number in range(corners))
    )


CIRCLE = FenceCircle(40.0, 7.0, 100.0)
#: Fences that just fit, and fences that are a little too large.
FITS = {
    ARDUPILOT: [
        (polygon(83),),
        (polygon(40), polygon(42)),
        (CIRCLE,) * 51,
        (polygon(80), CIRCLE),
    ],
    PX4: [(polygon(64),), (polygon(63), CIRCLE)],
}
TOO_LARGE = {
    ARDUPILOT: [(polygon(84),), (polygon(42), polygon(42)), (CIRCLE,) * 52, (polygon(82), CIRCLE)],
    PX4: [(polygon(65),), (polygon(64), CIRCLE)],
}


def rows(fences):
    return [(kind, fence) for kind, several in fences.items() for fence in several]


@pytest.mark.parametrize(("kind", "fence"), rows(FITS))
def test_the_simulated_autopilot_takes_a_fence_that_fits(own, plans, kind, fence):
    own.kind = kind
    assert no_room(fence, kind) is None
    uploaded(own, dataclasses.replace(plans[0], fence=fence))
    assert len(own.lists[1]) == sum(len(getattr(each, "corners", [0])) for each in fence)


@pytest.mark.parametrize(("kind", "fence"), rows(TOO_LARGE))
def test_a_larger_fence_is_refused_before_anything_is_sent(own, plans, kind, fence):
    own.kind = kind
    own.follow(timeout_s=8.0)
    uploaded(own, plans[0])
    before = own.lists
    with pytest.raises(JobError, match="nothing is uploaded"):
        uploaded(own, dataclasses.replace(plans[0], fence=fence))
    assert own.lists == before


@pytest.mark.parametrize(("kind", "fence"), rows(TOO_LARGE))
def test_the_simulated_autopilot_refuses_what_is_said_not_to_fit(
    own, plans, kind, fence, monkeypatch
):
    monkeypatch.setattr("pathgene.host.mission.autopilot.upload.no_room", lambda *_: None)
    own.kind = kind
    with pytest.raises(JobError, match="The autopilot refuses"):
        uploaded(own, dataclasses.replace(plans[0], fence=fence))


def test_export_says_which_autopilots_have_no_room():
    assert fence_notes((polygon(64),)) == ()
    (note,) = fence_notes((polygon(70),))
    assert note == (
        "The fence has 70 corners of polygons and 0 circles, but PX4 keeps 64 corners and "
        "circles in all; leave out zones that the path does not reach, or give them fewer corners."
    )
    assert len(fence_notes((polygon(90),))) == 2
    assert fence_notes((polygon(70),), ARDUPILOT) == ()
    assert no_room((polygon(2000),), 0) is None


def test_a_user_may_name_the_room_of_another_board():
    assert no_room((polygon(200),), ARDUPILOT, 200) is None
    assert no_room((polygon(84),), ARDUPILOT, 84) is not None
    assert no_room((polygon(200),), PX4, 199) == (
        "The fence has 200 corners of polygons and 0 circles, more than --fence-corners 199 has "
        "room for; leave out zones that the path does not reach, or give them fewer corners."
    )
