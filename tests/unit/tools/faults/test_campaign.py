"""Sessions with faults on the model: nothing is broken, and a planted bug is noticed."""

import pytest

from tools.faults.campaign import Campaign, run, sessions
from tools.faults.chips import Board
from tools.faults.planted import PLANTED


pytestmark = pytest.mark.ci


def test_sessions_on_the_model_keep_everything():
    done = Campaign()
    for case, verdict in run(Board.MODEL, range(60), jobs=1):
        done.add(case, verdict)
    assert done.violations == []
    assert set(done.sessions) == set(sessions(Board.MODEL))
    assert done.outcomes["done"] < 60


@pytest.mark.parametrize("bug", PLANTED)
def test_a_planted_bug_is_noticed(bug):
    """Within 1,000 seeds; each was found within the first dozens."""
    cases = run(Board.MODEL, range(1000), jobs=1, bug=bug)
    assert any(verdict.violation for _, verdict in cases)


def test_a_session_on_the_verilated_chip():
    for case, verdict in run(Board.SIM, range(2), jobs=1):
        assert verdict.violation == "", case.to_json()
