import json
import socket
import struct
import threading
import time
from pathlib import Path

import pytest

from pathgene.host.device.link import LinkError
from pathgene.host.device.socket_port import BUSY, SocketPort


@pytest.fixture
def far_end():
    """Listening socket for a SocketPort."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server


@pytest.fixture
def ends(far_end):
    with SocketPort(far_end.getsockname(), timeout=5) as port:
        peer, _ = far_end.accept()
        with peer:
            yield port, peer


def test_port_reads_the_requested_bytes(ends):
    port, peer = ends
    peer.sendall(b"abcdef")
    assert port.read(2) == b"ab"
    assert port.in_waiting == 4
    assert port.read(4) == b"cdef"
    assert port.in_waiting == 0


def test_port_waits_for_late_bytes(ends):
    port, peer = ends
    late = threading.Timer(0.05, peer.sendall, [b"cd"])
    peer.sendall(b"ab")
    late.start()
    assert port.read(4) == b"abcd"
    late.join()


@pytest.mark.parametrize("timeout", [0, 0.05])
def test_port_times_out(ends, timeout):
    port, peer = ends
    peer.sendall(b"ab")
    while port.in_waiting < 2:
        pass
    port.timeout = timeout
    start = time.monotonic()
    assert port.read(10) == b"ab"
    assert timeout <= time.monotonic() - start < timeout + 0.5


def test_port_writes_more_than_buffers_hold(ends, monkeypatch):
    port, peer = ends
    peer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 16)
    data = bytes(range(256)) * (1 << 16)  # 16 MiB.
    received = bytearray()
    waits = threading.Event()
    real = SocketPort._wait

    def wait(port, **how):
        waits.set()
        return real(port, **how)

    def drain():
        # Nothing is read until the port has no more room.
        waits.wait(timeout=60)
        while len(received) < len(data):
            received.extend(peer.recv(1 << 16))

    monkeypatch.setattr(SocketPort, "_wait", wait)
    reader = threading.Thread(target=drain)
    reader.start()
    assert port.write(data) == len(data)
    reader.join()
    assert waits.is_set()
    assert received == data


def test_port_write_times_out(ends):
    port, _ = ends
    port.write_timeout = 0.05
    sentence = r"^The board at socket://\S+ took no more bytes for 0\.05 s$"
    with pytest.raises(TimeoutError, match=sentence):
        port.write(bytes(1 << 24))


def test_port_reports_a_reset_connection(ends):
    port, peer = ends
    peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    peer.close()
    with pytest.raises(LinkError, match=r"^The board at socket://\S+ is gone: .*reset by peer"):
        port.read()


def test_port_says_when_it_is_closed(far_end):
    closed = []
    SocketPort(far_end.getsockname(), on_close=lambda: closed.append(True)).close()
    assert closed == [True]


def test_port_reports_a_closed_peer(ends):
    port, peer = ends
    peer.close()
    sentence = (
        r"^The board at socket://\S+ is gone: it closed the connection; it has ended, or another "
        r"client has taken it after a second without bytes\.$"
    )
    with pytest.raises(LinkError, match=sentence):
        port.read()


def test_port_explains_a_closed_peer(far_end):
    with SocketPort(far_end.getsockname(), explain=lambda: "It is gone.") as port:
        far_end.accept()[0].close()
        with pytest.raises(LinkError, match=r"^It is gone\.$"):
            port.read()


def forever(call, argument):
    while True:
        call(argument)


IN_USE = r"^The board at socket://\S+ is in use by another client: try again when that has left\.$"


@pytest.mark.parametrize("read_size", [1, 4, 100])
def test_port_reports_a_board_in_use(ends, read_size):
    port, peer = ends
    peer.sendall(BUSY)
    peer.close()
    with pytest.raises(LinkError, match=IN_USE):
        forever(port.read, read_size)


def test_port_reports_a_board_in_use_that_has_not_read(ends):
    port, peer = ends
    port.write(b"a frame")
    peer.sendall(BUSY)
    peer.close()  # The unread frame resets the connection.
    with pytest.raises(LinkError, match=IN_USE):
        forever(port.write, b"a frame")


@pytest.mark.parametrize("told", [BUSY[:-1], BUSY + b"\0", b"\0" + BUSY])
def test_port_takes_nothing_else_for_a_board_in_use(ends, told):
    port, peer = ends
    peer.sendall(told)
    peer.close()
    with pytest.raises(LinkError, match=r"^The board at socket://\S+ is gone: it closed "):
        port.read(100)


def test_the_simulated_board_says_the_same():
    source = (Path(__file__).parents[3] / "sim" / "board" / "bridge.hpp").read_text()
    assert f"kBusy[] = {json.dumps(BUSY.decode())};" in source


def test_port_reports_a_missing_peer(far_end):
    address = far_end.getsockname()
    far_end.close()
    with pytest.raises(ConnectionRefusedError):
        SocketPort(address)


def test_closed_port_is_closed(ends):
    port, _ = ends
    assert port.is_open
    port.close()
    port.close()
    assert not port.is_open
