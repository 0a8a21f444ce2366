"""Uploads to the simulated autopilot, in virtual time."""

import contextlib

import pytest

from pathgene.host.errors import JobError
from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError
from pathgene.host.mission.autopilot.upload import upload
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.link import Faults
from pathgene.sim.autopilot.pilot import Kind, Mode


def connected(plan, kind, faults=None, seed=0):
    """Return a link to an autopilot that stands at the home of a plan."""
    autopilot = Autopilot(kind, Start(plan.home, armed=False))
    connection = Connection(autopilot, faults, faults, seed=seed)
    link = Link(connection, clock=connection.clock)
    link.find(10.0)
    return link, connection


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_every_mission_is_taken_and_read_back_equal(plans, kind):
    fits = 84 if kind is Kind.ARDUPLANE else 64
    for plan in plans[:25]:
        if sum(len(getattr(fence, "corners", [0])) for fence in plan.fence) > fits:
            continue
        link, connection = connected(plan, kind)
        done = upload(plan, link)
        assert done.mission_items == len(connection.autopilot.lists.items[0])
        assert done.fence_items == len(connection.autopilot.lists.items[1])


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
@pytest.mark.parametrize("delay_s", [0.1, 0.6, 2.0])
def test_a_slow_link_carries_the_upload(plans, kind, delay_s):
    plan = min(plans, key=lambda plan: len(plan.items))
    link, connection = connected(plan, kind, Faults(delay_s=delay_s))
    assert upload(plan, link).mission_items == len(connection.autopilot.lists.items[0])


@pytest.mark.parametrize(("loses", "seconds"), [(False, 7.5), (True, 15.0)])
def test_a_step_that_is_never_answered_ends_while_heartbeats_arrive(plans, loses, seconds):
    link, connection = connected(plans[0], Kind.ARDUPLANE)
    if loses:
        connection.down.drops = lambda _message: True
        connection.wait(3.0)
        connection.down.drops = lambda _message: False
        link.find(3.0)
    connection.up.drops = lambda message: message.get_type() == "MISSION_REQUEST_LIST"
    begun_s = connection.now_s
    with pytest.raises(JobError, match="nothing is uploaded"):
        upload(plans[0], link)
    assert connection.now_s - begun_s == pytest.approx(seconds, abs=0.2)


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
@pytest.mark.parametrize(("delay_s", "loss"), [(0.1, 0.2), (0.6, 0.1)])
def test_a_link_that_loses_messages_carries_the_upload(plans, kind, delay_s, loss):
    plan = min(plans, key=lambda plan: len(plan.items))
    for seed in range(4):
        link, connection = connected(plan, kind, Faults(delay_s, 0.1 * delay_s, loss), seed)
        assert upload(plan, link).mission_items == len(connection.autopilot.lists.items[0])


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_a_slow_link_that_loses_a_fifth_leaves_a_whole_mission(plans, kind):
    """The autopilots themselves give up after 5 and 8 s without an item."""
    plan = min(plans, key=lambda plan: len(plan.items))
    uploads = 0
    for seed in range(6):
        link, connection = connected(plan, kind, Faults(2.0, 0.2, 0.2), seed)
        with contextlib.suppress(JobError):
            uploads += upload(plan, link).mission_items > 0
        # The new mission or, as before, none.
        expected = len(plan.items) + (kind is Kind.ARDUPLANE)
        assert len(connection.autopilot.lists.items[0]) in (0, expected)
    assert uploads >= 3


def test_a_session_is_repeatable(plans):
    def session(seed):
        link, connection = connected(plans[0], Kind.ARDUPLANE, Faults(0.2, 0.3, 0.1), seed)
        try:
            upload(plans[0], link)
        except JobError as error:
            return connection.now_s, str(error)
        return connection.now_s, "uploaded"

    assert session(3) == session(3)
    assert len({session(seed)[0] for seed in range(4)}) > 1


def test_the_uploaded_mission_is_flown(plans):
    plan = plans[0]
    link, connection = connected(plan, Kind.ARDUPLANE)
    upload(plan, link)
    autopilot = connection.autopilot
    autopilot.armed = True
    link.mav.command_long_send(1, 1, 300, 0, *[0.0] * 7)
    connection.wait(5)
    assert autopilot.pilot.mode is Mode.AUTO


def places(items):
    """Return the places of a list without ArduPilot's home."""
    return [(item.command, item.x, item.y) for item in items]


@pytest.mark.ci
@pytest.mark.parametrize("loss", [0.0, 0.1])
@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_the_sentence_after_a_link_died_is_true(plans, kind, loss):
    """The link dies at a random moment, in both directions at once."""
    old, new = sorted((plan for plan in plans if plan.fence), key=lambda plan: len(plan.items))[:2]
    said = set()
    for seed in range(60):
        link, connection = connected(old, kind)
        upload(old, link)
        autopilot = connection.autopilot
        held = {
            mission_type: places(autopilot.lists.items[mission_type]) for mission_type in (0, 1)
        }
        dies_s = autopilot.time_s + 0.2 + 0.4 * seed
        faulty = Connection(
            autopilot, *(Faults(0.05, 0.02, loss, dies_s=dies_s) for _ in range(2)), seed=seed
        )
        link = Link(faulty, clock=faulty.clock)
        try:
            link.find(3.0)
            upload(new, link)
        except NoReplyError:
            outcome = "nothing is uploaded"
        except JobError as error:
            outcome = str(error)
        else:
            outcome = "uploaded"
        for mission_type, name in ((0, "mission"), (1, "fence")):
            now = places(autopilot.lists.items[mission_type])
            if "nothing is uploaded" in outcome or f"its earlier {name} (" in outcome:
                assert now == held[mission_type]
                said.add("earlier")
            elif f"no {name}, because" in outcome:
                assert now == []
            elif outcome == "uploaded":
                assert now != held[mission_type]
                said.add("new")
            else:
                assert f"an unknown {name}" in outcome
                said.add("unknown")
    assert said >= {"earlier", "unknown"}
    assert loss or "new" in said  # With losses, the link dies before the end.
