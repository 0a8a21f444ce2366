"""The model at real sockets and a terminal: one client at a time, and no client for ever."""

import contextlib
import os
import socket
import time

import pytest

from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command, Counter
from pathgene.host.device.boards import board_scheme, open_board
from pathgene.host.device.socket_port import BUSY
from pathgene.host.errors import InputError, JobError
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import SMALL
from tools.chips import board_url


INFO = b"\0" + encode_frame(bytes((0, 1, Command.INFO)), plain=True)
# Twice the second after which a silent client loses the board.
SOON_S = 2.5


@contextlib.contextmanager
def served(*, pty=False):
    url = board_url("model", SMALL)
    with board_scheme(url).serve(url, listen="127.0.0.1:0", pty=pty) as board:
        yield board


@pytest.fixture
def board():
    with served() as board:
        yield board


def connect(board):
    host, port = board.url.removeprefix("socket://").split(":")
    return socket.create_connection((host, int(port)), timeout=10)


def connect_narrow(board):
    """Connect with buffers that a few requests and answers fill."""
    board._listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    host, port = board.url.removeprefix("socket://").split(":")
    client = socket.socket()
    for buffer in (socket.SO_SNDBUF, socket.SO_RCVBUF):
        client.setsockopt(socket.SOL_SOCKET, buffer, 4096)
    client.connect((host, int(port)))
    return client


def flood(client):
    """Send requests, many times as many as the board answers to a client that never reads."""
    for _ in range(2000):
        client.sendall(INFO * 10)


def receive(client):
    """Return the next bytes for a client, empty once it is disconnected; fail if it must wait."""
    try:
        return client.recv(4096)
    except TimeoutError:
        pytest.fail("the board sends nothing")


def answer(client):
    """Return the answer to INFO, up to its delimiter."""
    client.sendall(INFO)
    data = b""
    while not data.endswith(b"\0"):
        part = receive(client)
        if not part:
            break
        data += part
    return data


def test_the_chip_keeps_its_state_from_one_client_to_the_next(board):
    with open_board(board.url) as chip:
        assert chip.config == SMALL
        chip.load([[1, 2]] * SMALL.population)
    begun_s = time.monotonic()
    with open_board(board.url) as chip:
        assert chip.step(range(SMALL.population)).paths[0] == [1, 2]
    assert time.monotonic() - begun_s < SOON_S
    assert board.wait(0.01) is None
    assert board.pid == os.getpid()


def test_every_byte_passes_as_the_chip_sends_it(board):
    """A terminal would change some, such as 10 and 13."""
    asked = b"".join(
        encode_frame(bytes((0, number, Command.INFO)), plain=True) for number in range(256)
    )
    expected = Chip(SMALL).feed(asked)
    data = b""
    with connect(board) as client:
        client.sendall(asked)
        while len(data) < len(expected):
            data += receive(client)
    assert data == expected


def test_clients_that_wait_hear_that_the_board_is_busy(board):
    with connect(board) as first, connect(board) as second:
        assert answer(first)
        second.sendall(INFO)
        time.sleep(0.1)
        assert answer(first)
        assert receive(second) == BUSY
        assert receive(second) == b""
        assert answer(first)


def test_a_client_that_asks_is_served_before_a_silent_one_that_came_first(board):
    with connect(board) as first:
        assert answer(first)
        with connect(board) as silent, connect(board) as asks:
            asks.sendall(INFO)
            while len(board._waiting) < 2:
                time.sleep(0.01)
            first.close()
            # The board answers the client that asks, and is busy for the silent one.
            assert len(receive(asks)) > len(BUSY)
            assert receive(silent) == BUSY


def test_a_silent_client_loses_the_board_to_one_that_asks(board):
    with connect(board) as first:
        time.sleep(0.1)
        with connect(board) as second:
            begun_s = time.monotonic()
            assert len(answer(second)) > len(BUSY)
            assert 0.5 < time.monotonic() - begun_s < SOON_S
        assert receive(first) == b""


def test_a_client_that_has_closed_its_sending_side_has_left(board, monkeypatch):
    monkeypatch.setattr("pathgene.sim.served_model._IDLE_S", 600.0)
    with connect(board) as first:
        assert answer(first)
        first.shutdown(socket.SHUT_WR)
        with connect(board) as second:
            assert len(answer(second)) > len(BUSY)


def test_a_client_that_never_reads_loses_the_board(board):
    with connect_narrow(board) as first:
        first.settimeout(0.3)
        with pytest.raises(TimeoutError):
            flood(first)
        with connect(board) as second:
            # Answers to the first client may still count.
            assert len(answer(second)) > 0
        begun_s = time.monotonic()
        with connect(board) as third:
            third.settimeout(10)
            assert answer(third)
        assert time.monotonic() - begun_s < 2 * SOON_S


def test_a_ninth_client_that_waits_is_refused(board):
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(connect(board)) for _ in range(10)]
        refused = clients[1]
        assert receive(refused) == BUSY


def test_the_chip_waits_while_nobody_reads_its_replies(board):
    with connect_narrow(board) as client:
        client.sendall(INFO * 10_000)
        # The board is taken from this client once the chip has answered nothing for a second.
        reply = BUSY
        while reply == BUSY:
            time.sleep(0.02)
            with connect(board) as second:
                reply = answer(second)
    assert reply == Chip(SMALL).feed(INFO)
    assert board._chip._counters[Counter.BYTES_RECEIVED] < 5_000 * len(INFO)


def test_a_terminal():
    with served(pty=True) as board, open_board(board.url) as chip:
        chip.load([[1, 2]] * SMALL.population)
        assert chip.step(range(SMALL.population)).paths[0] == [1, 2]


def test_a_terminal_that_nobody_reads_serves_the_next_user():
    with served(pty=True) as board:
        terminal = os.open(board.url, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        with contextlib.suppress(BlockingIOError):
            for _ in range(5000):
                os.write(terminal, INFO)
        os.close(terminal)
        # Answers that nobody reads wait, and are lost after a second.
        deadline_s = time.monotonic() + 20
        while not board._unsent:
            assert time.monotonic() < deadline_s
        while board._unsent:
            assert time.monotonic() < deadline_s
            time.sleep(0.05)
        begun_s = time.monotonic()
        with open_board(board.url) as chip:
            assert chip.config == SMALL
        assert time.monotonic() - begun_s < 2 * SOON_S


def test_it_ends_at_once():
    with served() as board:
        client = connect(board)
        assert answer(client)
    assert receive(client) == b""
    client.close()
    with pytest.raises(InputError, match=r"refused"):
        open_board(board.url)


def test_what_cannot_be_served():
    url = "model:?x=1"
    with pytest.raises(
        InputError, match=r"^The model takes only port and fields of the configuration"
    ):
        board_scheme(url).serve(url, listen="127.0.0.1:0", pty=False)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        listen = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(JobError, match=rf"^The model cannot be served at '{listen}': Address"):
            board_scheme("model:").serve("model:", listen=listen, pty=False)
