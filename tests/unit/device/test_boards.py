"""Boards by URL; tests/cosim/test_boards.py tests simulated boards."""

import contextlib
import dataclasses
import os
import re
import socket
import threading
import time
import tty

import pytest

from pathgene.hdl.config import Config, GeneticCore, SurvivorSelection
from pathgene.host.device import boards
from pathgene.host.device.boards import (
    entered,
    kept_open,
    known_config,
    open_board,
    require_chip,
    url_of,
)
from pathgene.host.device.link import LinkError, LinkTimeoutError
from pathgene.host.device.schemes import split_config
from pathgene.host.device.serial_port import SerialScheme
from pathgene.host.errors import InputError, JobError
from pathgene.sim.board.scheme import start_simulated
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import SMALL
from tools.chips import board_url


DEFAULT = Config(clocks_per_bit=4)
SERIAL_OPTIONS = (
    "A serial board takes the options baud=NUMBER (at most 1,000,000,000) and patience=SECONDS (at "
    "most 86,400) and no others, not '{}'."
)
FIELDS = ", ".join(field.name for field in dataclasses.fields(Config))


@pytest.mark.parametrize(
    ("url", "rest", "changes"),
    [
        ("model:", "model:", {}),
        ("model:?", "model:", {}),
        ("sim:?max_waypoints=20", "sim:", {"max_waypoints": 20}),
        (
            "sim:?sim=icarus&map_size=64&coarse_factor=8&trace=a%20b",
            "sim:?sim=icarus&trace=a+b",
            {"map_size": 64, "coarse_factor": 8},
        ),
        (
            "model:?survivor_selection=rank&clocks_per_bit=868",
            "model:",
            {"survivor_selection": SurvivorSelection.RANK, "clocks_per_bit": 868},
        ),
    ],
)
def test_configuration_in_the_url(url, rest, changes):
    assert split_config(url, DEFAULT) == (rest, DEFAULT.replace(**changes))


@pytest.mark.parametrize(
    ("url", "config"),
    [
        ("model:", DEFAULT),
        ("sim:?sim=icarus&max_waypoints=20", DEFAULT.replace(max_waypoints=20)),
        ("/dev/ttyUSB0?baud=9600", None),
        ("socket://localhost:5000", None),
    ],
)
def test_configuration_is_known_before_opening(url, config):
    assert known_config(url) == config


def test_every_field_is_an_option():
    assert split_config(board_url("sim", SMALL), DEFAULT) == ("sim:", SMALL)


@pytest.mark.parametrize(
    ("url", "sentence"),
    [
        (
            "model:?population=9",
            "Config.population must be a power of two from 4 to 256, not 9; "
            "see the options in 'model:?population=9'.",
        ),
        (
            "sim:?max_waypoints=many",
            "Config.max_waypoints must be an integer, not 'many'; "
            "see the options in 'sim:?max_waypoints=many'.",
        ),
        (
            "model:?survivor_selection=best",
            "Config.survivor_selection must be uniform or rank, not 'best'; "
            "see the options in 'model:?survivor_selection=best'.",
        ),
        (
            f"model:?population={'9' * 5000}",
            f"Config.population must be an integer, not '{'9' * 5000}'; "
            f"see the options in 'model:?population={'9' * 5000}'.",
        ),
        (
            f"sim:?idle_clocks={'9' * 5000}",
            "Option idle_clocks of the simulated board must be an integer from 0 to "
            f"9223372036854775808, not '{'9' * 5000}'.",
        ),
        (
            "model:?max_waypoints=-4",
            "Config.max_waypoints must be an integer, not '-4'; "
            "see the options in 'model:?max_waypoints=-4'.",
        ),
        (
            "model:?speed=9",
            "The model takes only port and fields of the configuration, not 'model:?speed=9'; they "
            f"are {FIELDS}.",
        ),
        (
            "model:x",
            "The model takes only port and fields of the configuration, not 'model:x'; they are "
            f"{FIELDS}.",
        ),
        (
            "sim:?speed=9",
            "The simulated board has no option 'speed'; choose from sim, idle_clocks, trace, "
            f"patience, port and the fields of the configuration, {FIELDS}.",
        ),
        (
            "/dev/ttyUSB0?baud=fast",
            SERIAL_OPTIONS.format("/dev/ttyUSB0?baud=fast"),
        ),
        (
            "/dev/ttyUSB0?parity=odd",
            SERIAL_OPTIONS.format("/dev/ttyUSB0?parity=odd"),
        ),
        *(
            (f"/dev/ttyUSB0?{query}", SERIAL_OPTIONS.format(f"/dev/ttyUSB0?{query}"))
            for query in (
                "baud=0",
                "baud=1000000001",
                f"baud={'9' * 5000}",
                "baud=",
                "patience=0",
                "patience=-1",
                "patience=nan",
                "patience=inf",
                "patience=86401",
                "patience=long",
                "patience=",
            )
        ),
        (None, "The board must be a URL, not None."),
    ],
)
def test_refuses_wrong_urls(url, sentence):
    with pytest.raises(InputError) as caught:
        open_board(url)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    "url",
    [
        "/dev/no such device",
        "nosuchscheme://x",
        "",
        "socket://",
        "socket://127.0.0.1",
        "socket://127.0.0.1:99999",
        "socket://127.0.0.1:1",
        "socket://no.such.host.invalid:5000",
    ],
)
def test_reports_boards_that_cannot_be_opened(url):
    with pytest.raises(InputError) as caught:
        open_board(url)
    sentence = str(caught.value)
    assert sentence.startswith(f"No board can be opened at {url!r} (")
    assert sentence.endswith("); give model:, sim:, a serial device or a URL of pyserial.")


