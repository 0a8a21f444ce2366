"""Uploads that fail at every step: the autopilot holds its earlier mission and fence again."""

import os
import re
import signal
import threading

import pytest

from pathgene.host import interrupts
from pathgene.host.errors import JobError
from pathgene.host.mission.autopilot.mavlink_link import Link
from pathgene.host.mission.autopilot.upload import upload
from tests.unit.mission.autopilot.own_autopilot import CANCELLED, DENIED, ERROR, connect, uploaded


FIELDS = (
    "command",
    "frame",
    "x",
    "y",
    "param1",
    "param2",
    "param3",
    "mission_type",
)


class Height(float):
    """An altitude that equals another one within a centimetre.

    ArduPilot's arithmetic takes a centimetre of some heights that are read and written back.
    """

    def __eq__(self, other):
        return abs(self - other) <= 0.0101

    __hash__ = float.__hash__


def content(own):
    """Return both lists of an autopilot, without the parameter that may be NaN."""
    return {
        kind: [(*(getattr(item, field) for field in FIELDS), Height(item.z)) for item in items]
        for kind, items in own.lists.items()
    }


@pytest.fixture(scope="module")
def pair(plans):
    """Return two plans, each with a fence of a polygon; the second mission is the shorter one."""
    fenced = [plan for plan in plans if any(hasattr(zone, "corners") for zone in plan.fence)]
    fenced.sort(key=lambda plan: len(plan.items))
    first = next(plan for plan in fenced if len(plan.items) > 7)
    return next(plan for plan in fenced if len(plan.items) > len(first.items)), first


#: Values of ``kind``.
KINDS = {"ardupilot": 3, "px4": 12}


@pytest.fixture(params=KINDS)
def loaded(request, own, pair):
    """Return an autopilot that holds the first plan."""
    own.kind = KINDS[request.param]
    uploaded(own, pair[0])
    return own


class Break:
    """A fault at the n-th message of a type and kind, for as many messages as told.

    A lost message is lost at each repetition, until the ground station acknowledges the end.
    """

    def __init__(self, message_type, kind, number, effect, times=1):
        self.place, self.effect = (message_type, kind), effect
        self.first, self.last = number, number + times - 1
        self.seen = 0
        self.is_past = False

    def __call__(self, message):
        place = (message.get_type(), getattr(message, "mission_type", None))
        if place != self.place:
            self.is_past |= self.seen >= self.first and place[0] == "MISSION_ACK"
            return None
        self.seen += 1
        if self.effect == "lost":
            return "lost" if self.seen >= self.first and not self.is_past else None
        if not self.first <= self.seen <= self.last:
            return None
        return self.effect() if callable(self.effect) else self.effect


def failure(own, plan):
    with pytest.raises(JobError) as refusal:
        uploaded(own, plan)
    sentence = str(refusal.value)
    assert sentence.endswith(".")
    assert sentence.count(". ") == 0
    return sentence


