"""Boards with the collision checker that a mode of `pathgene feasible` needs."""

import re

import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device import checker_boards
from pathgene.host.device.checker_boards import order_board, require_checker
from pathgene.host.device.checker_modes import MODES
from pathgene.host.device.schemes import BoardScheme
from pathgene.host.errors import InputError


@pytest.mark.parametrize(
    ("url", "mode", "order", "build"),
    [
        ("model:", None, "model:?checker=two-tier&lanes=1", ("two-tier", 1)),
        ("sim:", "parallel", "sim:?checker=parallel", ("parallel", 8)),
        ("sim:?sim=icarus", "detailed", "sim:?checker=parallel&lanes=1&sim=icarus",
         ("parallel", 1)),
        ("model:?lanes=16", "parallel", "model:?checker=parallel&lanes=16", ("parallel", 16)),
        ("model:?checker=parallel", None, "model:?checker=parallel", ("parallel", 8)),
        ("model:?checker=parallel", "detailed", "model:?checker=parallel&lanes=1",
         ("parallel", 1)),
        ("model:?checker=two-tier", None, "model:?checker=two-tier&lanes=1", ("two-tier", 1)),
    ],
)  # fmt: skip
def test_boards_are_built_for_their_mode(url, mode, order, build):
    ordered_url, config = order_board(url, mode)
    assert ordered_url == order
    assert (config.checker, config.lanes) == build


@pytest.mark.parametrize("mode", [None, *MODES])
def test_hardware_says_itself_what_it_has(mode):
    assert order_board("/dev/ttyUSB0?baud=9600", mode) == ("/dev/ttyUSB0?baud=9600", None)


def test_a_simulated_board_may_leave_its_configuration_open(monkeypatch):
    class Scheme(BoardScheme):
        simulated = True

        def open(self, url):
            raise AssertionError(url)

    monkeypatch.setattr(checker_boards, "board_scheme", lambda url: Scheme())
    ordered = order_board("probe:?serial=7", "parallel")
    assert ordered == ("probe:?checker=parallel&serial=7", None)


@pytest.mark.parametrize(
    ("config", "mode"),
    [
        (Config(checker=CheckerBuild.TWO_TIER, lanes=1), None),
        (Config(checker=CheckerBuild.TWO_TIER, lanes=1), "two-tier"),
        (Config(lanes=1), "detailed"),
        (Config(lanes=8), "parallel"),
    ],
)
def test_takes_a_board_that_suits_the_mode(config, mode):
    require_checker(config, mode, "/dev/ttyUSB0")


@pytest.mark.parametrize(
    ("config", "mode", "sentence"),
    [
        (
            Config(checker=CheckerBuild.NONE),
            None,
            "The board at '/dev/ttyUSB0' has no collision checker; use a bitstream with one, or "
            "model:.",
        ),
        (
            Config(core="planner"),
            None,
            "The board at '/dev/ttyUSB0' has the planner core, which checks the paths "
            "that it breeds and no others; use a board with another core, or model:.",
        ),
        (
            Config(lanes=8),
            "detailed",
            "The board at '/dev/ttyUSB0' has the parallel checker of 8 lanes, which does not "
            "serve --mode detailed; leave --mode out.",
        ),
        (
            Config(checker=CheckerBuild.TWO_TIER, lanes=1),
            "parallel",
            "The board at '/dev/ttyUSB0' has the two-tier checker of 1 lane, which does not "
            "serve --mode parallel; leave --mode out.",
        ),
    ],
)
def test_refuses_other_boards(config, mode, sentence):
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        require_checker(config, mode, "/dev/ttyUSB0")
