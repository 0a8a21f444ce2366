"""A chip without a genetic core: its commands in gateware and model."""

import random

import pytest

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.command.receiver import CommandReceiver
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.messages import config_from_info, info_values
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, RefusedError
from pathgene.host.errors import InputError
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from tests.support.gateware.chips import CHECKING, random_path
from tests.unit.command.receiver_bench import CHECKING as BENCH
from tests.unit.command.receiver_bench import Chip as Bench
from tests.unit.command.receiver_bench import after_open, check, rectangle


CONFIG = CHECKING.replace(core="none")
GENETIC = (Command.START, Command.WRITE, Command.GENERATE, Command.READ, Command.CHECK_PATHS)


@pytest.fixture
def chip():
    with Chip(Link(ModelPort(ChipModel(CONFIG)), timeout_s=1, attempts=1)) as opened:
        yield opened


def test_needs_a_checker():
    sentence = r"^Config\.core must be paper on a chip without a checker, not none$"
    with pytest.raises(ValueError, match=sentence):
        Config(core="none", checker=CheckerBuild.NONE)


@pytest.mark.parametrize("value", [1, False, "0", "streaming", None])
def test_option_names_a_core(value):
    sentence = rf"^Config\.core must be none, paper or planner, not {value!r}$"
    with pytest.raises(ValueError, match=sentence):
        Config(core=value)
    assert Config(core="none").core is GeneticCore.NONE
    assert Config(core="paper") == Config()


def test_info_reports_it():
    values = info_values(CONFIG) | {"session": 0}
    assert values["core"] == 0
    assert config_from_info(values) == CONFIG
    assert CONFIG.build_id != CHECKING.build_id


@pytest.mark.parametrize("command", GENETIC, ids=lambda command: command.name)
def test_gateware_rejects_commands_of_the_core(command):
    bench = Bench(config=BENCH.replace(core="none"))
    (_, outcome) = bench.run(after_open((command, bytes(5))))
    assert outcome == (Status.UNKNOWN_COMMAND, AnswerKind.EMPTY, 0, 0)
    assert bench.errors == StickyError.REFUSED


@pytest.mark.parametrize("command", GENETIC, ids=lambda command: command.name)
def test_model_rejects_commands_of_the_core(chip, command):
    with pytest.raises(RefusedError, match=f"{command.name} with UNKNOWN_COMMAND"):
        chip.link.request(command, bytes(5))


def test_gateware_accepts_maps_and_paths():
    bench = Bench(config=BENCH.replace(core="none"))
    outcomes = bench.run(
        after_open(
            (Command.MAP, rectangle(1, 2, 2, 1, (3, 4))),
            (Command.CHECK, check(1, [1, 2, 3])),
            (Command.STATUS, b""),
        )
    )
    assert [(status, kind) for status, kind, *_ in outcomes[1:]] == [
        (Status.OK, AnswerKind.EMPTY),
        (Status.OK, AnswerKind.CHECKED),
        (Status.OK, AnswerKind.STATUS),
    ]
    assert [(cell.x, cell.y, cell.altitude) for cell in bench.cells] == [(1, 2, 3), (2, 2, 4)]
    assert [(point.x, point.last) for point in bench.points] == [(1, 0), (2, 0), (3, 1)]
    assert [(each["check"], each["batch"]) for each in bench.checks[1:]] == [(0, 0), (1, 0), (0, 0)]


def test_host_refuses_without_a_request(chip):
    sentence = (
        r"^The board has no genetic core, it only checks paths: use one that was built with "
        r"core=paper\.$"
    )
    for ask in (
        lambda: chip.start(0, (15, 15, 9)),
        lambda: chip.load([[1, 2]]),
        lambda: chip.read(0, 1),
        lambda: chip.step(range(8)),
        lambda: chip.check_population(1, 2),
    ):
        with pytest.raises(InputError, match=sentence):
            ask()
    path = random_path(CONFIG, random.Random(1), 4)
    assert len(chip.check_path(path).verdicts) == 1
    assert chip.counters()["paths"] == 1
    assert chip.status()["errors"] == 0


def test_gateware_lacks_the_streams_of_the_core():
    assert not hasattr(CommandReceiver(CONFIG), "start_requests")