def restored(own):
    mission, fence, rally = (len(own.lists[kind]) for kind in (0, 1, 2))
    return (
        f"the autopilot now holds its earlier mission ({mission} items), its earlier fence "
        f"({fence} items), and its earlier rally list ({rally} items); upload again."
    )


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (("MISSION_COUNT", 1, 1, 4), "refuses item 0 of 9 of the fence (no space)"),
        (("MISSION_ITEM_INT", 1, 2, ERROR), "refuses item 2 of 9 of the fence (error)"),
        (("MISSION_COUNT", 0, 1, 4), "refuses item 0 of 9 of the mission (no space)"),
        (("MISSION_ITEM_INT", 0, 1, 5), "refuses item 1 of 9 of the mission (invalid)"),
        (("MISSION_ITEM_INT", 0, 3, 5), "refuses item 3 of 9 of the mission (invalid)"),
        (("MISSION_ITEM_INT", 0, 4, DENIED), "refuses item 4 of 9 of the mission (denied)"),
        (("MISSION_ITEM_INT", 0, 2, 0), "accepts the mission after 2 of its 9 items"),
        (("MISSION_COUNT", 0, 1, "lost"), "fell silent at item 0 of 9 of the mission"),
        (("MISSION_ITEM_INT", 1, 1, "lost"), "fell silent at item 1 of 9 of the fence"),
        (("MISSION_ITEM_INT", 0, 3, "lost"), "fell silent at item 3 of 9 of the mission"),
        (
            ("MISSION_REQUEST_INT", 0, "half", "lost"),
            "took the mission, but it does not give its list (0 of 9 items)",
        ),
    ],
    ids=lambda value: " ".join(map(str, value)) if isinstance(value, tuple) else "",
)
def test_restores_mission_and_fence_after_a_failure_at_any_step(loaded, pair, step, reason):
    before = content(loaded)
    message_type, kind, number, *rest = step
    if "lost" in rest:
        loaded.follow(retry_s=100.0, timeout_s=100.0)  # Or its own messages would arrive.
    if number == "half":  # After the reading that precedes an upload.
        number = len(before[kind]) + 1
    loaded.breaks = Break(message_type, kind, number, *rest)
    sentence = failure(loaded, pair[1])
    assert content(loaded) == before
    said, _, held = sentence.partition("; ")
    assert re.sub(r"of \d+", "of 9", re.sub(r"its \d+", "its 9", said)) == f"The autopilot {reason}"
    assert held == restored(loaded)


def test_restores_both_lists_if_the_mission_comes_back_altered(loaded, pair):
    before = content(loaded)
    wrong = threading.Event()

    def alter(item):
        # Only the new mission is shorter.
        if item.mission_type == 0 and item.seq == 1 and len(loaded.lists[0]) < len(before[0]):
            item.x += 1
            wrong.set()

    loaded.alter = alter
    sentence = failure(loaded, pair[1])
    assert wrong.is_set()
    assert content(loaded) == before
    said, _, held = sentence.partition("; ")
    assert re.match(r"The autopilot gives back item 1 of the mission with another place \(", said)
    assert held == restored(loaded)


def test_a_refused_last_item_of_ardupilot_leaves_the_earlier_mission(own, pair):
    """The items before it have replaced the earlier ones in their places."""
    own.kind = 3
    uploaded(own, pair[0])
    before = content(own)
    last = len(pair[1].items) + 1
    own.breaks = Break("MISSION_ITEM_INT", 0, last, 9)
    sentence = failure(own, pair[1])
    assert sentence.startswith(
        f"The autopilot refuses item {last} of {last} of the mission (invalid param4); "
    )
    assert content(own) == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("step", [("MISSION_ITEM_INT", 1, 1), ("MISSION_ITEM_INT", 0, 3)])
def test_restores_them_after_an_interruption(loaded, pair, step, number):
    before = content(loaded)
    loaded.breaks = Break(*step, lambda: os.kill(os.getpid(), number))
    with interrupts.caught():
        sentence = failure(loaded, pair[1])
    assert content(loaded) == before
    assert sentence == f"The upload is interrupted; {restored(loaded)}"


def test_restores_them_after_the_connection_broke_for_a_moment(own, pair, monkeypatch):
    own.kind = 3  # It shortens its list immediately.
    uploaded(own, pair[0])
    before = content(own)
    asked, broken = Link.ask, []

    def ask(link, send, kinds, *rest):
        if "MISSION_REQUEST_INT" in kinds and len(own.lists[0]) < len(before[0]) and not broken:
            broken.append(True)
            raise ConnectionResetError(104, "Connection reset by peer")
        return asked(link, send, kinds, *rest)

    monkeypatch.setattr(Link, "ask", ask)
    sentence = failure(own, pair[1])
    assert broken
    assert content(own) == before
    assert sentence == (
        f"The connection to the autopilot broke (Connection reset by peer); {restored(own)}"
    )


def test_a_lost_confirmation_is_no_failure(loaded, pair):
    """ArduPilot answers the repeated last item with an error, because it expects no item."""
    lost = []

    def loses(result, kind):
        is_first = result == 0 and kind == 0 and not lost
        if is_first:
            lost.append(kind)
        return is_first

    loaded.loses = loses
    done = uploaded(loaded, pair[1])
    assert lost == [0]
    assert len(loaded.lists[0]) == done.mission_items


