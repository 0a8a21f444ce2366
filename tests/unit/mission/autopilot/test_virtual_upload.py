"""Uploads to the simulated autopilot, in virtual time."""

import contextlib
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import common as mavlink

from pathgene.host.errors import JobError
from pathgene.host.mission.autopilot.flight_state import start_refusal
from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError
from pathgene.host.mission.autopilot.upload import upload
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.link import Faults
from pathgene.sim.autopilot.pilot import Kind, Mode
from pathgene.sim.autopilot.rules import PX4_RULES


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


class Station:
    """A second ground station, whose messages appear on the link of the first one.

    ``says`` returns the messages of the autopilot to that station, after each message of ours.
    """

    def __init__(self, autopilot, says):
        self.autopilot, self.says = autopilot, says
        self.system, self.component = autopilot.system, autopilot.component

    @property
    def time_s(self):
        return self.autopilot.time_s

    def handle(self, message, now_s):
        answers = self.autopilot.handle(message, now_s)
        return [*self.says(message), *answers]

    def advance(self, now_s):
        return self.autopilot.advance(now_s)


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_answers_to_another_ground_station_are_ignored(plans, kind):
    """Another station reads a list of 3 items, and its upload is refused."""

    def says(message):
        kind = getattr(message, "mission_type", None)
        if kind is None:
            return []
        return [
            mavlink.MAVLink_mission_ack_message(254, 190, result, mission_type=kind)
            for result in (0, 4)
        ] + [
            mavlink.MAVLink_mission_count_message(255, 1, 3, mission_type=kind),
            mavlink.MAVLink_mission_request_int_message(254, 190, 9, mission_type=kind),
        ]

    autopilot = Autopilot(kind, Start(plans[0].home, armed=False))
    connection = Connection(Station(autopilot, says))
    link = Link(connection, clock=connection.clock)
    link.find(10.0)
    done = upload(plans[0], link)
    assert done.mission_items == len(autopilot.lists.items[0])


def test_a_count_beyond_all_autopilots_is_refused_at_once(plans):
    def says(message):
        if message.get_type() != "MISSION_REQUEST_LIST":
            return []
        made = mavlink.MAVLink_mission_count_message
        return [made(255, 190, 65_535, mission_type=message.mission_type)]

    connection = Connection(Station(Autopilot(Kind.PX4, Start(plans[0].home, armed=False)), says))
    link = Link(connection, clock=connection.clock)
    link.find(10.0)
    begun_s = connection.now_s
    with pytest.raises(JobError, match="because it states 65535 items, more than any autopilot"):
        upload(plans[0], link)
    assert connection.now_s - begun_s < 1


