"""Cells of the ECP5 equal the primitives in every cycle; Yosys proves the maps for arithmetic."""

import functools
import json
import re
import subprocess
from itertools import product
from types import SimpleNamespace

import pytest
from amaranth.back import verilog

from pathgene.hdl.boards.ecp5 import ARITHMETIC, MAP_SITES, PLANNER_OVERRIDES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells, Ecp5Memory
from pathgene.hdl.boards.tools import BuildError, run_tool
from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.hdl.primitives.arithmetic import AddSubtract, Multiplier
from pathgene.hdl.primitives.storage import BlockMemory, MapMemory


#: The part of an LFE5U-85F's platform that components use.
ECP5 = SimpleNamespace(cells=Ecp5Cells(MAP_SITES))


def twins_of(make, primitive, bench, folder):
    """Assert that both versions of a component have the same outputs in every cycle of a bench.

    Parameters
    ----------
    make : callable
        Returns the component.
    primitive, bench : str
        Verilog modules. ``bench`` instantiates ``simulated`` and ``built`` and prints how many of
        their outputs differ and how many it compared.
    folder : Path

    Returns
    -------
    simulated, built : str
        Verilog of the component.
    """
    simulated = verilog.convert(make(), name="simulated", emit_src=False)
    built = verilog.convert(make(), name="built", platform=ECP5, emit_src=False)
    sources = {"simulated": simulated, "built": built, "primitive": primitive, "bench": bench}
    files = [folder / f"{name}.v" for name in sources]
    for file, text in zip(files, sources.values(), strict=True):
        file.write_text(text)
    program = folder / "bench"
    subprocess.run(["iverilog", "-g2012", "-s", "bench", "-o", program, *files], check=True)
    output = subprocess.run(["vvp", program], check=True, capture_output=True, text=True).stdout
    differing, seen = map(int, re.search(r"(\d+) differ, (\d+) seen", output).groups())
    assert differing == 0
    assert seen > 2000
    return simulated, built


#: Odd and even widths, factors with and without a sign, as wide as the result and shorter.
SIZES = list(product((7, 8, 9, 16), (0, 1), (3, 16)))


def prove(folder, maps, *, width, sign, first_width):
    """Prove that a mapped ``$alu`` equals the simple one, whatever enters its first cell."""
    first_width = min(first_width, width)
    (folder / "maps.v").write_text(maps)
    (folder / "alu.v").write_text(
        f"module simple(input [{first_width - 1}:0] A, input [{width - 1}:0] B, input CI, BI,"
        f" output [{width - 1}:0] X, Y, CO);"
        f"\\$alu #(.A_SIGNED({sign}), .B_SIGNED({sign}), .A_WIDTH({first_width}),"
        f" .B_WIDTH({width}), .Y_WIDTH({width})) alu (.A, .B, .CI, .BI, .X, .Y, .CO);"
        " endmodule"
    )
    script = [
        "read_verilog -sv -icells alu.v; copy simple mapped; design -stash both",
        "design -copy-from both mapped; techmap -map maps.v t:$alu",
        "select -assert-none t:$alu",
        "read_verilog -nooverwrite +/lattice/cells_sim_ecp5.v; hierarchy -top mapped; proc",
        "flatten; setundef -undriven -anyconst; opt_clean; select -assert-any t:$anyconst",
        "design -stash flat; design -copy-from both simple; design -copy-from flat mapped",
        "miter -equiv -flatten -make_assert simple mapped proof",
        "sat -verify -prove-asserts proof",
    ]
    run_tool("yosys", ["-q", "-p", "; ".join(script)], folder)


@pytest.mark.ci
@pytest.mark.parametrize(("width", "sign", "first_width"), SIZES)
def test_a_chain_is_the_sum(width, sign, first_width, tmp_path):
    prove(tmp_path, ARITHMETIC.read_text(), width=width, sign=sign, first_width=first_width)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("{A_buf, CI}", "{A_buf, 1'b0}"), ("sum[i+2]", "sum[i+1]"), ("carry[i/2+1]", "carry[i/2]")],
)
def test_a_wrong_chain_is_noticed(right, wrong, tmp_path):
    maps = ARITHMETIC.read_text()
    assert right in maps
    with pytest.raises(BuildError):
        prove(tmp_path, maps.replace(right, wrong), width=8, sign=0, first_width=8)


class Platform:
    """A platform of the family."""

    cells = Ecp5Cells()


def synthesized(text, folder):
    """Return the cells of the module ``chip`` after the synthesis of the boards."""
    (folder / "chip.v").write_text(text)
    script = "\n".join(
        [
            "read_verilog chip.v",
            PLANNER_OVERRIDES["script_after_read"],
            f"synth_ecp5 {PLANNER_OVERRIDES['synth_opts']} -top chip",
            PLANNER_OVERRIDES["script_after_synth"],
            "write_json chip.json",
        ]
    )
    (folder / "chip.ys").write_text(script)
    run_tool("yosys", ["-q", "chip.ys"], folder)
    cells = json.loads((folder / "chip.json").read_text())["modules"]["chip"]["cells"].values()
    return [cell for cell in cells if cell["type"] != "$scopeinfo"]


def test_a_chain_has_no_cell_before_it(tmp_path):
    """Both kinds of sums take one chain, which only the first bit feeds."""
    text = verilog.convert(
        AddSubtract(8), name="chip", platform=Platform(), strip_internal_attrs=True
    )
    cells = synthesized(text, tmp_path)
    chain = [cell["connections"]["CIN"][0] for cell in cells if cell["type"] == "CCU2C"]
    # One bit to begin with, and eight; the second bit of the last cell would be the carry out.
    assert len(chain) == 5
    assert chain.count("x") == 1
    assert len(cells) == len(chain)


