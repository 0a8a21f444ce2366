"""Uploads to MAVSDK's autopilot over UDP, and to our own autopilot that misbehaves."""

import contextlib
import itertools
import math
import os
import pty
import time
import tty
from dataclasses import replace

import pytest

from pathgene.host.errors import InputError, JobError
from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError, open_link
from pathgene.host.mission.autopilot.upload import upload
from tests.support.host.earth import single
from tests.unit.mission.autopilot.mavsdk_autopilot import Autopilot, Proxy
from tests.unit.mission.autopilot.own_autopilot import connect, uploaded


@pytest.fixture(scope="module")
def autopilot():
    server = Autopilot()
    yield server
    server.close()


def until(condition):
    """Wait until MAVSDK's callback has run."""
    end = time.monotonic() + 10
    while not condition() and time.monotonic() < end:
        time.sleep(0.002)
    assert condition()


def lists_of(plan):
    """Return how many lists a plan fills."""
    return 1 + bool(plan.fence) + bool(plan.rally)


def assert_has(items, plan):
    """Assert that a list of MAVSDK's autopilot is the mission of a plan."""
    assert [item.seq for item in items] == list(range(len(plan.items)))
    for item, wanted in zip(items, plan.items, strict=True):
        assert (item.command, item.frame, item.mission_type) == (wanted.command, 0, 0)
        assert (item.x, item.y) == (round(wanted.lat * 1e7), round(wanted.lon * 1e7))
        assert item.z == single(wanted.alt_m)
        params = tuple(single(param) for param in wanted.params[:3])
        assert (item.param1, item.param2, item.param3) == params
        # Items other than waypoints have a number where ArduPilot requires one.
        assert math.isnan(item.param4) if item.command == 16 else item.param4 == 0


def test_mavsdk_takes_missions_with_their_fences(plans, autopilot):
    link = connect(autopilot.address, system=1)
    for plan in plans:
        autopilot.received.clear()
        done = upload(plan, link)
        until(lambda plan=plan: len(autopilot.received) >= lists_of(plan))
        *fence, mission = (items for items in autopilot.received if items[0].mission_type != 2)
        rally = [items for items in autopilot.received if items[0].mission_type == 2]
        assert_has(mission, plan)
        assert [[(item.command, item.frame, item.z) for item in items] for items in rally] == (
            [[(5100, 3, height) for _, _, height in plan.rally]] if plan.rally else []
        )
        assert done.rally_points == len(plan.rally)
        assert done.mission_items == len(plan.items)
        corners = sum(len(getattr(piece, "corners", [0])) for piece in plan.fence)
        assert done.fence_items == corners
        assert [len(items) for items in fence] == ([corners] if corners else [])
        assert {item.command for items in fence for item in items} <= {5002, 5004}
    link.close()


@pytest.mark.ci
@pytest.mark.parametrize(
    "most", [4, *(pytest.param(most, marks=pytest.mark.ci) for most in (9, 22)), 15]
)
def test_a_broken_connection_is_one_sentence_and_the_next_upload_succeeds(plans, autopilot, most):
    plan = max(plans, key=lambda plan: len(plan.items))
    left = itertools.count(1)
    proxy = Proxy(autopilot.port, lambda _: next(left) >= most)
    link = connect(proxy.address, answer_s=0.1, system=1)
    with pytest.raises(
        JobError,
        match=r"^The autopilot (fell silent at|took the|holds a) .* (succeeds|again)\.$",
    ):
        upload(plan, link)
    link.close()
    proxy.close()

    autopilot.received.clear()
    link = connect(autopilot.address, answer_s=1.5, system=1)  # As on the command line.
    assert upload(plan, link).mission_items == len(plan.items)
    link.close()
    until(lambda: len(autopilot.received) >= lists_of(plan))
    assert_has(autopilot.received[-1], plan)


def test_nobody_there(autopilot):
    link = open_link("udpout:127.0.0.1:9")
    with pytest.raises(NoReplyError):
        link.find(0.2)
    link.close()