def test_lost_confirmations_of_all_kinds_are_no_failure(loaded, pair):
    loaded.loses = lambda result, kind: kind == 0
    done = uploaded(loaded, pair[1])
    assert len(loaded.lists[0]) == done.mission_items


def test_begins_again_if_the_autopilot_gave_up(loaded, pair):
    loaded.breaks = Break("MISSION_ITEM_INT", 0, 3, CANCELLED)
    done = uploaded(loaded, pair[1])
    assert len(loaded.lists[0]) == done.mission_items
    loaded.breaks = lambda message: (
        CANCELLED if message.get_type() == "MISSION_ITEM_INT" and message.seq == 2 else None
    )
    assert "refuses item 3 of" in failure(loaded, pair[1])


def test_a_late_answer_to_the_failed_upload_does_not_spoil_the_restoring(own, pair):
    own.kind = 3
    uploaded(own, pair[0])
    before = content(own)
    first = Break("MISSION_ITEM_INT", 0, 3, 5)
    again = Break("MISSION_ITEM_INT", 0, 5, ERROR)
    own.breaks = lambda message: first(message) or again(message)
    failure(own, pair[1])
    assert again.seen > 5
    assert content(own) == before


@pytest.mark.parametrize("delay_s", [0.0, 0.02, 0.2])
def test_a_slow_ardupilot_gets_its_mission_and_its_earlier_one(own, pair, delay_s):
    """It asks twice for an item, rejects the second one, and asks after the interruption."""
    own.kind = 3
    own.asks_twice_after_s = delay_s
    uploaded(own, pair[0])
    before = content(own)
    own.breaks = Break("MISSION_ITEM_INT", 0, 3, 5)
    sentence = failure(own, pair[1])
    assert content(own) == before
    assert sentence.endswith(restored(own))


def refuse_items(message):
    """Refuse the third and all later items of any mission."""
    is_item = message.get_type() == "MISSION_ITEM_INT" and message.mission_type == 0
    return 5 if is_item and message.seq >= 2 else None


def test_clears_on_the_ground_what_cannot_be_restored(loaded, pair):
    before = content(loaded)
    loaded.breaks = refuse_items
    sentence = failure(loaded, pair[1])
    assert content(loaded) == before | {0: []}
    assert sentence.endswith(
        "; the autopilot now holds no mission, because the earlier one could not be restored, its "
        f"earlier fence ({len(before[1])} items), and its earlier rally list ({len(before[2])} "
        "items); upload again."
    )


def test_home_of_ardupilot_may_stay_when_its_mission_is_cleared(own, pair):
    own.kind = KINDS["ardupilot"]
    own.keeps_home = True
    uploaded(own, pair[0])
    own.breaks = refuse_items
    sentence = failure(own, pair[1])
    assert len(own.lists[0]) == 1
    assert "; the autopilot now holds no mission, because the earlier one could not" in sentence


def test_clears_nothing_of_an_aircraft_with_running_motors(loaded, pair):
    loaded.armed = True
    cleared = []

    def breaks(message):
        if message.get_type() == "MISSION_CLEAR_ALL":
            cleared.append(message.mission_type)
        return refuse_items(message)

    loaded.breaks = breaks
    sentence = failure(loaded, pair[1])
    # A plan without rally points clears the earlier ones.
    assert set(cleared) <= {2}
    assert loaded.lists[0]
    assert sentence.endswith(
        "; the autopilot now holds an unknown mission, perhaps parts of the old and the new one, "
        f"its earlier fence ({len(loaded.lists[1])} items), and its earlier rally list "
        f"({len(loaded.lists[2])} items); do not start the mission before an upload succeeds."
    )


def test_says_so_if_the_autopilot_refuses_to_clear_too(own, pair):
    own.kind = 3
    uploaded(own, pair[0])
    own.runs = True
    own.breaks = refuse_items
    assert "holds an unknown mission" in failure(own, pair[1])
    assert own.lists[0]


