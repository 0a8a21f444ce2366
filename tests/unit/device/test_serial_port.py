"""Ports of pyserial: every write ends, whatever it is connected to."""

import contextlib
import os
import re
import select
import socket
import threading
import time
import tty

import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.device.link import Link, LinkTimeoutError
from pathgene.host.device.serial_port import SerialPort
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import CHECKING


@pytest.fixture
def terminal():
    """Near end and path of a pseudo terminal."""
    near, far = os.openpty()
    tty.setraw(far)
    yield near, os.ttyname(far)
    os.close(far)
    os.close(near)


@pytest.fixture
def port(terminal):
    """Port of a terminal whose other end nobody reads."""
    port = SerialPort(terminal[1], 3_000_000)
    yield port
    port.close()


def test_passes_bytes_both_ways(terminal, port):
    near, _ = terminal
    port.timeout = port.write_timeout = 5.0
    assert (port.timeout, port.write_timeout) == (5.0, 5.0)
    assert port.write(b"ab\0\n") == 4
    assert os.read(near, 9) == b"ab\0\n"
    os.write(near, b"cd")
    assert port.read(2) == b"cd"
    assert port.in_waiting == 0
    port.timeout = 0.05
    assert port.read(1) == b""


def test_a_write_that_nobody_reads_times_out(port):
    port.write_timeout = 0.2
    begun = time.monotonic()
    with pytest.raises(TimeoutError, match=r"^Write timeout$"):
        port.write(bytes(1 << 20))
    assert 0.2 <= time.monotonic() - begun < 2


def fill(path):
    """Write to an unread terminal until it accepts no more bytes."""
    far = os.open(path, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
    for size in (4096, 256, 1):
        with contextlib.suppress(BlockingIOError):
            while os.write(far, bytes(size)):
                pass
        time.sleep(0.05)  # The kernel moves bytes from one buffer to the next.
    os.close(far)


def test_a_terminal_that_stalls_during_an_upload_costs_the_patience(terminal):
    """The chip stops in the middle of a map; the error is one sentence."""
    near, path = terminal
    stopped = threading.Event()
    chip = Chip(CHECKING)

    def serve():
        while not stopped.is_set():
            if select.select([near], [], [], 0.05)[0]:
                os.write(near, chip.feed(os.read(near, 4096)))

    server = threading.Thread(target=serve)
    server.start()
    try:
        with open_board(f"{path}?patience=1") as board:
            size = board.config.map_size
            board.upload_map([[1] * size] * size)
            stopped.set()
            server.join()
            fill(path)
            begun = time.monotonic()
            sentence = (
                r"^The board took no bytes for 1\.\d+ s: check that it runs, and the cable\.$"
            )
            with pytest.raises(LinkTimeoutError, match=sentence):
                board.upload_map([[2] * size] * size)
            assert 1 <= time.monotonic() - begun < 8
    finally:
        stopped.set()
        server.join()


@pytest.mark.ci
def test_rfc2217_ends_its_writes_by_itself():
    """Pyserial does not support a write timeout there: it ends each write after 5 s."""
    import serial.rfc2217

    with socket.create_server(("127.0.0.1", 0)) as server:
        peers = []

        def serve():
            """Answer the negotiation of the options as a server does, then read no more."""
            peer, _ = server.accept()
            peers.append(peer)
            manager = serial.rfc2217.PortManager(
                serial.serial_for_url("loop://"), _Connection(peer)
            )
            peer.settimeout(0.1)
            while not stopped.is_set():
                try:
                    data = peer.recv(1024)
                except TimeoutError:
                    continue
                list(manager.filter(data))

        stopped = threading.Event()
        thread = threading.Thread(target=serve)
        thread.start()
        port = SerialPort(f"rfc2217://127.0.0.1:{server.getsockname()[1]}", 115200)
        try:
            Link(port, timeout_s=0.25, attempts=2)
            assert port.write_timeout is None
            port.timeout = 0.1  # It accepts settings.
            stopped.set()
            thread.join()
            begun = time.monotonic()
            with pytest.raises(OSError, match=re.escape("timed out")):
                port.write(bytes(1 << 24))
            assert time.monotonic() - begun < 20
        finally:
            stopped.set()
            thread.join()
            for peer in peers:
                peer.close()
            port.close()


class _Connection:
    """The stream to which serial.rfc2217.PortManager writes its answers."""

    def __init__(self, peer):
        self._peer = peer

    def write(self, data):
        self._peer.sendall(data)
