"""The list of planners, and the default one: the board has the core for it."""

import contextlib
import socket
import subprocess
import sys
import threading

import pytest

from pathgene.hdl.config import Config
from pathgene.host.device.boards import open_board
from pathgene.host.errors import InputError
from pathgene.host.mission.build import planner_of
from pathgene.host.options.table import OWN
from pathgene.host.planners import DEFAULT, PLANNERS, default_planner, make, named_or_default
from pathgene.host.planning import Search
from pathgene.sim.model.chip import Chip


def test_every_planner_is_made_and_described():
    assert DEFAULT == next(iter(PLANNERS)) == "ga-chip"
    for name, entry in PLANNERS.items():
        assert callable(make(name).plan)
        assert entry.description
        assert entry.paper


def test_own_options_reach_the_planner():
    assert make("ga-pc", max_waypoints=7).max_waypoints == 7
    assert make("ga-fpga", board="sim:", link_mode="recipe").board == "sim:"


def test_unknown_planner():
    with pytest.raises(InputError) as caught:
        make("a-star")
    assert str(caught.value) == (
        "There is no planner 'a-star' (did you mean astar?); the planners are "
        f"{', '.join(PLANNERS)}."
    )


def test_importing_the_list_loads_nothing_heavy():
    heavy = """
import sys, pathgene.host.planners, pathgene.host.cli
print([m for m in ("numpy", "scipy", "numba", "matplotlib", "rasterio", "amaranth", "serial")
       if m in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", heavy], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


CORES = {"planner": "ga-chip", "paper": "ga-fpga", "none": "ga-chip"}


@pytest.fixture
def served():
    """Function that serves a chip on a socket, one client after another; returns its URL."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def run(chip):
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = server.accept()
                    with connection, contextlib.suppress(OSError):
                        while data := connection.recv(4096):
                            connection.sendall(chip.feed(data))

        def start(core):
            chip = Chip(Config(core=core))
            thread = threading.Thread(target=run, args=(chip,), daemon=True)
            thread.start()
            return f"socket://127.0.0.1:{server.getsockname()[1]}"

        yield start
        server.shutdown(socket.SHUT_RDWR)


def test_without_a_board_the_planner_is_the_first_of_the_registry():
    assert default_planner() == DEFAULT == next(iter(PLANNERS)) == "ga-chip"


@pytest.mark.parametrize("scheme", ["model:", "sim:"])
@pytest.mark.parametrize(
    ("query", "planner"),
    [
        ("", "ga-chip"),
        ("max_waypoints=20", "ga-chip"),
        ("core=planner", "ga-chip"),
        ("core=paper", "ga-fpga"),
        ("core=none", "ga-chip"),
        # Words of earlier releases.
        ("genetic=streaming", "ga-chip"),
        ("genetic=parallel", "ga-fpga"),
        ("genetic=1", "ga-fpga"),
        ("genetic=0", "ga-chip"),
        # Sizes that only the paper core has.
        ("population=64", "ga-fpga"),
        ("checker=two-tier&lanes=1", "ga-fpga"),
        # Sizes that neither core has.
        ("population=3", "ga-fpga"),
    ],
)
def test_the_url_of_a_simulated_board_decides(scheme, query, planner):
    assert default_planner(f"{scheme}?{query}" if query else scheme) == planner


@pytest.mark.parametrize(("core", "planner"), CORES.items())
def test_an_open_board_has_its_own(core, planner):
    with open_board(f"model:?core={core}") as board:
        assert default_planner(board) == planner
        assert named_or_default(None, {"board": board}) == planner
    assert default_planner(board) == planner


@pytest.mark.parametrize(("core", "planner"), CORES.items())
def test_hardware_is_asked(served, core, planner):
    url = served(core)
    assert default_planner(url) == planner
    search = Search(board=url)
    assert (search.planner, search.board) == (planner, url)


def test_hardware_that_does_not_answer():
    for url in ("/dev/no such device", ""):
        with pytest.raises(InputError, match=r"^No board can be opened at "):
            default_planner(url)
    with pytest.raises(InputError, match=r"^The board must be a URL, not 3\.$"):
        Search(board=3)


def test_a_named_planner_is_taken():
    assert named_or_default("astar", {"board": "/dev/no such device"}) == "astar"
    assert planner_of({"planner": "ga-pc", "link_mode": "rank"}) == "ga-pc"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            {"link_mode": "recipe"},
            r"^The default planner, ga-chip, has no option link_mode \(--link-mode\); name a "
            r"planner that has it \(--planner\): ga-fpga\.$",
        ),
        ({"init": "astar"}, r"has no option init \(--init\); .*: ga-fpga, ga-pc, fpa, fpa-2opt, "),
        (
            {"board": "model:?core=paper", "chip_ms": 5},
            r"^The default planner of this board, ga-fpga, has no option chip_ms \(--chip-ms\); "
            r"name a planner that has it \(--planner\): ga-chip\.$",
        ),
    ],
)
def test_options_that_the_default_planner_lacks(options, sentence):
    values = dict.fromkeys(OWN) | options
    for call in (lambda: named_or_default(None, values), lambda: Search(**options)):
        with pytest.raises(InputError, match=sentence):
            call()
    with pytest.raises(InputError, match=sentence):
        planner_of(values)
