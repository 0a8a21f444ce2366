"""A flight as a whole, with the board that is named for it."""

import os
import signal

import pytest

from pathgene.host.problem.zones import Circle
from pathgene.host.replanning.fly import underway
from pathgene.host.replanning.scenario import Event, NewZone, Scenario
from pathgene.sim.board.scheme import start_simulated


def check_that_astar_takes_over(mission, path, planner, board, kill):
    """Fly with a board that ends after 20 s, and a zone that appears then."""
    said = []
    with underway(mission, path, Scenario(), planner=planner, board=board, say=said.append) as (
        session,
        report,
    ):
        while session.pilot.time_s < 20:
            session.step()
        kill(session)
        session.happen(Event(0.0, (NewZone(Circle(4500.0, 4500.0, 300.0)),)))
        session.run()
        flown = report()
    assert flown.outcome.kept
    assert any(text.endswith("astar plans in its place.") for text in said)
    (change,) = session.changes
    assert [attempt.planner for _, attempt in change.attempts] == [planner, "astar"]


@pytest.mark.parametrize("planner", ["ga-chip", "ga-fpga"])
def test_a_board_that_dies_unannounced_is_replaced_by_the_processor(
    mission, straight, planner, monkeypatch
):
    def fail(data):
        raise OSError("the cable is out")

    def kill(session):
        monkeypatch.setattr(session._planner.board.link._transport, "write", fail)

    check_that_astar_takes_over(mission, straight, planner, "model:", kill)


@pytest.mark.long  # The model's board, above, dies in the same way.
@pytest.mark.cosim
def test_a_killed_simulator_is_replaced_by_the_processor(mission, straight):
    with start_simulated("sim:?core=planner", pty=True, keep=True) as board:
        check_that_astar_takes_over(
            mission, straight, "ga-chip", board.url, lambda _: os.kill(board.pid, signal.SIGKILL)
        )
