"""The constraints for plain Verilog name the pins and clocks of the board files."""

import re
from pathlib import Path

import pytest

from hdl.boards import BOARDS, find_board


ROOT = Path(__file__).parents[3] / "constraints"
SUFFIXES = {"ecp5": ".lpf", "ice40": ".pcf", "series7": ".xdc"}


def from_board(name):
    """Return pin and attributes of each port, and the clock in Hz, by the board's platform."""
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
    if file.suffix == ".pcf":  # Has no attributes: the Verilog's pads would need them.
        expected = {port: (pin, None) for port, (pin, _) in expected.items()}
    assert ports == expected
    assert clock_hz == reference_hz


def test_no_other_files():
    assert {file.stem for file in ROOT.iterdir()} == {*BOARDS, "README"}