def test_opens_the_model():
    with open_board(board_url("model", SMALL)) as chip:
        assert chip.config == SMALL
        chip.load([[1, 2]] * 8)
        assert chip.step(range(8)).paths[0] == [1, 2]
    with open_board("model:") as chip:
        assert chip.config == DEFAULT


def test_wrong_urls_start_no_simulator():
    with pytest.raises(InputError, match=r"^Config\.population must be "):
        start_simulated("sim:?population=3")


def serve(chip, read, write):
    """Feed ``chip`` the bytes that ``read`` returns, and write its replies."""
    with contextlib.suppress(OSError):
        while data := read(4096):
            write(chip.feed(data))


@pytest.fixture
def terminal():
    """Path of a pseudo terminal that a chip serves."""
    near, far = os.openpty()
    tty.setraw(far)
    device = os.ttyname(far)
    chip = Chip(Config())
    thread = threading.Thread(
        target=serve,
        args=(chip, lambda size: os.read(near, size), lambda data: os.write(near, data)),
    )
    thread.start()
    yield device
    os.close(far)  # The terminal has no more users, so reading it fails.
    thread.join()
    os.close(near)


def test_opens_a_serial_device(terminal):
    for session in range(2):
        with open_board(terminal) as chip:
            assert chip.info["session"] == session
            chip.load([[session, 5]] * 32)
            assert chip.read(0, 32) == [[session, 5]] * 32
    with open_board(f"{terminal}?baud=115200") as chip:
        assert chip.config == Config()