def test_two_systems_are_named_and_one_of_them_is_chosen(plans):
    first, second = (
        Autopilot(Kind.PX4, Start(plans[0].home, armed=False), system=system) for system in (9, 4)
    )
    connection = Connection(first, beside=[second])
    link = Link(connection, clock=connection.clock)
    with pytest.raises(JobError, match=r"^Autopilots of systems 4 and 9 answer; choose one with -"):
        link.find(10.0)
    assert connection.now_s < 4
    with pytest.raises(NoReplyError) as silence:
        link.find(3.0, 7)
    assert silence.value.systems == (4, 9)
    link.find(10.0, 4)
    assert upload(plans[0], link).system == 4
    assert second.lists.items[0]
    assert not first.lists.items[0]


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_a_mission_that_was_left_in_its_middle_does_not_continue_there(plans, kind):
    old, new = plans[0], plans[1]
    link, connection = connected(old, kind)
    upload(old, link)
    connection.autopilot.set_current(4)
    done = upload(new, link)
    first = 1 if kind is Kind.ARDUPLANE else 0
    assert done.mission.item == connection.autopilot.pilot.sequencer.resumes == first


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_a_mission_under_way_is_not_changed(plans, kind):
    link, connection = connected(plans[0], kind)
    autopilot = connection.autopilot
    autopilot.parameters |= {"MIS_TKO_LAND_REQ": 0.0}
    upload(plans[0], link)
    before = {kind: list(items) for kind, items in autopilot.lists.items.items()}
    autopilot.armed = True
    link.mav.command_long_send(1, 1, 300, 0, *[0.0] * 7)
    connection.wait(0.5)
    assert autopilot.pilot.mode is Mode.AUTO
    link.find(3.0)
    with pytest.raises(JobError, match=r"^The aircraft flies its mission, and .* another mode\.$"):
        upload(plans[1], link)
    assert autopilot.lists.items == before
    # Circling, it takes one.
    link.mav.set_mode_send(1, 1, 12 if kind is Kind.ARDUPLANE else 4 << 16 | 3 << 24)
    connection.wait(2.0)
    link.find(3.0)
    assert upload(plans[1], link).mission_items == len(autopilot.lists.items[0])


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_a_mission_that_begins_during_the_upload_stays_as_it_is(plans, kind):
    link, connection = connected(plans[0], kind, Faults(delay_s=0.4))
    autopilot = connection.autopilot
    autopilot.parameters |= {"MIS_TKO_LAND_REQ": 0.0}
    upload(plans[0], link)
    before = {kind: places(items) for kind, items in autopilot.lists.items.items()}

    def begins(message):
        if message.get_type() == "MISSION_COUNT" and message.mission_type == 2:
            autopilot.armed = True
            autopilot.fly_mission()
        return False

    connection.up.drops = begins
    with pytest.raises(JobError, match=r"^The aircraft has begun its mission during the upload; "):
        upload(plans[1], link)
    assert {kind: places(items) for kind, items in autopilot.lists.items.items()} == before


def test_texts_of_the_autopilot_are_kept_in_full(plans):
    link, connection = connected(plans[0], Kind.PX4)
    long = "Mission rejected: " + "the approach must be above the landing point, " * 3
    connection.autopilot.say("Old")
    connection.wait(0.2)
    done = upload(plans[0], link)
    connection.autopilot.say(long)
    connection.autopilot.say("Short")
    link.settle()
    texts = link.texts.all
    assert texts[-2:] == [long.strip(), "Short"]
    assert "Old" not in texts
    assert start_refusal(done.mission, texts).startswith(
        "The autopilot holds the mission, but will"
    )
    assert start_refusal(replace(done.mission, will_start=True), texts) is None


@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_rally_points_replace_earlier_ones(plans, kind):
    link, connection = connected(plans[0], kind)
    upload(plans[0], link)
    held = connection.autopilot.lists.items[2]
    assert [(item.x, item.y, item.z) for item in held] == [
        (round(lat * 1e7), round(lon * 1e7), height) for lat, lon, height in plans[0].rally
    ]
    assert len(held) > 0
    done = upload(replace(plans[1], rally=()), link)
    assert (done.rally_points, connection.autopilot.lists.items[2]) == (0, [])


def test_another_autocontinue_is_no_equal_mission(plans):
    link, connection = connected(plans[0], Kind.PX4)
    kept = PX4_RULES.kept

    class Rules(type(PX4_RULES)):
        def kept(self, item, kind):
            stays = kind == 0 and item.x == round(plans[0].items[-1].lat * 1e7)
            return replace(kept(item, kind), autocontinue=0 if stays else item.autocontinue)

    connection.autopilot.lists.rules = Rules(**vars(PX4_RULES))
    with pytest.raises(JobError, match=r"with another autocontinue \(0, not 1\); "):
        upload(plans[0], link)


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
            elif outcome == "uploaded" or f"the new {name} (" in outcome:
                assert now != held[mission_type]
                said.add("new")
            else:
                assert f"an unknown {name}" in outcome
                said.add("unknown")
    assert said >= {"earlier", "unknown"}
    assert loss or "new" in said  # With losses, the link dies before the end.
