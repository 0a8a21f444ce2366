"""examples/client.c and planner.c, compiled here, with the model and the simulated board."""

import contextlib
import dataclasses
import itertools
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import zlib
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.protocol.codec import DELIMITER
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.hdl.protocol.planner import NoFlyShape, ProblemRecord
from pathgene.hdl.protocol.runs import RunOptions, pack_best
from pathgene.host.device.boards import open_board
from pathgene.sim import DEFAULT_CONFIG
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import SMALL
from tests.support.host.processes import Started
from tools.chips import board_url


ROOT = Path(__file__).resolve().parents[2]

PLANNER = SMALL.replace(core="planner", checker="parallel", lanes=4)
PLANNER_DEFAULT = DEFAULT_CONFIG.replace(core="planner")
WARNINGS = ("-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic")


def compiled(tmp_path_factory, name):
    """Return a function that runs a client and returns its standard output."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("a C compiler is not installed (Debian package gcc)")
    program = tmp_path_factory.mktemp("client") / name
    source = ROOT / "examples" / f"{name}.c"
    subprocess.run([compiler, *WARNINGS, "-o", program, source], check=True)

    def run(port, *arguments):
        command = [program, "127.0.0.1", str(port), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return run


@pytest.fixture(scope="session")
def client(tmp_path_factory):
    return compiled(tmp_path_factory, "client")


@pytest.fixture(scope="session")
def planner(tmp_path_factory):
    return compiled(tmp_path_factory, "planner")


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


def problem(config):
    """Return the problem of docs/protocol.md."""
    edge, middle, altitude = config.map_size, config.map_size // 2, config.blocked_altitude // 2
    return ProblemRecord(
        start_x=edge // 8 << 8, start_y=middle << 8, start_altitude=altitude << 4,
        goal_x=edge - edge // 8 << 8, goal_y=middle << 8, goal_altitude=altitude << 4,
        x_limit=edge - 1, y_limit=edge - 1, altitude_limit=config.blocked_altitude - 1,
        x_scale=1 << 14, y_scale=1 << 14, rise=12_000, climb=12_000, descent=20_000, radius=512,
        base=0, drag=5_201, fuel=60_294, fuel_shift=13, key_shift=10,
        block_shift=max(config.coordinate_bits - 5, 0),
    )  # fmt: skip


def options(config):
    """Return the options of its first run."""
    return RunOptions(
        seed=1, cycles=1_000_000, generations=50, give_up_rank=config.population - 1,
        seeds=2 * config.population, slopes=(3, 0), lifts=2, share=8,
    )  # fmt: skip


def expected_paths(config):
    """Return the line that the planning client must print, from the same runs by the host."""
    edge, middle, radius = config.map_size, config.map_size // 2, config.map_size // 16
    low, high = middle - radius, middle + radius
    disc = NoFlyShape(
        first_x=low, first_y=low, last_x=high, last_y=high, bend_x=1, bend_y=1,
        edges=((-(radius**2), 2 * radius, 2 * radius),),
    )  # fmt: skip
    with open_board(board_url("model", config)) as chip:
        chip.update_map(np.zeros((edge, edge), dtype=np.int64))
        chip.runs.set_problem(problem(config))
        chip.runs.start(options(config))
        chip.runs.block(disc)
        chip.runs.start(dataclasses.replace(options(config), slopes=(3,), warm=True))
        best = chip.runs.best()
    assert len(best.paths) > 1
    return f"best paths CRC-32: {zlib.crc32(pack_best(config, best.paths, best.keys)):08x}\n"


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
        model, begun = Chip(config), b""
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


@pytest.mark.parametrize("config", [PLANNER, PLANNER_DEFAULT], ids=["small", "default"])
def test_plans_with_the_model(planner, config):
    with served_model(config) as (port, _):
        assert planner(port) == expected_paths(config)


@contextlib.contextmanager
def served(*command):
    """Serve a board by a command; yield its process and its port."""
    with Started(
        [sys.executable, "-m", "pathgene", *command],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as server:
        try:
            yield server.stdout.readline().strip()
        finally:
            server.send_signal(signal.SIGINT)


def test_plans_with_the_command_of_its_first_lines(planner):
    """The command in the example serves a board, which the example uses."""
    text = (ROOT / "examples" / "planner.c").read_text()
    command = re.search(r"pathgene (board serve .*)", text)[1].split()
    command[command.index("--listen") + 1] = "127.0.0.1:0"
    with served(*command) as url:
        for _ in range(2):  # One client after another.
            assert planner(url.rpartition(":")[2]) == expected_paths(PLANNER_DEFAULT)


def test_the_page_names_the_lines_of_the_default_chips():
    page = (ROOT / "docs" / "protocol.md").read_text()
    assert f"`{expected_line(DEFAULT_CONFIG).strip()}`" in page
    assert f"`{expected_paths(PLANNER_DEFAULT).strip()}`" in page


def test_over_a_bad_line(client):
    """Every fifth frame is lost or damaged; each command is still executed once."""

    def damage(number, frame):
        if number % 5:
            return frame
        at = number % len(frame)
        return b"" if number % 2 else frame[:at] + bytes([frame[at] ^ 0xFF or 1]) + frame[at + 1 :]

    with served_model(SMALL, damage) as (port, frames):
        assert client(port, "20") == expected_line(SMALL)
    # INFO, OPEN, START, WRITEs, generations and READs would take fewer frames if each were sent
    # once.
    assert len(frames) > 2 * (3 + SMALL.population + 5 + SMALL.population) * 6 / 5


def test_plans_over_a_bad_line(planner):
    """Every fourth frame is lost, so that commands are repeated, including a RUN."""

    def damage(number, frame):
        return frame if number % 4 else b""

    with served_model(PLANNER, damage) as (port, _):
        assert planner(port, "20") == expected_paths(PLANNER)


def leave_a_run(url):
    """Start a run that takes minutes, and disconnect."""
    with open_board(url) as chip:
        edge = chip.config.map_size
        chip.update_map(np.zeros((edge, edge), dtype=np.int64))
        chip.runs.set_problem(problem(chip.config))
        chip.runs.start(dataclasses.replace(options(chip.config), cycles=10**9, generations=10**6))
        assert chip.runs.status().running


@pytest.mark.ci
@pytest.mark.cosim
@pytest.mark.parametrize(
    ("program", "config", "expected"),
    [
        pytest.param("client", DEFAULT_CONFIG, expected_line, id="client"),
        pytest.param("planner", PLANNER, expected_paths, id="planner", marks=pytest.mark.ci),
    ],
)
def test_with_the_simulated_board(request, program, config, expected):
    client, board = request.getfixturevalue(program), board_url("sim", config)
    with served("board", "serve", "--board", board, "--listen", "127.0.0.1:0") as url:
        if program == "planner":
            leave_a_run(url)
        assert client(url.rpartition(":")[2]) == expected(config)
