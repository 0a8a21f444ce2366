"""Every board: its chip, its PLL, the sources for its tools, the constraints for plain Verilog."""

import dataclasses
import re
from pathlib import Path

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.boards import BOARDS, board_top, chips_of, find_board
from pathgene.hdl.boards.board import Board, ChipKind
from pathgene.hdl.boards.build import prepare
from pathgene.hdl.boards.pll import Ecp5Pll, Ice40Pll, Series7Pll
from pathgene.hdl.config import CheckerBuild, Config, GeneticCore


#: Every board with each of its chips.
CHIPS = [(board.name, board.chip) for name in BOARDS for board in chips_of(name)]

#: Text about the device in the sources.
DEVICES = {
    "ulx3s-85f": ["--85k", "--package", "CABGA381", "--speed", "6"],
    "ulx3s-45f": ["--45k", "--package", "CABGA381", "--speed", "6"],
    "ecpix5-85f": ["--um5g-85k", "--package", "CABGA554", "--speed", "8"],
    "icebreaker": ["--up5k", "--package", "sg48"],
}


class Wire(wiring.Component):
    """Replacement for the planner, which takes long to elaborate; it uses clock and reset."""

    clk: In(1)
    rst: In(1)
    rx: In(1)
    tx: Out(1)

    def __init__(self, config):
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain()
        m.d.comb += [ClockSignal().eq(self.clk), ResetSignal().eq(self.rst)]
        m.d.sync += self.tx.eq(self.rx)
        return m


@pytest.mark.parametrize(("name", "kind"), CHIPS)
def test_clock_and_divisor(name, kind):
    board = find_board(name, kind)
    assert (board.name, board.chip) == (name, kind)
    config = board.config
    assert config.clock_hz == board.clock_hz
    assert abs(config.clock_hz / config.clocks_per_bit / board.baud - 1) < 0.0125
    assert config.replace(clock_hz=100_000_000, clocks_per_bit=33) == board.sizes


@pytest.mark.parametrize("name", ["ulx3s-85f", "ecpix5-85f"])
def test_full_design(name):
    config = find_board(name, "paper").config
    assert (config.checker, config.map_size, config.altitude_bits) == (
        CheckerBuild.PARALLEL,
        512,
        12,
    )
    assert config.lanes >= 8
    assert config.clock_hz >= 100_000_000
    # A block of 1,024 x 18 bits holds 4,096 x 4 bits: 192 of the 208 blocks of an 85F.
    banks = (config.lanes // 2) ** 2
    rows = config.map_size**2 // banks
    assert banks * (rows // 4096) * (config.altitude_bits // 4) == 192


@pytest.mark.parametrize(
    ("name", "lanes", "map_size", "clock_hz"),
    [
        ("ulx3s-85f", 8, 512, 100_000_000),
        ("ulx3s-45f", 4, 256, 80_000_000),
        ("ecpix5-85f", 16, 512, 110_000_000),
    ],
)
def test_planners(name, lanes, map_size, clock_hz):
    config = find_board(name).config
    assert config.core is GeneticCore.PLANNER
    assert (config.lanes, config.map_size) == (lanes, map_size)
    assert config.clock_hz >= clock_hz


@pytest.mark.parametrize("name", BOARDS)
def test_default_chip_is_the_planner_where_there_is_room(name):
    kinds = [board.chip for board in chips_of(name)]
    has_a_core = find_board(name, ChipKind.PAPER).sizes.core is not GeneticCore.NONE
    assert kinds == (list(ChipKind) if has_a_core else [ChipKind.PAPER])


@pytest.mark.parametrize("name", BOARDS)
def test_page_has_a_row_with_the_sizes_of_each_chip(name):
    page = (Path(__file__).parents[3] / "docs" / "boards.md").read_text("utf-8")
    (row,) = re.findall(rf"^\| `{name}` \|(.*)\|$", page, re.MULTILINE)
    device, planner, paper, _ = (cell.strip() for cell in row.split(" | "))
    platform = find_board(name).platform()
    assert device.replace(" ", "").startswith((platform.device, "XC7A100T"))
    chips = {board.chip: board.config for board in chips_of(name)}
    for cell, config in ((planner, chips.get("planner")), (paper, chips["paper"])):
        if config is None:
            assert cell == "none"
            continue
        assert f"map of {config.map_size} x {config.map_size}" in cell
        if config.core is not GeneticCore.NONE:
            assert f"{config.lanes} lanes" in cell
        if name in DEVICES:
            assert f"; {config.clock_hz / 1e6:g} MHz" in cell


def test_refuses_a_chip_without_room():
    with pytest.raises(
        ValueError,
        match=r"^Chip of icebreaker must be paper, for which it has room, not planner$",
    ):
        find_board("icebreaker", "planner")


@pytest.mark.parametrize(("name", "kind"), CHIPS)
def test_sources(name, kind, tmp_path, monkeypatch):
    monkeypatch.setattr(board_top, "Chip", Wire)
    board = find_board(name, kind)
    commands = prepare(board, tmp_path)
    if name not in DEVICES:
        assert commands == [["vivado", "-mode", "batch", "-log", "chip.log", "-source", "chip.tcl"]]
        assert "-part xc7a100ticsg324-1L" in (tmp_path / "chip.tcl").read_text()
    else:
        synthesis, routing, *_ = commands
        assert synthesis == ["yosys", "-q", "-l", "chip.rpt", "chip.ys"]
        assert routing[0].startswith("nextpnr-")
        assert " ".join(DEVICES[name]) in " ".join(routing)
        assert "read_verilog chip.v\n" in (tmp_path / "chip.ys").read_text()
    netlist = (tmp_path / "chip.v").read_text()
    pll = {Ecp5Pll: "EHXPLLL", Ice40Pll: "SB_PLL40_PAD", Series7Pll: "PLLE2_BASE"}
    assert netlist.count(f" {pll[type(board.pll)]} #(") == 1


def test_refuses_an_unknown_board():
    names = ", ".join(BOARDS)
    with pytest.raises(ValueError, match=rf"^Board must be one of {names}, not 'ulx3s'$"):
        find_board("ulx3s")


def test_refuses_an_inexact_divisor():
    board = find_board("ulx3s-85f")
    with pytest.raises(
        ValueError,
        match=r"^Board.baud must divide the clock of 100000000 Hz within 1.25%, not 12000000$",
    ):
        dataclasses.replace(board, baud=12_000_000)
    assert isinstance(dataclasses.replace(board, baud=1_000_000), Board)


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
