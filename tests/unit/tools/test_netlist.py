"""Netlists are equal up to names, and different where the circuit is."""

import subprocess
from pathlib import Path

import pytest

from tools.netlist import Netlist, main


DESIGN = """
module top(input clk, input [3:0] a, input [3:0] b, output [3:0] y);
    (* keep = 1 *) reg [3:0] held = 4'h3;
    wire [3:0] gap;
    less first(.left(a), .right(b), .gap(gap));
    reg [3:0] rows [0:7];
    reg [3:0] read;
    always @(posedge clk) begin
        held <= gap + 4'h5;
        rows[a[2:0]] <= b;
        read <= rows[b[2:0]];
    end
    assign y = held ^ read;
endmodule
module less(input [3:0] left, input [3:0] right, output [3:0] gap);
    assign gap = left - right;
endmodule
"""

RENAMED = """
module minus(output [3:0] z, input [3:0] x, input [3:0] y);
    assign z = x - y;
endmodule
module top(output [3:0] y, input [3:0] b, input [3:0] a, input clk);
    reg [3:0] memory [0:7];
    reg [3:0] out;
    wire [3:0] difference;
    (* keep = 1 *) reg [3:0] register = 4'h3;
    assign y = register ^ out;
    always @(posedge clk) register <= difference + 4'h5;
    always @(posedge clk) out <= memory[b[2:0]];
    always @(posedge clk) memory[a[2:0]] <= b;
    minus unit(.y(b), .x(a), .z(difference));
endmodule
"""

ALTERED = {
    "operator": ("gap + 4'h5", "gap - 4'h5"),
    "constant": ("gap + 4'h5", "gap + 4'h4"),
    "operand": ("left - right", "right - left"),
    "keep": ("(* keep = 1 *) ", ""),
    "initial value": ("held = 4'h3", "held = 4'h7"),
    "attribute of a memory": ("reg [3:0] rows", "(* no_rw_check = 1 *) reg [3:0] rows"),
    "address": ("rows[b[2:0]];", "rows[b[3:1]];"),
    "port": ("output [3:0] y);", "output [3:0] z); wire [3:0] y; assign z = y;"),
}


def netlist(folder, text):
    file = folder / "design.v"
    file.write_text(text)
    return Netlist.read(file, "top")


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    return netlist(tmp_path_factory.mktemp("original"), DESIGN)


def test_renamed_and_reordered(original, tmp_path):
    renamed = netlist(tmp_path, RENAMED)
    assert renamed.colours == original.colours
    assert renamed.digest == original.digest
    assert renamed.cells == original.cells == len(original.colour_of)
    assert renamed.colour_of["memory"] == original.colour_of["rows"]


@pytest.mark.parametrize(("old", "new"), ALTERED.values(), ids=ALTERED)
def test_altered(original, old, new, tmp_path):
    assert DESIGN.count(old) == 1
    altered = netlist(tmp_path, DESIGN.replace(old, new))
    assert altered.colours != original.colours
    assert altered.digest != original.digest


def test_ports_without_names(tmp_path):
    """Their directions, widths and wires still count."""
    file = tmp_path / "design.v"
    renamed = DESIGN.replace("output [3:0] y);", "output [3:0] z);").replace("assign y", "assign z")
    turned = DESIGN.replace(".left(a), .right(b)", ".left(b), .right(a)")
    digests = []
    for text in (DESIGN, renamed, turned):
        file.write_text(text)
        digests.append(Netlist.read(file, "top", port_names=False).digest)
    assert digests[0] == digests[1] != digests[2]


def test_site_of_an_instance(tmp_path):
    text = "(* blackbox *) module cell_(input a, output y); endmodule "
    text += 'module top(input a, output y); (* BEL = "X1" *) cell_ c(.a(a), .y(y)); endmodule'
    moved, unplaced = text.replace("X1", "X2"), text.replace('(* BEL = "X1" *) ', "")
    digests = {netlist(tmp_path, each).digest for each in (text, moved, unplaced)}
    assert len(digests) == 3


@pytest.mark.parametrize(
    ("text", "status", "told"),
    [
        (RENAMED, 0, "equal up to names"),
        (DESIGN.replace("left - right", "left + right"), 1, "different: "),
    ],
    ids=["renamed", "altered"],
)
def test_command(text, status, told, tmp_path, capsys):
    old, new = tmp_path / "old.v", tmp_path / "new.v"
    old.write_text(DESIGN)
    new.write_text(text)
    assert main([str(old), str(new), "--top", "top"]) == status
    assert told in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--since", "no-such"], "Git knows no revision 'no-such' here."),
        (["--since", "--all"], "Git knows no revision '--all' here."),
        (
            ["--since", "HEAD", "ulx3s"],
            "Board must be one of ulx3s-85f, ulx3s-45f, ecpix5-85f, icebreaker, arty-a7-100, "
            "not 'ulx3s'.",
        ),
    ],
)
def test_what_cannot_be_compared(arguments, sentence, capsys):
    if arguments[1] == "--all":
        arguments = ["--since=--all"]
    assert main(arguments) == 2
    assert capsys.readouterr().err == f"netlist: {sentence}\n"


@pytest.mark.long
def test_since_a_revision(capsys):
    """The status says what was found, which depends on the tree; no worktree is left."""
    root = Path(__file__).parents[3]
    listing = ["git", "-C", str(root), "worktree", "list"]
    known = subprocess.run(listing, capture_output=True, text=True, check=False)
    if known.returncode:
        pytest.skip("the sources are in no git repository")
    status = main(["--since", "HEAD", "icebreaker"])
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == "equal up to names" if status == 0 else last.startswith("different: ")
    after = subprocess.run(listing, capture_output=True, text=True, check=True)
    assert after.stdout == known.stdout
