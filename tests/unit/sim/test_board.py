import socket
import threading
import time
from pathlib import Path

import pytest

from host.errors import InputError, JobError
from sim.board import BoardOptions, Program, SocketPort, parse_board_url


@pytest.mark.parametrize(
    ("url", "options"),
    [
        ("sim:", BoardOptions()),
        ("sim:?", BoardOptions()),
        ("sim:?sim=icarus", BoardOptions(sim="icarus")),
        (
            "sim:?sim=verilator&clocks_per_bit=868&idle_clocks=0&trace=a%20b.vcd",
            BoardOptions("verilator", 868, 0, Path("a b.vcd")),
        ),
    ],
)
def test_url(url, options):
    assert parse_board_url(url) == options


@pytest.mark.parametrize(
    ("url", "sentence"),
    [
        (
            "model:",
            "A simulated board is given as sim: or sim:?sim=icarus, not 'model:'.",
        ),
        ("sim", "A simulated board is given as sim: or sim:?sim=icarus, not 'sim'."),
        (
            "sim://x",
            "A simulated board is given as sim: or sim:?sim=icarus, not 'sim://x'.",
        ),
        (
            "sim:?speed=9",
            "The simulated board has no option 'speed'; choose from sim, clocks_per_bit, "
            "idle_clocks, trace.",
        ),
        (
            "sim:?sim=icarus&sim=icarus",
            "Each option of the simulated board may be given once only, in "
            "'sim:?sim=icarus&sim=icarus'.",
        ),
        (
            "sim:?sim=vcs",
            "Option sim of the simulated board must be verilator or icarus, not 'vcs'.",
        ),
        (
            "sim:?clocks_per_bit=3",
            "Option clocks_per_bit of the simulated board must be an integer from 4 to 65535, "
            "not '3'.",
        ),
        (
            "sim:?clocks_per_bit=",
            "Option clocks_per_bit of the simulated board must be an integer from 4 to 65535, "
            "not ''.",
        ),
        (
            "sim:?idle_clocks=-1",
            "Option idle_clocks of the simulated board must be an integer from 0 to "
            "9223372036854775808, not '-1'.",
        ),
        ("sim:?trace=", "Option trace of the simulated board must be a file name, not ''."),
    ],
)
def test_refuses_bad_urls(url, sentence):
    with pytest.raises(InputError) as caught:
        parse_board_url(url)
    assert str(caught.value) == sentence


def test_command_of_verilator():
    program = Program("verilator", Path("/b/program"), 4, traced=True)
    assert program.command() == [
        "/b/program", "--clocks-per-bit", "4", "--listen", "127.0.0.1:0",
    ]  # fmt: skip
    assert program.command(pty=True, keep=True, idle_clocks=9, trace=Path("t.vcd")) == [
        "/b/program", "--clocks-per-bit", "4", "--pty", "--keep", "--idle-clocks", "9",
        "--trace", "t.vcd",
    ]  # fmt: skip


def test_command_without_waveform():
    with pytest.raises(InputError, match=r"^This simulator was built without waveforms; "):
        Program("verilator", Path("/b/program"), 4).command(trace=Path("t.vcd"))


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


def test_port_writes_more_than_buffers_hold(ends):
    port, peer = ends
    data = bytes(range(256)) * (1 << 14)  # 4 MiB.
    received = bytearray()

    def drain():
        while len(received) < len(data):
            received.extend(peer.recv(1 << 16))

    reader = threading.Thread(target=drain)
    reader.start()
    assert port.write(data) == len(data)
    reader.join()
    assert received == data


def test_port_write_times_out(ends):
    port, _ = ends
    port.write_timeout = 0.05
    with pytest.raises(JobError, match=r"^The board at socket://\S+ took no bytes for 0\.05 s\.$"):
        port.write(bytes(1 << 24))


def test_port_discards_input(ends):
    port, peer = ends
    peer.sendall(b"old")
    while port.in_waiting < 3:
        pass
    port.reset_input_buffer()
    peer.sendall(b"new")
    assert port.read(3) == b"new"


def test_port_reports_a_closed_peer(ends):
    port, peer = ends
    peer.close()
    with pytest.raises(
        JobError, match=r"^The board at socket://\S+ is gone: it closed the connection\.$"
    ):
        port.read()


def test_port_explains_a_closed_peer(far_end):
    with SocketPort(far_end.getsockname(), explain=lambda: "It is gone.") as port:
        far_end.accept()[0].close()
        with pytest.raises(JobError, match=r"^It is gone\.$"):
            port.read()


def test_port_reports_a_missing_peer(far_end):
    address = far_end.getsockname()
    far_end.close()
    with pytest.raises(JobError, match=rf"^No board answers at socket://127\.0\.0\.1:{address[1]}"):
        SocketPort(address)


def test_closed_port_is_closed(ends):
    port, _ = ends
    assert port.is_open
    port.close()
    port.close()
    assert not port.is_open