def test_an_autopilot_that_held_nothing_holds_nothing(own, pair):
    own.breaks = Break("MISSION_ITEM_INT", 0, 3, 5)
    sentence = failure(own, pair[1])
    assert content(own) == {0: [], 1: [], 2: []}
    assert sentence.endswith(
        "; the autopilot now holds its earlier mission (0 items), its earlier fence (0 items), and "
        "its earlier rally list (0 items); upload again."
    )


def test_a_dead_link_is_said_and_not_waited_for_twice(loaded, pair):
    sent = Break("MISSION_ITEM_INT", 0, 3, "lost")
    dead = threading.Event()

    def breaks(message):
        if sent(message):
            dead.set()
        return "lost" if dead.is_set() else None

    loaded.breaks = breaks
    loaded.follow(retry_s=100.0)  # A dead link carries no requests either.
    sentence = failure(loaded, pair[1])
    fence, rally = len(loaded.lists[1]), len(loaded.lists[2])
    assert sentence.endswith(
        "; the autopilot held, when it last answered, an unknown mission, perhaps parts of the "
        f"old and the new one, the new fence ({fence} items), and the new rally list ({rally} "
        "items); do not fly before an upload succeeds."
    )
    # The tries of the upload, and none if restoring begins with a count.
    assert sent.seen == 3 - 1 + 5


@pytest.mark.parametrize("kind", [0, 1])
def test_changes_nothing_if_the_earlier_list_cannot_be_read(loaded, pair, kind):
    before = content(loaded)
    name = ("mission", "fence")[kind]
    loaded.breaks = Break("MISSION_REQUEST_INT", kind, 1, "lost")
    assert failure(loaded, pair[1]) == (
        f"The autopilot holds a {name} that could not be restored, because it does not give its "
        f"list (0 of {len(before[kind])} items); nothing is uploaded, check the link or clear the "
        f"{name} there, and upload again."
    )
    loaded.breaks = Break("MISSION_REQUEST_INT", kind, 1, ERROR)
    assert f"because it does not give item 0 of {len(before[kind])} (error); " in failure(
        loaded, pair[1]
    )
    loaded.breaks = Break("MISSION_REQUEST_LIST", kind, 1, ERROR)
    assert "because it does not give its list (error); " in failure(loaded, pair[1])
    assert content(loaded) == before


def test_changes_nothing_if_the_autopilot_never_says_how_long_its_list_is(own, pair):
    own.breaks = Break("MISSION_REQUEST_LIST", 1, 1, "lost", 10_000)
    assert failure(own, pair[1]).startswith(
        "The autopilot holds a fence that could not be restored, because it does not give its list "
        "(0 of ? items); nothing is uploaded, "
    )
    assert own.breaks.seen == 5
    assert own.lists == {0: [], 1: [], 2: []}


def test_waits_for_the_end_of_an_upload_that_somebody_broke_off(own, pair):
    own.kind = 3
    own.follow(timeout_s=1.7)
    link = connect(own)
    link.mav.mission_count_send(link.system, link.component, 5, 1)
    link.close()
    assert uploaded(own, pair[1]).mission_items == len(own.lists[0])


def test_what_is_restored_keeps_the_place_of_the_flight(own, pair):
    """PX4 goes to the item that is marked as current."""
    own.kind = 12
    uploaded(own, pair[0])
    own.current = 2
    own.breaks = Break("MISSION_ITEM_INT", 0, 4, 5)
    failure(own, pair[1])
    assert own.current == 2
    assert [own.arrived[0, seq].current for seq in range(4)] == [0, 0, 1, 0]


def test_an_interrupted_restoring_is_said(own, pair, monkeypatch):
    uploaded(own, pair[0])
    monkeypatch.setattr(interrupts, "_REPEAT_S", 0.0)
    own.breaks = Break("MISSION_ITEM_INT", 0, 2, lambda: os.kill(os.getpid(), signal.SIGINT), 10)
    with interrupts.caught():
        sentence = failure(own, pair[1])
    assert sentence.startswith("The upload is interrupted; the autopilot held, when it last answ")


def test_upload_is_whole_after_all_of_these(loaded, pair):
    link = connect(loaded)
    assert upload(pair[1], link).mission_items == len(loaded.lists[0])
    link.close()
