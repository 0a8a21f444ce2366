# amaranth: UnusedElaboratable=no
"""The ECP5's memory equals the simulated one in every cycle, and boards use it."""

import functools
import re
from types import SimpleNamespace

import pytest
from amaranth.back import verilog

from pathgene.hdl.boards.ecp5 import MAP_SITES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells, Ecp5Memory
from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.map_memory import MapMemory
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.hdl.primitives.storage import BlockMemory
from tests.support.gateware.ecp5_twins import ECP5, twins_of


def primitive():
    """Return a Verilog model of DP16KD, after its data sheet, for the options in use."""
    pins, behaviour = ["input CLKA, CLKB"], []
    for port in "AB":
        address = ", ".join(f"AD{port}{i}" for i in reversed(range(14)))
        given = ", ".join(f"DI{port}{i}" for i in reversed(range(18)))
        read = ", ".join(f"DO{port}{i}" for i in reversed(range(18)))
        chosen = ", ".join(f"CS{port}{i}" for i in range(3))
        pins += [
            f"input CE{port}, OCE{port}, RST{port}, WE{port}, {chosen}, {address}, {given}",
            f"output {read}",
        ]
        width = f"DATA_WIDTH_{port}"
        behaviour.append(f"""
            wire [13:0] address_{port} = {{{address}}};
            wire [17:0] given_{port} = {{{given}}};
            wire [13:0] row_{port} = address_{port} >> ({width} == 18 ? 4 : {width} == 9 ? 3
                : {width} == 4 ? 2 : {width} == 2 ? 1 : 0);
            reg [17:0] latch_{port}, register_{port};
            assign {{{read}}} = REGMODE_{port} == "OUTREG" ? register_{port} : latch_{port};
            always @(posedge CLK{port}) begin
                if (OCE{port}) register_{port} <= latch_{port};
                if (CE{port} && {{{chosen}}} == 0) begin
                    latch_{port} <= rows[row_{port}];
                    if (WE{port} && {width} == 18) begin
                        if (address_{port}[0]) rows[row_{port}][8:0] <= given_{port}[8:0];
                        if (address_{port}[1]) rows[row_{port}][17:9] <= given_{port}[17:9];
                    end else if (WE{port})
                        rows[row_{port}] <= given_{port} & ((1 << {width}) - 1);
                end
            end""")
    names = ["DATA_WIDTH", "REGMODE", "WRITEMODE", "CSDECODE"]
    parameters = [f"parameter {name}_{port} = 0" for port in "AB" for name in names]
    parameters += ["parameter RESETMODE = 0", "parameter GSR = 0"]
    return (
        f"module DP16KD #({', '.join(parameters)}) ({', '.join(pins)});\n"
        f"reg [17:0] rows [0:16383];\n{''.join(behaviour)}\nendmodule\n"
    )


BENCH = """
module bench;
    reg clk = 0, write = 0;
    reg [{bits}:0] address_a = 0, address_b = 0;
    reg [{top}:0] given = 0;
    wire [{top}:0] simulated_a, simulated_b, built_a, built_b;
    simulated first(.clk(clk), .rst(1'b0), .a__address(address_a), .a__write_enable(write),
        .a__write_data(given), .a__data(simulated_a){first_b});
    built second(.clk(clk), .rst(1'b0), .a__address(address_a), .a__write_enable(write),
        .a__write_data(given), .a__data(built_a){second_b});
    reg [1:0] written = 3;  // In the cycle of these addresses: what was read is undefined.
    integer cycle, seed = 7, differing = 0, seen = 0;
    initial begin
        for (cycle = 0; cycle < {rows} + 5000; cycle = cycle + 1) begin
            write = cycle < {rows} || $random(seed) % 8 == 0;
            address_a = cycle < {rows} ? cycle : $random(seed);
            address_b = $random(seed);
            given = $random(seed);
            #1 clk = 1;
            #1 clk = 0;
            if (!written[1]) begin
                if (simulated_a !== built_a || {differs_b}) differing = differing + 1;
                if (^built_a !== 1'bx && built_a != 0) seen = seen + 1;
            end
            written = {{written[0], write}};
        end
        $display("%0d differ, %0d seen", differing, seen);
    end
endmodule
"""


