"""Sessions with faults on the model: nothing is broken, and a planted bug is noticed."""

import pytest

from tools.faults.__main__ import main
from tools.faults.blind import BLIND
from tools.faults.campaign import Campaign, case_of, judge_of, run, sessions
from tools.faults.case import Case
from tools.faults.chips import Board
from tools.faults.later import LATER
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


#: The first seed whose session noticed each planted bug when it was planted.
NOTICED = {
    "lost acknowledgement accepted": 0,
    "sequence number reused": 0,
    "checksum ignored": 66,
    "board taken back in silence": 5,
    "map believed after a reset": 35,
    "map known before it is acknowledged": 46,
    "no limit of silence": 60,
    "command repeated by the chip": 35,
    "file written in its place": 4,
    "torn line taken for whole": 3,
    "lost run counted": 3,
    "mixture accepted": 44,
    "file not synced": 14,
    "folder not synced": 14,
    "stored run not synced": 28,
    "name of stored runs not synced": 108,
    "older files not put back": 54,
    "refusal to put back not told": 54,
    "obsolete files left": 4,
    "hidden files left": 9,
    "stored runs not read": 3,
    "signal forgotten": 59,
    "given up at the first silence": 0,
    "last session resumed": 645,
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


#: A seed below 1,000 whose session notices each bug that was chosen without the simulator.
BLIND_NOTICED = {
    "signal handlers not restored after an error": 9,
    "copy of the population kept after a failed step": 425,
    "batch stays open after an error": 17,
    "answers of an earlier session accepted": 112,
    "chip: OUT_OF_ORDER has the number of the frame": 11,
    "session 0 not skipped": 516,
    "signal between the disk and the count of a run": 238,
    "late answers after a refusal not awaited": 120,
    "stored runs not locked": 3,
    "INFO and OPEN asked without limit": 7,
    "all tasks repeated after the death of a process": 258,
    "only copy of an older file removed": 209,
    "chip: a refused command uses up its number": 675,
    "session kept after an error": 60,
    "shorter form never used": 135,
    "names not synced before obsolete files go": 614,
    "sequence numbers wrap one early": 135,
    "older file moved away instead of linked": 19,
    "last file renamed before obsolete files go": 209,
    "torn line not ended": 3,
    "refusal taken for an answer": 15,
    "failed sync of a run swallowed": 3,
    "update_map opens no new session": 570,
    "credit not returned after a silence": 60,
    "batch forgets its losses before it is sent": 117,
    "OPEN has the number of the first command": 32,
    "chip: a late OPEN restarts the order": 405,
    "copy of the population kept after a failed load": 101,
}
#: The same for later bugs chosen without the simulator.
LATER_NOTICED = {
    "chip: a repeated RUN runs again": 52,
    "chip: every new session accepted": 26,
    "task of a worker that died not done": 258,
    "answer before the window accepted": 0,
    "failed sync of a new file swallowed": 289,
    "reset not noticed by reopen": 26,
    "new files kept after a failure": 684,
    "every good frame counts as progress": 117,
    "short form has the order of before": 990,
    "line without its newline not ended": 33,
    "repeated signals told apart by the time of day": 9,
    "session kept after an interrupt": 150,
}
#: Every fourth is tried each time.
SAMPLED = list((BLIND_NOTICED | LATER_NOTICED).items())[::4]
#: Bugs that no session has noticed; docs/reliability.md names them.
UNNOTICED = {
    "silences not forgotten after progress",
    "box of a drawn zone noted as blocked",
    "run counted only after its answer",
    "earlier run not ended by reopen",
}


def test_every_planted_bug_has_a_seed():
    every = {*NOTICED, *BLIND_NOTICED, *UNNOTICED, *LATER_NOTICED}
    assert every == set(PLANTED)
    assert {*BLIND_NOTICED, *LATER_NOTICED, *UNNOTICED} == {*BLIND, *LATER}


@pytest.mark.parametrize("bug", PLANTED)
def test_every_planted_bug_can_be_planted(bug):
    """The text that it replaces is still in the product."""
    with planted(bug):
        pass


@pytest.mark.parametrize(("bug", "seed"), [*NOTICED.items(), *SAMPLED])
def test_a_planted_bug_is_noticed(bug, seed):
    """When draws or sessions change, the long test below tells the new seeds."""
    [(_, without)] = run(Board.MODEL, [seed], jobs=1)
    [(_, with_bug)] = run(Board.MODEL, [seed], jobs=1, bug=bug)
    assert (without.violation, bool(with_bug.violation)) == ("", True)


@pytest.mark.long
@pytest.mark.parametrize("bug", NOTICED)
def test_a_planted_bug_is_noticed_within_a_thousand_seeds(bug):
    cases = run(Board.MODEL, range(1000), jobs=1, bug=bug)
    first = next(case.seed for case, verdict in cases if verdict.violation)
    assert first <= NOTICED[bug]


@pytest.mark.long
@pytest.mark.parametrize(
    ("bug", "seed"),
    [each for each in (BLIND_NOTICED | LATER_NOTICED).items() if each not in SAMPLED],
)
def test_a_bug_chosen_without_the_simulator_is_noticed(bug, seed):
    test_a_planted_bug_is_noticed(bug, seed)


#: Seeds of sessions on the Verilog that were once broken: by a late second refusal of a command, by
#: one of BEST during a run, and by a run that continued after an interrupt. Their faults were drawn
#: before some cases got faults at a chosen command.
ONCE_BROKEN = (4, 441, 147)


@pytest.mark.parametrize(
    ("seeds", "once_broken"),
    [((0,), ONCE_BROKEN[:1]), pytest.param((1,), ONCE_BROKEN[1:], marks=pytest.mark.long)],
    ids=["one", "others"],
)
def test_a_session_on_the_verilated_chip(monkeypatch, seeds, once_broken):
    done = list(run(Board.SIM, seeds, jobs=1))
    monkeypatch.setattr("tools.faults.case._at_a_command", lambda rng, case, extent: case)
    done += run(Board.SIM, once_broken, jobs=1)
    for case, verdict in done:
        assert verdict.violation == "", case.to_json()
