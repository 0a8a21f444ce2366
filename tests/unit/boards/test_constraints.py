"""The constraints for plain Verilog name the pins and clocks of the board files."""

import re
from pathlib import Path

import pytest

from pathgene.hdl.boards import BOARDS, chips_of, find_board
from pathgene.hdl.config import Config


ROOT = Path(__file__).parents[3] / "constraints"
SUFFIXES = {"ecp5": ".lpf", "ice40": ".pcf", "series7": ".xdc"}


def from_board(name):
    """Return pin and attributes of each port, and the clock in Hz, from the board's platform."""
    board = find_board(name)
    platform = board.platform()
    ports = {}
    resources = {
        "clk": (platform.default_clk, 0),
        "rst": board.reset,
        "rx": ("uart", 0),
        "tx": ("uart", 0),
    }
    for port, resource in resources.items():
        (io,) = (
            [
                io
                for io in platform.lookup(*resource).ios
                if resource[0] != "uart" or io.name == port
            ]
            if resource[0] == "uart"
            else [platform.lookup(*resource).ios[0]]
        )
        owner = io if resource[0] == "uart" else platform.lookup(*resource)
        pins = io.ios[0] if resource[0] == "uart" else io
        attrs = {**platform.lookup(*resource).attrs, **owner.attrs}
        assert not pins.invert, "a plain port is active when high"
        (pin,) = pins.map_names(platform._conn_pins, platform.lookup(*resource))
        ports[port] = (pin, attrs)
    return ports, board.reference_hz


def from_lpf(text):
    ports = {}
    for port, site in re.findall(r'^LOCATE COMP "(\w+)" SITE "(\w+)";$', text, re.M):
        (attributes,) = re.findall(rf'^IOBUF PORT "{port}" (.*);$', text, re.M)
        ports[port] = (site, dict(each.split("=") for each in attributes.split()))
    ((clock, mhz),) = re.findall(r'^FREQUENCY PORT "(\w+)" (\d+) MHZ;$', text, re.M)
    assert clock == "clk"
    return ports, int(mhz) * 1_000_000


def from_pcf(text):
    ports = {port: (pin, None) for port, pin in re.findall(r"^set_io (\w+) (\w+)$", text, re.M)}
    (mhz,) = re.findall(r"^set_frequency clk (\d+)$", text, re.M)
    return ports, int(mhz) * 1_000_000


def from_xdc(text):
    ports = {}
    for site, port in re.findall(r'^set_property LOC (\w+) \[get_ports "(\w+)"\]$', text, re.M):
        attributes = re.findall(
            rf'^set_property (?!LOC)(\w+) "(\w+)" \[get_ports "{port}"\]$', text, re.M
        )
        ports[port] = (site, dict(attributes))
    (ns,) = re.findall(r'^create_clock -name clk -period (\d+) \[get_ports "clk"\]$', text, re.M)
    return ports, 1_000_000_000 // int(ns)


@pytest.mark.parametrize("name", BOARDS)
def test_pins_and_clock(name):
    (file,) = ROOT.glob(f"{name}.*")
    ports, clock_hz = {".lpf": from_lpf, ".pcf": from_pcf, ".xdc": from_xdc}[file.suffix](
        file.read_text(encoding="utf-8")
    )
    expected, reference_hz = from_board(name)
    if file.suffix == ".pcf":  # The format has no attributes; the Verilog's pads carry them.
        expected = {port: (pin, None) for port, (pin, _) in expected.items()}
    assert ports == expected
    assert clock_hz == reference_hz


@pytest.mark.parametrize("name", BOARDS)
def test_commands_in_the_header_make_verilog_for_the_board(name):
    (file,) = ROOT.glob(f"{name}.*")
    header = " ".join(
        line.removeprefix("#").strip()
        for line in file.read_text(encoding="utf-8").splitlines()
        if line.startswith("#")
    )
    _, *commands = header.split("pathgene verilog --top chip")
    for command, board in zip(commands, chips_of(name), strict=True):
        options = dict(re.findall(r"--set (\w+)=(\S+)", command))
        config = Config().replace(
            **{name: int(value) if value.isdigit() else value for name, value in options.items()}
        )
        line = {name: getattr(config, name) for name in ("clock_hz", "clocks_per_bit")}
        assert config == board.sizes.replace(**line)
        assert config.clock_hz == board.reference_hz
        (baud_m,) = re.findall(r"\((\d+) Mbaud\)", command)
        assert config.clock_hz / config.clocks_per_bit == pytest.approx(int(baud_m) * 1e6, rel=0.02)


def test_every_file_belongs_to_a_board():
    assert {file.stem for file in ROOT.iterdir()} == {*BOARDS, "README"}
