"""Sessions with faults on the model: nothing is broken, and a planted bug is noticed."""

import pytest

from tools.faults.__main__ import main
from tools.faults.campaign import Campaign, case_of, judge_of, run, sessions
from tools.faults.case import Case
from tools.faults.chips import Board
from tools.faults.planted import PLANTED, planted


pytestmark = pytest.mark.ci


def test_sessions_on_the_model_keep_everything():
    done = Campaign()
    for case, verdict in run(Board.MODEL, range(60), jobs=1):
        done.add(case, verdict)
    assert done.violations == []
    assert set(done.sessions) == set(sessions(Board.MODEL))
    assert done.outcomes["done"] < 60
    assert any(outcome.startswith("interrupted") for outcome in done.outcomes)


#: The first seed whose session notices each planted bug.
NOTICED = {
    "lost acknowledgement accepted": 0,
    "sequence number reused": 0,
    "checksum ignored": 36,
    "board taken back in silence": 5,
    "map believed after a reset": 21,
    "map known before it is acknowledged": 127,
    "no limit of silence": 60,
    "command repeated by the chip": 0,
    "file written in its place": 4,
    "torn line taken for whole": 3,
    "lost run counted": 3,
    "mixture accepted": 44,
    "file not synced": 14,
    "folder not synced": 14,
    "stored run not synced": 8,
    "name of stored runs not synced": 108,
    "older files not put back": 54,
    "refusal to put back not told": 54,
    "obsolete files left": 4,
    "hidden files left": 9,
    "stored runs not read": 3,
    "signal forgotten": 48,
    "given up at the first silence": 0,
    "last session resumed": 236,
}


def test_a_seed_repeats_exactly():
    seeds = range(15)
    first, again = ([verdict for _, verdict in run(Board.MODEL, seeds, jobs=1)] for _ in range(2))
    assert first == again
    assert any(verdict.faults for verdict in first)


def test_a_replay_tells_the_fewest_faults(capsys, monkeypatch):
    """These faults alone fail, too; without the bug nothing fails."""
    seed, bug = NOTICED["file written in its place"], "file written in its place"
    monkeypatch.setattr("sys.argv", ["faults", "--replay", str(seed)])
    assert main() == 0
    assert "kept, with" in capsys.readouterr().out
    monkeypatch.setattr("sys.argv", ["faults", "--replay", str(seed), "--planted", bug])
    assert main() == 1
    *_, text = capsys.readouterr().out.splitlines()
    least = Case.from_json(text)
    assert 0 < len(least.faults) <= len(case_of(Board.MODEL, seed).faults)
    judge = judge_of(Board.MODEL, least.session)
    with planted(bug):
        assert judge.judge(least).violation
    assert not judge.judge(least).violation


def test_every_planted_bug_has_a_seed():
    assert set(NOTICED) == set(PLANTED)


@pytest.mark.parametrize(("bug", "seed"), NOTICED.items())
def test_a_planted_bug_is_noticed(bug, seed):
    """When draws or sessions change, the long test below tells the new seeds."""
    [(_, without)] = run(Board.MODEL, [seed], jobs=1)
    [(_, with_bug)] = run(Board.MODEL, [seed], jobs=1, bug=bug)
    assert (without.violation, bool(with_bug.violation)) == ("", True)


@pytest.mark.long
@pytest.mark.parametrize("bug", PLANTED)
def test_a_planted_bug_is_noticed_within_a_thousand_seeds(bug):
    cases = run(Board.MODEL, range(1000), jobs=1, bug=bug)
    first = next(case.seed for case, verdict in cases if verdict.violation)
    assert first == NOTICED[bug]


def test_a_session_on_the_verilated_chip():
    for case, verdict in run(Board.SIM, range(2), jobs=1):
        assert verdict.violation == "", case.to_json()
