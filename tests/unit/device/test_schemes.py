"""Kinds of boards that other packages register."""

import sys
from importlib import metadata

import pytest

from pathgene.hdl.config import Config
from pathgene.host import entry_points
from pathgene.host.device.boards import board_scheme, known_config, open_board
from pathgene.host.device.schemes import GROUP, registered_scheme, scheme_names
from pathgene.host.device.serial_port import SerialScheme
from pathgene.host.errors import InputError, JobError
from pathgene.sim.board.scheme import SimulatedScheme
from pathgene.sim.model_scheme import ModelScheme
from tests.support.gateware.chips import SMALL
from tools.chips import board_url


PROBE = """
from pathgene.host.device.schemes import BoardScheme, OpenPort, split_config
from pathgene.hdl.config import Config
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.chip import ModelPort


class ProbeScheme(BoardScheme):
    simulated = True

    def known_config(self, url):
        return split_config(url, Config(clocks_per_bit=4))[1]

    def open(self, url):
        return OpenPort(ModelPort(Chip(self.known_config(url))), timeout_s=0.5, attempts=7)


SCHEME = ProbeScheme()
"""


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Function that installs a package with a module and the entry points of its boards."""

    def install_package(module, source, points):
        information = tmp_path / f"{module}-1.0.dist-info"
        information.mkdir()
        (information / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n"
        )
        (information / "entry_points.txt").write_text(f"[{GROUP}]\n{points}\n")
        (tmp_path / f"{module}.py").write_text(source)
        monkeypatch.syspath_prepend(tmp_path)

    yield install_package
    sys.modules.pop("probe_boards", None)


def test_finds_the_schemes_of_this_project():
    assert scheme_names() == ["model", "sim"]
    assert isinstance(board_scheme("model:?max_waypoints=20"), ModelScheme)
    assert isinstance(board_scheme("sim:"), SimulatedScheme)


@pytest.mark.parametrize("url", ["", "model", "/dev/ttyUSB0", "socket://localhost:5000", "loop://"])
def test_other_urls_are_those_of_serial_ports(url):
    assert registered_scheme(url) is None
    assert isinstance(board_scheme(url), SerialScheme)
    assert not board_scheme(url).simulated


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ('[project]\nname = "pathgene"\n', []),
        ('[project]\nname = "pathgene"\nentry-points."pathgene.boards".mine = "a:B"\n', ["mine"]),
        ('[project]\nname = "other"\nentry-points."pathgene.boards".mine = "a:B"\n', []),
        ("[tool.ruff]\n", []),
        (None, []),
    ],
)
def test_reads_the_project_file_of_its_checkout_alone(text, names, tmp_path, monkeypatch):
    installed = [point.name for point in metadata.entry_points(group=GROUP)]
    if text is not None:
        (tmp_path / "pyproject.toml").write_text(text)
    monkeypatch.setattr(entry_points, "__file__", str(tmp_path / "host" / "entry_points.py"))
    assert scheme_names() == list(dict.fromkeys([*names, *installed]))


def test_another_package_adds_a_kind_of_board(install):
    install("probe_boards", PROBE, "probe = probe_boards:SCHEME")
    assert scheme_names() == ["model", "sim", "probe"]
    url = board_url("probe", SMALL)
    assert known_config(url) == SMALL
    with open_board(url) as chip:
        assert chip.config == SMALL
        assert (chip.link.timeout_s, chip.link.attempts) == (0.5, 7)
        chip.load([[1, 2]] * 8)
        assert chip.step(range(8)).paths[0] == [1, 2]
    with pytest.raises(InputError, match=r"^Only a simulated board can be served, .* 'probe:'\.$"):
        board_scheme("probe:").serve("probe:", listen="127.0.0.1:0", pty=False)
    with pytest.raises(InputError, match=r"; give model:, sim:, probe:, a serial device or a URL "):
        open_board("/dev/no such device")


def test_another_package_cannot_replace_a_kind_of_this_project(install):
    install("probe_boards", PROBE, "model = probe_boards:SCHEME")
    assert scheme_names() == ["model", "sim"]
    assert known_config("model:") == Config(clocks_per_bit=4)
    assert isinstance(board_scheme("model:"), ModelScheme)


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("probe_boards:MISSING", "module 'probe_boards' has no attribute 'MISSING'"),
        ("no_such_boards:SCHEME", "No module named 'no_such_boards'"),
    ],
)
def test_reports_a_kind_of_board_that_cannot_be_loaded(install, value, reason):
    install("probe_boards", PROBE, f"probe = {value}")
    with pytest.raises(JobError) as caught:
        open_board("probe:")
    assert str(caught.value) == f"Boards of the scheme probe: cannot be loaded ({reason})."
