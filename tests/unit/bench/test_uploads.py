"""Uploads with faults: the campaign in small, and the judge of its sentences."""

import numpy as np
import pytest

from bench import uploads
from pathgene.host.mission.autopilot import upload
from pathgene.sim.autopilot.pilot import Kind


def verdicts(seeds):
    return [uploads.session(seed) for seed in seeds]


def seeds_of(fault, count):
    """Yield seeds of sessions with a fault, which is drawn second."""
    names, shares = list(uploads.FAULTS), list(uploads.FAULTS.values())
    for seed in range(2000):
        rng = np.random.default_rng(seed)
        rng.integers(2)
        if count and rng.choice(names, p=shares) == fault:
            count -= 1
            yield seed


def assert_none_is_violated(sessions):
    assert [each for each in sessions if each.verdict == "violated"] == []
    # Only a dead link excuses a list of which nothing is known.
    unknown = {each.fault for each in sessions if each.verdict.startswith("unknown")}
    assert unknown <= {"link dead for a while", "link dead for good"}
    calm = [each.verdict == "uploaded" for each in sessions if each.fault == "none"]
    # A slow link that loses messages can exceed the patience of an autopilot.
    assert sum(calm) >= 0.99 * len(calm)


@pytest.mark.ci
def test_a_hundred_sessions_end_as_their_sentences_say():
    sessions = verdicts(range(100))
    assert_none_is_violated(sessions)
    assert {each.verdict for each in sessions} >= {"uploaded", "restored", "untouched"}
    assert {each.kind for each in sessions} == set(Kind)
    assert {each.fault for each in sessions} == set(uploads.FAULTS)


@pytest.mark.long
def test_five_thousand_sessions_end_as_their_sentences_say():
    assert_none_is_violated(verdicts(range(uploads.SESSIONS)))


def test_the_judge_notices_lists_that_are_not_restored(monkeypatch):
    """The user interrupts, and the upload claims to have restored its lists."""

    def claims(link, states, earlier, autopilot):
        states.update(dict.fromkeys(states, upload._State.EARLIER))
        return False

    monkeypatch.setattr(upload, "_recover", claims)
    assert "violated" in {uploads.session(seed).verdict for seed in seeds_of("interrupt", 8)}


def test_the_judge_notices_a_list_that_a_restart_has_lost(monkeypatch):
    """The lengths of lists are not asked for at the end."""
    monkeypatch.setattr(upload, "holds", lambda *_args: True)
    lost = seeds_of("restart, lists lost", 30)
    assert any(uploads.session(seed).verdict == "violated" for seed in lost)


def test_a_session_is_repeatable():
    assert uploads.session(3) == uploads.session(3)


def test_the_table_counts_the_sessions():
    made = [
        uploads.Session(1, Kind.PX4, "none", "uploaded", "", 3.0),
        uploads.Session(2, Kind.PX4, "interrupt", "violated", "Nothing happened.", 3.0),
    ]
    report = uploads.report(made)
    rows = {tuple(row[:2]): row[2:] for row in report.rows}
    assert rows["px4", "none"] == (1, 1, 0, 0, 0, 0, 0)
    assert rows["px4", "interrupt"] == (1, 0, 0, 0, 0, 0, 1)
    assert report.failed
    assert report.notes[-1] == "Seed 2: Nothing happened."


@pytest.mark.ci
def test_a_late_acknowledgement_of_an_earlier_list_ends_no_upload():
    """PX4's fence and rally list seem accepted before their items are sent."""
    assert uploads.session(4140).verdict == "uploaded"