def test_ardupilot_gets_home_as_item_0(own, plans):
    own.kind = 3
    done = uploaded(own, plans[2])
    assert (done.autopilot_name, done.mission_items) == ("ardupilot", len(plans[2].items) + 1)
    home = own.arrived[0, 0]
    assert (home.x, home.y) == tuple(round(1e7 * value) for value in plans[2].home[:2])
    assert home.z == single(plans[2].home[2])


def test_the_kind_of_the_autopilot_can_be_given(own, plans):
    done = uploaded(own, plans[2], autopilot=3)
    assert done.mission_items == len(plans[2].items) + 1


def test_survives_lost_messages_and_old_requests(own, plans):
    own.drops = 4  # Every fourth.
    own.follow(asks_for_integers=False)
    plan = min(plans, key=lambda plan: len(plan.items))
    assert uploaded(own, plan).mission_items == len(plan.items)


def test_px4_says_the_same_in_other_words(own, plans):
    """Frames 5 and 0 mean the same, and 0 is a heading left to the autopilot."""
    own.kind = 12

    def alter(item):
        if item.mission_type == 0:
            item.frame, item.param4 = 5, 0.0

    own.alter = alter
    assert uploaded(own, plans[0]).autopilot_name == "px4"


def test_ardupilot_keeps_whole_centimetres(own, plans):
    own.kind = 3
    uploaded(own, plans[0])
    kept = [item.z for item in own.lists[0][1:]]
    assert kept != [single(item.alt_m) for item in plans[0].items]
    assert kept == pytest.approx([round(z, 2) for z in kept], abs=1e-3)


@pytest.mark.parametrize(
    ("field", "change", "what"),
    [
        ("x", 1, "place"),
        ("y", -1, "place"),
        ("z", 0.5, "altitude"),
        ("command", 1, "command"),
        ("frame", 3, "frame"),
        ("param2", 1, "parameter 2"),
    ],
)
def test_refuses_whatever_differs(own, plans, field, change, what):
    def alter(item):
        if item.mission_type == 0 and item.seq == 1:
            setattr(item, field, getattr(item, field) + change)

    own.alter = alter
    with pytest.raises(
        JobError,
        match=rf"^The autopilot gives back item 1 of the mission with "
        rf"another {what} \(.*\); the autopilot now holds its earlier mission \(0 items\), its .*; "
        r"upload again\.$",
    ):
        uploaded(own, plans[0])


def test_ardupilot_takes_missions(own, plans):
    """ArduPilot accepts NaN only in a few places; elsewhere it refuses the whole mission for it."""
    own.kind = 3
    for plan in plans:
        uploaded(own, plan)
        assert [item.command for item in own.lists[0]] == [
            16,
            *(item.command for item in plan.items),
        ]


def test_an_older_plan_file_reaches_ardupilot_without_its_nan(own, plans):
    """A loiter in a file of version 0.2 or of a ground station has null in its fourth parameter."""
    own.kind = 3
    *items, loiter = plans[0].items
    older = replace(loiter, params=(None, 0.0, 60.0, None))
    plan = replace(plans[0], items=(*items, older))
    uploaded(own, plan)
    last = own.arrived[0, len(items) + 1]
    assert last.param1 == last.param4 == 0
    assert math.isnan(own.arrived[0, 1].param4)
    own.kind = 12
    uploaded(own, plan)
    assert math.isnan(own.lists[0][-1].param4)


def test_refuses_a_fence_that_differs(own, plans):
    plan = next(plan for plan in plans if plan.fence)
    own.alter = lambda item: setattr(item, "param1", item.param1 + (item.mission_type == 1))
    with pytest.raises(JobError, match=r"^The autopilot gives back item 0 of the fence with ano"):
        uploaded(own, plan)


def test_refuses_a_shorter_list(own, plans):
    own.keeps = 3
    count = len(plans[0].items)
    with pytest.raises(JobError) as refusal:
        uploaded(own, replace(plans[0], rally=()))
    assert str(refusal.value).startswith(
        f"The autopilot gives back 3 items of the mission, not {count}; the autopilot now holds "
    )


def test_the_size_of_the_other_list_is_no_answer(own, plans):
    plan = next(plan for plan in plans if plan.fence)
    own.mixes_lists = True
    done = uploaded(own, plan)
    assert (done.mission_items, done.fence_items) == (len(own.lists[0]), len(own.lists[1]))
    assert len(own.lists[0]) != len(own.lists[1])


