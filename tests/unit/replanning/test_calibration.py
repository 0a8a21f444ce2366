"""The host's share of a replan is the host's own time."""

import dataclasses

from pathgene.host.problem.zones import Zone
from pathgene.host.replanning import calibration
from pathgene.host.replanning.calibration import measure_host_s
from pathgene.sim.model.chip import ModelPort


class Clock:
    """Time that passes in the model alone, a second per write, and a tick per look."""

    def __init__(self):
        self.seconds = 0.0

    def __call__(self):
        self.seconds += 1e-4
        return self.seconds


def test_the_time_of_the_board_is_no_share_of_the_host(mission, monkeypatch):
    clock, write = Clock(), ModelPort.write

    def slow(port, data):
        clock.seconds += 1.0
        return write(port, data)

    monkeypatch.setattr(ModelPort, "write", slow)
    monkeypatch.setattr(calibration.time, "perf_counter", clock)
    monkeypatch.setattr(calibration.time, "monotonic", clock)
    opened = calibration.open_board

    def on_clock(url):
        board = opened(url)
        chip = board.__enter__()
        chip.link._clock = clock
        return _Opened(board, chip)

    monkeypatch.setattr(calibration, "open_board", on_clock)
    share_s = measure_host_s(mission)
    # Some ten looks at the clock, but none of the five or more writes.
    assert 1e-4 < share_s < 0.1
    assert share_s == round(share_s, 5)
    assert clock.seconds > 50


class _Opened:
    def __init__(self, board, chip):
        self._board, self._chip = board, chip

    def __enter__(self):
        return self._chip

    def __exit__(self, *error):
        return self._board.__exit__(*error)


def test_without_a_path_there_is_no_share(mission):
    wall = Zone.polygon([(3900.0, -500.0), (4100.0, -500.0), (4100.0, 9500.0), (3900.0, 9500.0)])
    assert measure_host_s(dataclasses.replace(mission, zones=(wall,))) is None
