"""examples/client.c, compiled here, with the model and the simulated board."""

import contextlib
import itertools
import shutil
import signal
import socket
import subprocess
import sys
import threading
import zlib
from pathlib import Path

import pytest

from hdl.protocol import DELIMITER, pack_paths
from host.device.boards import open_board
from sim.default_config import DEFAULT_CONFIG
from sim.model.chip import ChipModel
from tests.chips import SMALL, board_url


ROOT = Path(__file__).resolve().parents[2]

WARNINGS = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic")


@pytest.fixture(scope="session")
def client(tmp_path_factory):
    """Function that runs the client and returns its standard output."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("a C compiler is not installed (Debian package gcc)")
    program = tmp_path_factory.mktemp("client") / "client"
    source = ROOT / "examples" / "client.c"
    subprocess.run([compiler, *WARNINGS, "-o", program, source], check=True)

    def run(port, *arguments):
        command = [program, "127.0.0.1", str(port), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return run


def first_population(config):
    """Return the initial population defined in docs/protocol.md."""
    state = 1

    def draw(below):
        nonlocal state
        state = (1664525 * state + 1013904223) % (1 << 32)
        return (state >> 16) % below

    bits = config.coordinate_bits
    return [
        [
            draw(config.map_size)
            | draw(config.map_size) << bits
            | draw(config.blocked_altitude) << 2 * bits
            for _ in range(2 + draw(config.max_waypoints - 1))
        ]
        for _ in range(config.population)
    ]


def cost(config, path):
    """Return the cost of a path as defined in docs/protocol.md."""
    bits = config.coordinate_bits
    mask = (1 << bits) - 1
    points = [(word & mask, word >> bits & mask, word >> 2 * bits) for word in path]
    return sum(
        abs(a - b)
        for one, other in itertools.pairwise(points)
        for a, b in zip(one, other, strict=True)
    )


def expected_line(config):
    """Return the line that the client must print, from the same generations run by the host."""
    with open_board(board_url("model", config)) as chip:
        highest = config.map_size - 1
        chip.start(1, (highest, highest, config.blocked_altitude - 1))
        chip.load(first_population(config))
        for _ in range(5):
            costs = [cost(config, path) for path in chip.paths]
            chip.step(sorted(range(config.population), key=costs.__getitem__))
        packed = pack_paths(config, chip.read(0, config.population))
    return f"population CRC-32: {zlib.crc32(packed):08x}\n"


@contextlib.contextmanager
def served_model(config, damage=lambda number, frame: frame):
    """Serve the model at a port; ``damage`` alters frames, numbered in both directions together."""
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(30)
    frames = []

    def pass_on(data):
        passed = bytearray()
        for frame in data.split(bytes([DELIMITER]))[:-1]:
            if frame:
                frames.append(frame)
                passed += damage(len(frames), frame)
            passed.append(DELIMITER)
        return bytes(passed)

    def serve():
        model, begun = ChipModel(config), b""
        with listener.accept()[0] as line:
            while data := line.recv(4096):
                whole, delimiter, begun = (begun + data).rpartition(bytes([DELIMITER]))
                line.sendall(pass_on(model.feed(pass_on(whole + delimiter))))

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    with listener:
        yield listener.getsockname()[1], frames
        thread.join(10)
    assert not thread.is_alive()


@pytest.mark.parametrize("config", [SMALL, DEFAULT_CONFIG], ids=["small", "default"])
def test_with_the_model(client, config):
    with served_model(config) as (port, _):
        assert client(port) == expected_line(config)


def test_the_page_names_the_line_of_the_default_chip():
    page = (ROOT / "docs" / "protocol.md").read_text()
    assert f"`{expected_line(DEFAULT_CONFIG).strip()}`" in page


def test_over_a_bad_line(client):
    """Every fifth frame is lost or damaged; each command is still executed once."""

    def damage(number, frame):
        if number % 5:
            return frame
        at = number % len(frame)
        return b"" if number % 2 else frame[:at] + bytes([frame[at] ^ 0xFF or 1]) + frame[at + 1 :]

    with served_model(SMALL, damage) as (port, frames):
        assert client(port, "20") == expected_line(SMALL)
    # INFO, OPEN, START, WRITEs, generations and READs would take fewer if each were sent once.
    assert len(frames) > 2 * (3 + SMALL.population + 5 + SMALL.population) * 6 / 5


@pytest.mark.cosim
def test_with_the_simulated_board(client):
    command = ["board", "serve", "--board", "sim:", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(
        [sys.executable, "-m", "host", *command],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as server:
        try:
            url = server.stdout.readline().strip()
            assert client(url.rpartition(":")[2]) == expected_line(DEFAULT_CONFIG)
        finally:
            server.send_signal(signal.SIGINT)
