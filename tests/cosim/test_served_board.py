"""A simulated board with competing clients: real sockets and terminals, real processes."""

import contextlib
import json
import os
import random
import re
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command
from pathgene.host.cli import main
from pathgene.host.device.boards import open_board
from pathgene.host.device.link import LinkError
from pathgene.host.device.socket_port import BUSY
from pathgene.sim.board import SimulatedBoard, build_program
from pathgene.sim.board.scheme import start_simulated
from tests.cosim.echo_design import echo_verilog
from tests.support.gateware.chips import SMALL
from tests.support.host.processes import Started
from tools.chips import board_url


pytestmark = pytest.mark.cosim

ROOT = Path(__file__).resolve().parents[2]
#: Maximum time that one client may keep the board from another, and as much again for a loaded
#: machine.
SOON_S = 2.5
INFO = b"\0" + encode_frame(bytes((0, 1, Command.INFO)), plain=True)


@pytest.fixture(scope="module")
def echo():
    """Program of a chip that echoes everything that it receives."""
    return build_program("verilator", echo_verilog(4), "uart_echo", 4)


@pytest.fixture
def served(echo):
    """A served board with an echo chip."""
    with SimulatedBoard(echo, keep=True) as board:
        yield board


@pytest.fixture
def chip():
    """A served board with a chip."""
    with start_simulated(board_url("sim", SMALL), keep=True) as board:
        yield board


def connect(board):
    host, port = board.url.removeprefix("socket://").split(":")
    client = socket.create_connection((host, int(port)), timeout=10)
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return client


def read(client, size):
    """Return ``size`` bytes, or all bytes before the end."""
    data = b""
    while len(data) < size and (part := client.recv(size - len(data))):
        data += part
    return data


def flood(client, data, seconds):
    """Send ``data`` repeatedly without reading; return the number of bytes accepted."""
    client.setblocking(False)
    sent, end = 0, time.monotonic() + seconds
    try:
        while (left := end - time.monotonic()) > 0:
            if select.select([], [client], [], left)[1]:
                sent += client.send(data)
    except OSError:
        pass  # It was disconnected.
    return sent


def works_soon(board, limit_s=SOON_S):
    """Assert that a client opens the chip and uses it."""
    begun = time.monotonic()
    with open_board(board.url) as client:
        client.load([[1, 2]] * 8)
        assert client.step(range(8)).paths[0] == [1, 2]
    assert time.monotonic() - begun < limit_s


def test_a_waiting_client_gets_the_board_of_an_idle_one(served):
    with connect(served) as idle:
        idle.sendall(b"a")
        assert read(idle, 1) == b"a"
        time.sleep(0.2)
        begun = time.monotonic()
        with connect(served) as waiting:
            waiting.sendall(b"mine")
            assert read(waiting, 4) == b"mine"
            assert 0.5 < time.monotonic() - begun < SOON_S
            assert read(idle, 1) == b""


def test_an_idle_client_keeps_the_board_while_nobody_waits(served):
    with connect(served) as client:
        for byte in (b"a", b"b"):
            client.sendall(byte)
            assert read(client, 1) == byte
            time.sleep(1.2)
        client.sendall(b"c")
        assert read(client, 1) == b"c"


def test_a_client_that_goes_on_keeps_the_board_however_long_it_was_idle(served):
    with connect(served) as client:
        client.sendall(b"a")
        assert read(client, 1) == b"a"
        time.sleep(1.2)
        with connect(served) as second:
            time.sleep(0.2)
            client.sendall(b"b")
            assert read(client, 1) == b"b"
            assert read(second, 100) == BUSY


def test_a_second_client_hears_that_the_board_is_busy(served):
    with connect(served) as first, connect(served) as second, connect(served) as third:
        begun = time.monotonic()
        for byte in (b"a", b"b", b"c", b"d"):
            first.sendall(byte)
            assert read(first, 1) == byte
            time.sleep(0.1)
        assert read(second, 100) == BUSY
        assert read(third, 100) == BUSY
        assert time.monotonic() - begun < SOON_S
        first.sendall(b"z")
        assert read(first, 1) == b"z"


def test_a_busy_board_is_one_sentence_and_status_1(chip, capsys):
    ended = threading.Event()

    def use():
        with open_board(chip.url) as client:
            opened.set()
            while not ended.is_set():
                client.status()
                time.sleep(0.01)

    opened = threading.Event()
    user = threading.Thread(target=use)
    user.start()
    try:
        assert opened.wait(10)
        sentence = (
            f"The board at {chip.url} is in use by another client: try again when that has left."
        )
        with pytest.raises(LinkError, match=f"^{re.escape(sentence)}$"):
            open_board(chip.url)
        assert main(["board", "info", "--board", chip.url]) == 1
        assert capsys.readouterr().err == f"pathgene: {sentence}\n"
    finally:
        ended.set()
        user.join()
    works_soon(chip)