@pytest.fixture
def listener():
    """Function that listens on a socket and serves a connection in a thread."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        threads = []

        def start(answer):
            def run():
                connection, _ = server.accept()
                with connection:
                    answer(connection)

            threads.append(threading.Thread(target=run))
            threads[-1].start()
            return f"socket://127.0.0.1:{server.getsockname()[1]}"

        yield start
        for thread in threads:
            thread.join()


def test_opens_a_url_of_pyserial(listener):
    url = listener(lambda peer: serve(Chip(SMALL), peer.recv, peer.sendall))
    with open_board(url) as chip:
        assert chip.config == SMALL
        chip.load([[3, 4]] * 8)
        assert chip.read(6, 2) == [[3, 4]] * 2


def silent(peer):
    while peer.recv(4096):
        pass


def babbling(peer):
    while peer.recv(4096):
        peer.sendall(b"login: ")


def echoing(peer):
    while data := peer.recv(4096):
        peer.sendall(data)


@pytest.mark.parametrize("answer", [silent, babbling, echoing])
def test_refuses_devices_that_are_not_boards(listener, monkeypatch, answer):
    monkeypatch.setattr(boards, "_SERIAL", SerialScheme(timeout_s=0.01))
    url = f"{listener(answer)}?patience=0.1"
    sentence = (
        f"Nothing answers at '{url}' as a board would; check the address, the baud rate and "
        "that the board is configured."
    )
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        open_board(url)


def test_refuses_a_port_that_echoes(monkeypatch):
    monkeypatch.setattr(boards, "_SERIAL", SerialScheme(timeout_s=0.01))
    with pytest.raises(InputError, match=r"^Nothing answers at 'loop://\?patience=0.1' as a "):
        open_board("loop://?patience=0.1")


@pytest.mark.parametrize(
    ("query", "timeout_s", "attempts"),
    [
        ("", 0.25 + 10 * 2048 / 3_030_303, 59),
        ("?baud=9600", 0.25 + 10 * 2048 / 9600, 7),
        ("?baud=600", 0.25 + 10 * 2048 / 600, 5),
        ("?patience=60", 0.25 + 10 * 2048 / 3_030_303, 234),
        ("?patience=0.5&baud=9600", 0.25 + 10 * 2048 / 9600, 5),
    ],
)
def test_the_patience_of_a_serial_board(listener, query, timeout_s, attempts):
    """It is 15 s unless the URL sets it; a slow line adds the time of the buffered bytes."""
    url = listener(lambda peer: serve(Chip(SMALL), peer.recv, peer.sendall))
    with open_board(f"{url}{query}") as chip:
        assert chip.link.timeout_s == pytest.approx(timeout_s)
        assert chip.link.attempts == attempts


def test_gives_a_silent_board_up_after_its_patience(listener):
    def answer_twice(peer):
        chip = Chip(SMALL)
        for _ in range(2):  # INFO and OPEN.
            peer.sendall(chip.feed(peer.recv(4096)))
        silent(peer)

    with open_board(f"{listener(answer_twice)}?patience=1.5") as chip:
        begun = time.monotonic()
        with pytest.raises(LinkTimeoutError, match=r"^The board did not answer STATUS in 6 "):
            chip.status()
        assert 1.5 <= time.monotonic() - begun < 3


def test_reports_a_board_that_closes(listener):
    url = listener(lambda peer: peer.recv(4096))
    with pytest.raises(LinkError, match=r"^The board at \S+ is gone: it closed the connection; "):
        open_board(url)


def test_an_open_board_stays_open():
    with open_board("model:") as board:
        assert url_of(board) == board.url == "model:"
        with entered(board) as same:
            assert same is board
        with entered(board, core=GeneticCore.PAPER) as same:
            assert same is board
        assert not board.closed
    assert board.closed


def test_a_board_is_opened_by_its_url_with_the_core():
    with entered("model:", core=GeneticCore.PLANNER) as board:
        assert board.config.planner_core
    assert board.closed
    asked = []
    with entered("model:", lambda url: asked.append(url) or open_board(url)):
        pass
    # A board that was closed is opened again.
    with entered(board) as again:
        assert again.config.planner_core
    assert asked == ["model:"]


def test_another_core_is_built_beside_an_open_simulated_board():
    with open_board("model:") as board:
        with entered(board, core=GeneticCore.PLANNER) as other:
            assert other.config.planner_core
        with entered(board, core=GeneticCore.PLANNER) as again:
            assert again is other
        assert not other.closed
        assert board.link.session is not None
    assert other.closed
    with open_board("model:?core=paper") as named:
        with entered(named, core=GeneticCore.PLANNER) as same:
            assert same is named


@pytest.mark.parametrize(
    ("built", "core", "sentence"),
    [
        (
            {"core": GeneticCore.NONE}, GeneticCore.PAPER,
            "This board has no genetic core, it only checks paths; use another board, or the "
            "planner ga-pc.",
        ),
        (
            {}, GeneticCore.PLANNER,
            "This board has no planner core, so it does not plan by itself; use another board, or "
            "the planner ga-fpga.",
        ),
        (
            {"core": GeneticCore.PLANNER}, GeneticCore.PAPER,
            "This board has the planner core, which breeds without the host; use another board, or "
            "the planner ga-chip.",
        ),
        (
            {"population": 8, "children": 4, "survivors": 2, "inserts": 1, "deletes": 1},
            GeneticCore.PAPER,
            "The population of this board is 8, not 32; leave the population out (--population) "
            "or use another board.",
        ),
    ],
)  # fmt: skip
def test_a_planner_refuses_a_chip_of_another_kind(built, core, sentence):
    config = dataclasses.replace(Config(), **built)
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        require_chip(config, core, 32)


def test_a_planner_takes_a_chip_with_its_core():
    require_chip(Config(), GeneticCore.PAPER, 32)
    require_chip(Config(core=GeneticCore.PLANNER), GeneticCore.PLANNER, None)


def test_boards_that_are_kept_open_are_used_again():
    with kept_open():
        with entered("model:", core=GeneticCore.PLANNER) as first:
            assert not first.closed
        with entered("model:", core=GeneticCore.PLANNER) as second:
            assert second is first
            # A board in use is not given to a second user.
            with entered("model:?core=planner") as third:
                assert third is not first
        with entered("model:") as other:
            assert other.config.paper_core
    assert first.closed
    assert other.closed
    with entered("model:") as alone:
        pass
    assert alone.closed


def test_a_board_without_a_session_is_opened_again():
    """Its user may have noted the loss of the board without raising it."""
    with kept_open():
        with entered("model:") as first:
            first.link.session = None
        assert first.closed
        with entered("model:") as second:
            assert second is not first


def test_a_board_whose_use_failed_is_opened_again():
    with kept_open():
        with pytest.raises(JobError), entered("model:") as first:
            raise JobError("lost")
        assert first.closed
        with entered("model:") as second:
            assert second is not first