def test_a_chain_of_yosys_keeps_its_carry_in(tmp_path):
    """Sums of 5 and 6 bits take Yosys's own chains, whose first bits are the operands'."""
    text = "module chip(input [4:0] a, b, output [4:0] y); assign y = a + b; endmodule\n"
    chain = [cell["connections"] for cell in synthesized(text, tmp_path) if cell["type"] == "CCU2C"]
    firsts = [pins for pins in chain if isinstance(pins["CIN"][0], str)]
    assert [pins["CIN"] for pins in firsts] == [["0"]]
    assert firsts[0]["A0"] != firsts[0]["B0"]


def multiplier():
    """Return a Verilog model of MULT18X18D, following its data sheet, for the options in use."""
    first, second, third = (
        ", ".join(f"{name}{i}" for i in reversed(range(18))) for name in ("A", "B", "C")
    )
    product = ", ".join(f"P{i}" for i in reversed(range(36)))
    names = ["INPUTA_CLK", "INPUTB_CLK", "INPUTC_CLK", "PIPELINE_CLK"]
    names += ["OUTPUT_CLK", "OUTPUT_CE", "OUTPUT_RST"]
    parameters = [f"parameter REG_{name} = 0" for name in names]
    parameters += [
        f"parameter {name} = 0" for name in ("SOURCEB_MODE", "MULT_BYPASS", "RESETMODE", "GSR")
    ]
    return f"""
        module MULT18X18D #({", ".join(parameters)}) (
            input CLK0, CE0, RST0, SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
            input {first}, {second}, {third}, output {product});
            wire signed [18:0] first = {{SIGNEDA & A17, {first}}};
            wire signed [18:0] second = {{SIGNEDB & B17, {second}}};
            wire [35:0] now = first * second;
            reg [35:0] then;
            wire plain = REG_INPUTA_CLK == "NONE" && REG_INPUTB_CLK == "NONE"
                && REG_PIPELINE_CLK == "NONE" && MULT_BYPASS == "DISABLED" && !SOURCEA && !SOURCEB;
            assign {{{product}}} = !plain ? 36'bx : REG_OUTPUT_CLK == "CLK0" ? then : now;
            always @(posedge CLK0) if (RST0) then <= 0; else if (CE0) then <= now;
        endmodule
        """


MULTIPLIER_BENCH = """
module bench;
    reg clk = 0;
    reg [{first}:0] first = 0;
    reg [{second}:0] second = 0;
    wire [{top}:0] simulated, built;
    simulated one(.clk(clk), .rst(1'b0), .first(first), .second(second), .product(simulated));
    built other(.clk(clk), .rst(1'b0), .first(first), .second(second), .product(built));
    integer cycle, seed = 7, differing = 0, seen = 0;
    initial begin
        for (cycle = 0; cycle < 5000; cycle = cycle + 1) begin
            first = cycle % 3 ? $random(seed) : cycle % 2 ? 0 : {{(1 + {first}){{1'b1}}}};
            second = cycle % 5 ? $random(seed) : {{1'b1, {second}'b0}};
            #1 clk = 1;
            #1 clk = 0;
            #1 if (simulated !== built) differing = differing + 1;
            if (^built !== 1'bx && built != 0) seen = seen + 1;
        end
        $display("%0d differ, %0d seen", differing, seen);
    end
endmodule
"""


@pytest.mark.parametrize(
    ("bits", "shift", "signs"),
    [
        ((13, 18), 17, (True, True)),
        ((16, 16), 0, (True, True)),
        ((18, 18), 5, (True, True)),
        ((18, 18), 0, (False, False)),
        ((18, 18), 0, (True, False)),
        ((17, 18), 1, (False, True)),
    ],
)
def test_equals_the_simulated_product(bits, shift, signs, tmp_path, icarus):
    bench = MULTIPLIER_BENCH.format(
        first=bits[0] - 1, second=bits[1] - 1, top=sum(bits) - shift - 1
    )
    simulated, built = twins_of(
        lambda: Multiplier(bits, shift, signs), multiplier(), bench, tmp_path
    )
    assert built.count("MULT18X18D") == 1
    assert "always @(posedge" not in built
    assert "MULT18X18D" not in simulated


@pytest.mark.parametrize("bits", [(13, 19), (18, 3)], ids=["wide", "narrow"])
def test_other_factors_use_the_generic_product(bits):
    built = verilog.convert(Multiplier(bits), platform=ECP5, emit_src=False)
    assert built == verilog.convert(Multiplier(bits), emit_src=False)
    assert "MULT18X18D" not in built


def memory_primitive():
    """Return a Verilog model of DP16KD, following its data sheet, for the options in use."""
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


MEMORY_BENCH = """
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
    bench = MEMORY_BENCH.format(
        rows=rows,
        bits=rows.bit_length() - 2,
        top=width - 1,
        first_b=", .b__address(address_b), .b__data(simulated_b)" if ports == 2 else "",
        second_b=", .b__address(address_b), .b__data(built_b)" if ports == 2 else "",
        differs_b="simulated_b !== built_b" if ports == 2 else "0",
    )
    make = functools.partial(BlockMemory, rows=rows, width=width, latency=2, ports=ports)
    simulated, built = twins_of(make, memory_primitive(), bench, tmp_path)
    assert "DP16KD" in built
    assert "DP16KD" not in simulated


def test_registers_are_those_of_the_primitive():
    """A latency of 2 only uses the primitives' registers; a latency of 1 uses no primitive."""
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