def test_a_host_whose_board_was_taken_says_so(chip):
    with open_board(chip.url) as first:
        works_soon(chip)
        with pytest.raises(
            LinkError, match=r"^The board at \S+ is gone: .*another client has taken "
        ):
            first.status()


@pytest.mark.ci
def test_a_plan_that_loses_its_board_to_another_client_keeps_its_best_path(chip, tmp_path):
    """The host computes for more than a second between two frames; here, it is stopped."""
    terrain = tmp_path / "plain.npz"
    np.savez(terrain, elevation=np.zeros((21, 21)), dx_m=100.0, dy_m=100.0)
    command = [sys.executable, "-m", "pathgene", "plan", "--terrain", terrain, "--agl", "--start",
               "100,100,50", "--goal", "1900,1900,50", "--board", chip.url, "--planner", "ga-fpga",
               "--generations", "1000000", "--out", tmp_path / "out"]  # fmt: skip
    with Started(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        while not process.stderr.readline().startswith("generation 0/"):
            assert process.poll() is None
        process.send_signal(signal.SIGSTOP)
        works_soon(chip)
        process.send_signal(signal.SIGCONT)
        error = process.communicate(timeout=300)[1]
    assert process.returncode == 1
    assert re.fullmatch(
        rf"pathgene: The board at {chip.url} is gone: .*another client has taken .*; the best path "
        "until then is written\\.",
        error.splitlines()[-1],
    )
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["stopped_by"] == "failure"
    assert main(["check", "--path", str(tmp_path / "out" / "summary.json")]) in (0, 1)
    works_soon(chip)


def test_what_a_client_that_left_had_sent_and_would_have_read_is_dropped(served):
    with connect(served) as gone:
        gone.sendall(bytes(50_000))
    with connect(served) as client:
        client.sendall(b"mine")
        assert read(client, 4) == b"mine"
        client.settimeout(0.3)
        with pytest.raises(TimeoutError):
            client.recv(1)


def test_garbage_of_a_client_that_left_delays_nobody(chip):
    """3 MB would take the chip minutes."""
    with connect(chip) as gone:
        sender = threading.Thread(target=flood, args=(gone, random.Random(1).randbytes(1 << 16), 1))
        sender.start()
        sender.join()
    works_soon(chip)


@pytest.mark.parametrize(
    "data", [random.Random(2).randbytes(1 << 12), bytes(1 << 12), INFO * 100],
    ids=["random", "zeros", "questions"],
)  # fmt: skip
def test_a_client_that_never_stops_and_never_reads(chip, data):
    """It is disconnected when far ahead of the chip; the board then answers the next client."""
    with connect(chip) as client:
        thread = threading.Thread(target=flood, args=(client, data, 20))
        begun = time.monotonic()
        thread.start()
        while thread.is_alive():
            assert chip.cycles() > 0
            time.sleep(0.05)
        assert time.monotonic() - begun < 15  # Before the flood ends by itself.
        works_soon(chip)


@pytest.mark.ci
def test_a_client_that_reads_late_loses_nothing(served):
    """Simulated time stops when nobody reads; the simulator still answers."""
    data = random.Random(3).randbytes(400_000)
    with connect(served) as client:
        writer = threading.Thread(target=client.sendall, args=(data,))
        writer.start()
        before = -1
        while before != (before := served.cycles()):
            time.sleep(0.2)
        assert before < len(data) * 40  # Not all has reached the chip.
        assert read(client, len(data)) == data
        writer.join()


def test_a_client_that_never_reads_loses_the_board_to_one_that_waits(served):
    with connect(served) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        # Up to the limit of reading ahead; the echo fills all buffers, and time stops.
        flood(client, bytes(4096), 0.3)
        with connect(served) as waiting:
            begun = time.monotonic()
            waiting.sendall(b"mine")
            assert read(waiting, 4) in (b"mine", BUSY[:4])
            assert time.monotonic() - begun < SOON_S


def test_fifty_connections_at_once(chip):
    clients = [connect(chip) for _ in range(50)]
    try:
        begun = time.monotonic()
        told = [read(client, len(BUSY)) for client in clients[1:-8]]
        assert told == [BUSY] * 41
        assert time.monotonic() - begun < SOON_S
        # The first client is silent, so an active one has the board a second later.
        clients[-3].sendall(INFO)
        assert read(clients[-3], 1)
        assert read(clients[0], 1) == b""
        assert time.monotonic() - begun < 2 * SOON_S
        assert read(clients[-1], len(BUSY)) == BUSY
        works_soon(chip)
    finally:
        for client in clients:
            client.close()


def test_waves_of_silent_clients_do_not_lock_others_out(chip):
    silent = []
    try:
        for _ in range(3):
            silent += [connect(chip) for _ in range(20)]
            works_soon(chip)
    finally:
        for client in silent:
            client.close()


def test_silent_clients_that_come_back_do_not_lock_others_out(chip):
    ended = threading.Event()

    def come_back():
        while not ended.is_set():
            with connect(chip) as client:
                client.settimeout(0.2)
                with contextlib.suppress(OSError):
                    read(client, len(BUSY))

    threads = [threading.Thread(target=come_back) for _ in range(12)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(3):
            works_soon(chip)
            time.sleep(0.5)
    finally:
        ended.set()
        for thread in threads:
            thread.join()


@pytest.mark.parametrize(
    ("garbage", "pause_s", "lead_s", "limit_s"),
    [
        (b"x", 0.05, 0.2, SOON_S),
        (b"x", 0.6, 0.2, SOON_S),
        (random.Random(4).randbytes(1 << 12), 0.02, 0.5, 3 * SOON_S),
    ],
    ids=["often", "now and then", "much"],
)
def test_a_client_that_sends_garbage_loses_the_board(chip, garbage, pause_s, lead_s, limit_s):
    ended = threading.Event()

    def send():
        with contextlib.suppress(OSError):
            while not ended.wait(pause_s):
                client.sendall(garbage)

    with connect(chip) as client:
        sender = threading.Thread(target=send)
        sender.start()
        try:
            time.sleep(lead_s)
            works_soon(chip, limit_s)
        finally:
            ended.set()
            sender.join()


@pytest.mark.parametrize("garbage", [b"x", INFO[:-1]], ids=["a byte", "half a frame"])
def test_a_client_that_the_chip_does_not_answer_loses_the_board(chip, garbage):
    """Another such client waits before it, and also has the board for a second."""
    with connect(chip) as first, connect(chip) as second:
        first.sendall(garbage)
        second.sendall(garbage)
        time.sleep(0.1)
        begun = time.monotonic()
        with connect(chip) as third:
            third.sendall(INFO)
            assert read(third, 1)
        assert time.monotonic() - begun < 2 * SOON_S


@pytest.mark.parametrize(
    ("where", "warning"),
    [
        (["--listen", "0.0.0.0:0"], "0.0.0.0:0"),
        (["--listen", "localhost:0"], None),
        pytest.param(["--pty"], None, marks=pytest.mark.ci),
        pytest.param([], None, marks=pytest.mark.ci),
    ],
)
def test_a_board_that_others_reach_is_announced(where, warning):
    command = [
        sys.executable,
        "-m",
        "pathgene",
        "board",
        "serve",
        "--board",
        board_url("sim", SMALL),
    ]
    with Started(
        [*command, *where], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        url = server.stdout.readline().strip()
        lines = iter(server.stderr.readline, "pathgene: Serving until Ctrl-C.\n")
        notes = [line for line in lines if "Anybody" in line]
        with open_board(url) as client:
            assert client.config == SMALL
        server.send_signal(signal.SIGINT)
        assert server.wait(10) == 128 + signal.SIGINT
    sentence = f"pathgene: Anybody who reaches {warning} can use this board, which asks for no "
    assert [note[: len(sentence)] for note in notes] == ([sentence] if warning else [])


@pytest.mark.ci
def test_a_terminal_that_nobody_reads_serves_the_next_user(tmp_path):
    with start_simulated(board_url("sim", SMALL), pty=True, keep=True) as board:
        terminal = os.open(board.url, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        end, sent = time.monotonic() + 3, 0
        while time.monotonic() < end:
            if select.select([], [terminal], [], 0.1)[1]:
                sent += os.write(terminal, INFO * 10)
        os.close(terminal)
        assert sent > 20_000
        assert board.cycles() > 0
        begun = time.monotonic()
        with open_board(board.url) as client:
            client.load([[1, 2]] * 8)
            assert client.step(range(8)).paths[0] == [1, 2]
        assert time.monotonic() - begun < 2 * SOON_S
