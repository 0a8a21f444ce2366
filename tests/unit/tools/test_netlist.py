"""Netlists are equal apart from names, and differ if the circuit differs."""

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


#: Two memories; the first has two reads and three writes, of which the second prevails over the
#: first.
MEMORIES = """
module top(input clk, w, v, input [2:0] a, b, c, input [3:0] d, e, output reg [3:0] x, y, z);
    reg [3:0] near [0:7];
    reg [3:0] far [0:7];
    initial begin
        near[0] = 4'h3;
        near[5] = 4'h6;
        near[0] = 4'h9;
        far[0] = 4'h9;
        far[5] = 4'h6;
    end
    always @(posedge clk) begin
        if (w) near[a] <= d;
        if (v) near[b] <= e;
        if (v) far[c] <= d;
    end
    always @(posedge clk) if (w) near[c] <= e;
    always @(posedge clk) x <= near[a];
    always @(posedge clk) y <= near[b];
    always @(posedge clk) z <= far[c];
endmodule
"""

MEMORIES_RENAMED = """
module top(input clk, w, v, input [2:0] a, b, c, input [3:0] d, e, output [3:0] x, y, z);
    reg [3:0] bow [0:7];
    reg [3:0] p, q;
    assign x = q, y = p;
    always @(posedge clk) p <= bow[b];
    always @(posedge clk) q <= bow[a];
    always @(posedge clk) if (w) bow[c] <= e;
    always @(posedge clk) begin
        if (w) bow[a] <= d;
        if (v) bow[b] <= e;
    end
    initial bow[5] = 4'h6;
    initial bow[0][1:0] = 2'h1;
    initial bow[0][3:2] = 2'h2;
    initial bow[7] = 4'hx;
    bank aft(.clk(clk), .write(v), .at(c), .data(d), .read(z));
endmodule
module bank(input clk, write, input [2:0] at, input [3:0] data, output reg [3:0] read);
    reg [3:0] rows [0:7];
    always @(posedge clk) read <= rows[at];
    always @(posedge clk) if (write) rows[at] <= data;
    initial rows[5] = 4'h6;
    initial rows[0] = 4'h9;
endmodule
"""

MEMORIES_ALTERED = {
    "width": ("reg [3:0] far [0:7]", "reg [4:0] far [0:7]"),
    "depth": ("reg [3:0] far [0:7]", "reg [3:0] far [0:6]"),
    "offset": ("reg [3:0] far [0:7]", "reg [3:0] far [-1:6]"),
    "attribute": ("reg [3:0] far [0:7]", '(* ram_style = "block" *) reg [3:0] far [0:7]'),
    "first contents": ("far[5] = 4'h6", "far[5] = 4'h7"),
    "place of first contents": ("far[5] = 4'h6", "far[4] = 4'h6"),
    "no first contents": ("        far[5] = 4'h6;\n", ""),
    "order of first contents": (
        "near[0] = 4'h3;\n        near[5] = 4'h6;\n        near[0] = 4'h9;",
        "near[0] = 4'h9;\n        near[5] = 4'h6;\n        near[0] = 4'h3;",
    ),
    "enable of a write": ("if (w) near[a] <= d", "if (v) near[a] <= d"),
    "memory of a write": ("if (v) far[c] <= d", "if (v) near[c] <= d"),
    "memory of a read": ("x <= near[a]", "x <= far[a]"),
    "memories exchanged": ("y <= near[b];\n", "y <= far[b];\n"),
    "priority of writes": (
        "if (w) near[a] <= d;\n        if (v) near[b] <= e;",
        "if (v) near[b] <= e;\n        if (w) near[a] <= d;",
    ),
    "no priority of writes": (
        "if (v) near[b] <= e;",
        "end\n    always @(posedge clk) begin\n        if (v) near[b] <= e;",
    ),
}


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


@pytest.fixture(scope="module")
def two_memories(tmp_path_factory):
    return netlist(tmp_path_factory.mktemp("memories"), MEMORIES)


def test_memories_renamed_and_reordered(two_memories, tmp_path):
    renamed = netlist(tmp_path, MEMORIES_RENAMED)
    assert renamed.colours == two_memories.colours
    assert renamed.digest == two_memories.digest
    assert renamed.colour_of["aft.rows"] == two_memories.colour_of["far"]
    assert renamed.colour_of["bow"] == two_memories.colour_of["near"]
    assert len(set(two_memories.colour_of.values())) == len(two_memories.colour_of)


@pytest.mark.parametrize(("old", "new"), MEMORIES_ALTERED.values(), ids=MEMORIES_ALTERED)
def test_memories_altered(two_memories, old, new, tmp_path):
    assert MEMORIES.count(old) == 1
    altered = netlist(tmp_path, MEMORIES.replace(old, new))
    assert altered.colours != two_memories.colours
    assert altered.digest != two_memories.digest


def test_memories_exchanged(tmp_path):
    """Two memories of equal size, each with a write and a read, differ in their wires."""
    text = MEMORIES.replace("        if (v) near[b] <= e;\n", "").replace("y <= near[b]", "y <= b")
    exchanged = text.replace("x <= near[a]", "x <= far[a]").replace("z <= far[c]", "z <= near[c]")
    both = exchanged.replace("near", "other").replace("far", "near").replace("other", "far")
    digests = [netlist(tmp_path, each).digest for each in (text, exchanged, both)]
    assert digests[0] != digests[1] == digests[2]


def test_ports_without_names(tmp_path):
    """Their directions, widths and wires still matter."""
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


def test_what_cannot_be_compared(tmp_path, capsys):
    file = tmp_path / "design.v"
    assert main([str(file), str(file)]) == 2
    assert capsys.readouterr().err.startswith("netlist: [Errno 2] No such file or directory: ")
    file.write_text("module top(")
    assert main([str(file), str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"netlist: Yosys refuses {file}: ")