@pytest.mark.parametrize(
    ("number", "sentence"),
    [
        (99, "The autopilot asks for item 99 of the mission, which has {} items"),
        (0, "The autopilot repeats its requests for the same items of the mission"),
    ],
)
def test_refuses_requests_that_lead_nowhere(own, plans, number, sentence):
    plan = replace(next(plan for plan in plans if not plan.fence), rally=())
    own.asks_for = lambda _number: number
    own.follow(timeout_s=1e6)  # It never gives up.
    with pytest.raises(JobError) as refusal:
        uploaded(own, plan)
    said = str(refusal.value).partition("; ")[0]
    assert said == sentence.format(len(plan.items))
    assert own.lists == {0: [], 1: [], 2: []}


def test_a_late_request_of_a_longer_list_is_no_failure(own, plans):
    late = [99]
    own.asks_for = lambda number: late.pop() if late else number
    assert uploaded(own, plans[0]).mission_items == len(own.lists[0])
    assert not late


def test_clears_the_fence_of_an_earlier_mission(own, plans):
    fenced = next(plan for plan in plans if plan.fence)
    bare = next(plan for plan in plans if not plan.fence)
    uploaded(own, fenced)
    assert own.lists[1]
    uploaded(own, bare)
    assert own.lists[1] == []


def test_an_autopilot_without_fences_takes_a_mission_without(own, plans):
    own.has_fences = False
    uploaded(own, next(plan for plan in plans if not plan.fence))
    with pytest.raises(JobError, match=r"^The autopilot refuses item 0 of .* fence \(unsup"):
        uploaded(own, next(plan for plan in plans if plan.fence))


@pytest.mark.parametrize(
    ("address", "sentence"),
    [
        (
            "udpout:localhost",
            "The address must be udpout:HOST:PORT, not 'udpout:localhost' (--to).",
        ),
        ("tcp::5760", "The address must be tcp:HOST:PORT, not 'tcp::5760' (--to)."),
        ("udpout:localhost:0", "The address must be udpout:HOST:PORT, not"),
        (f"tcp:localhost:{'9' * 5000}", "The address must be tcp:HOST:PORT, not"),
        (f"tcp:{'x' * 64}.de:9", f"There is no host '{'x' * 64}.de'; check the address (--to)."),
        ("udpin:127.0.0.1:70000", "The address must be udpin:HOST:PORT, not"),
        ("udpout:no.such.host.invalid:14550", "There is no host 'no.such.host.invalid'; check"),
        (
            "flight.tlog",
            "There is no autopilot at 'flight.tlog': give udpout:HOST:PORT, udpin:HOST:PORT, "
            "tcp:HOST:PORT or a serial device (--to).",
        ),
    ],
)
def test_refuses_other_addresses(address, sentence):
    with pytest.raises(InputError) as refusal:
        open_link(address)
    assert str(refusal.value).startswith(sentence)


def test_a_speed_that_no_port_knows_is_a_sentence():
    ends = pty.openpty()
    try:
        with pytest.raises(JobError, match=r"^Cannot open /dev/pts/\d+ \(.*\); check the address"):
            open_link(os.ttyname(ends[1]), baud=10**10)
    finally:
        for end in ends:
            os.close(end)


def test_says_what_cannot_be_opened(own):
    with pytest.raises(JobError, match=r"^Cannot open tcp:127.0.0.1:9 \(.*\); check the address"):
        open_link("tcp:127.0.0.1:9")
    assert isinstance(open_link(own.address), Link)


def test_a_serial_port_that_takes_nothing_costs_a_second(capfd):
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    os.set_blocking(theirs, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(theirs, bytes(256))
    link = open_link(os.ttyname(theirs))
    try:
        begun = time.monotonic()
        with pytest.raises(NoReplyError):
            link.find(0.5)
        assert time.monotonic() - begun < 5
        assert capfd.readouterr().out == ""
    finally:
        # This makes room for the bytes that a close would wait for.
        os.set_blocking(ours, False)
        os.read(ours, 1 << 16)
        link.close()
        os.close(ours)
        os.close(theirs)
