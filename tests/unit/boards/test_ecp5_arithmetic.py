"""Maps for the arithmetic of an ECP5, proved with the cell's own description by Yosys."""

import json
from itertools import product

import pytest
from amaranth.back import verilog

from pathgene.hdl.boards.ecp5 import ARITHMETIC, PLANNER_OVERRIDES
from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.boards.tools import BuildError, run_tool
from pathgene.hdl.primitives.arithmetic import AddSubtract


#: Odd and even widths, factors with and without a sign, as wide as the result and shorter.
SIZES = list(product((7, 8, 9, 16), (0, 1), (3, 16)))


def prove(folder, maps, *, width, sign, first_width):
    """Prove that a mapped ``$alu`` equals the simple one, whatever comes into its first cell."""
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


def test_a_chain_has_no_cell_before_it(tmp_path):
    """Both kinds of sums take one chain; only its first bit feeds it."""
    text = verilog.convert(
        AddSubtract(8), name="chip", platform=Platform(), strip_internal_attrs=True
    )
    (tmp_path / "chip.v").write_text(text)
    script = "\n".join(
        [
            "read_verilog chip.v",
            PLANNER_OVERRIDES["script_after_read"],
            f"synth_ecp5 {PLANNER_OVERRIDES['synth_opts']} -top chip",
            PLANNER_OVERRIDES["script_after_synth"],
            "write_json chip.json",
        ]
    )
    (tmp_path / "chip.ys").write_text(script)
    run_tool("yosys", ["-q", "chip.ys"], tmp_path)
    cells = json.loads((tmp_path / "chip.json").read_text())["modules"]["chip"]["cells"].values()
    cells = [cell for cell in cells if cell["type"] != "$scopeinfo"]
    chain = [cell["connections"]["CIN"][0] for cell in cells if cell["type"] == "CCU2C"]
    # A bit to begin with, and eight; the last cell's other bit would be the carry out.
    assert len(chain) == 5
    assert chain.count("x") == 1
    assert len(cells) == len(chain)