@pytest.mark.ci
@pytest.mark.parametrize(
    ("rows", "width", "ports"),
    [
        (16384, 3, 2),
        (8192, 3, 2),
        (4096, 12, 2),
        (4096, 9, 2),
        (2048, 12, 1),
        (1024, 20, 2),
        (64, 12, 1),
    ],
)
def test_equals_the_simulated_memory(rows, width, ports, tmp_path, icarus):
    bench = BENCH.format(
        rows=rows,
        bits=rows.bit_length() - 2,
        top=width - 1,
        first_b=", .b__address(address_b), .b__data(simulated_b)" if ports == 2 else "",
        second_b=", .b__address(address_b), .b__data(built_b)" if ports == 2 else "",
        differs_b="simulated_b !== built_b" if ports == 2 else "0",
    )
    make = functools.partial(BlockMemory, rows=rows, width=width, latency=2, ports=ports)
    simulated, built = twins_of(make, primitive(), bench, tmp_path)
    assert "DP16KD" in built
    assert "DP16KD" not in simulated


def test_registers_are_those_of_the_primitive():
    """A latency of 2 uses only the primitives' registers, a latency of 1 no primitive."""
    text = verilog.convert(
        MapMemory(rows=4096, width=12, latency=2, ports=2), platform=ECP5, emit_src=False
    )
    assert text.count("DP16KD") == 3
    assert text.count('.REGMODE_A("OUTREG")') == text.count('.REGMODE_B("OUTREG")') == 3
    assert "always @(posedge" not in text
    quick = MapMemory(rows=4096, width=12, latency=1, ports=2)
    assert "DP16KD" not in verilog.convert(quick, platform=ECP5, emit_src=False)


def test_halves_save_primitives():
    """Halves of other memories would take as many primitives, or more."""

    def count(rows, width):
        memory = Ecp5Memory(rows=rows, width=width, ports=2, sites=MAP_SITES)
        text = verilog.convert(memory, emit_src=False)
        sites = re.findall(r'BEL = "(.*?)"', text)
        assert sites == list(MAP_SITES[: text.count("DP16KD #")])
        assert len(sites) == Ecp5Memory.primitives(rows=rows, width=width)
        return len(sites), "lower" in text

    assert count(4096, 9) == (2, True)
    assert count(2048, 18) == (2, False)
    assert count(2048, 10) == (2, False)
    assert count(16384, 9) == (9, False)
    assert count(4096, 12) == (3, False)


def test_blocks_of_a_map_have_different_sites():
    """Four rows of a bit each get neighbouring sites; surplus blocks get none."""
    cells = Ecp5Cells(MAP_SITES)
    blocks = [
        cells.memory(rows=16384, width=4, ports=2, number=number) for number in (0, 1, 47, 48, None)
    ]
    found = [
        re.findall(r'\(\* BEL = "(.*?)" \*\)', verilog.convert(each, emit_src=False))
        for each in blocks
    ]
    assert found == [list(MAP_SITES[:4]), list(MAP_SITES[4:8]), list(MAP_SITES[188:]), [], []]


@pytest.mark.parametrize(
    "lanes",
    [
        pytest.param(8, marks=pytest.mark.ci),
        *(pytest.param(lanes, marks=pytest.mark.long) for lanes in (1, 16)),
    ],
)
def test_a_whole_map_has_all_sites(lanes):
    """The block RAMs of a bank are neighbours; other devices have other sites."""
    config = Config(lanes=lanes)
    sizes = (config.lanes, config.coordinate_bits, config.altitude_bits, config.memory_latency)
    memory = TerrainMemory(*sizes)
    sites = re.findall(r'BEL = "(.*?)"', verilog.convert(memory, platform=ECP5, emit_src=False))
    assert len(sites) == 192
    assert set(sites) == set(MAP_SITES)
    assert len(set(MAP_SITES)) == 192
    other = verilog.convert(
        TerrainMemory(*sizes), platform=SimpleNamespace(cells=Ecp5Cells()), emit_src=False
    )
    assert "DP16KD" in other
    assert "BEL" not in other
