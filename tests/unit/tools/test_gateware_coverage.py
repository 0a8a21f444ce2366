"""A signal, a bit and a line that no session reaches are reported."""

import re

import pytest

from pathgene.host.errors import JobError
from tests.cosim.coverage_reasons import REASONS
from tests.support.gateware.chips import SMALL
from tools.faults.chips import VerilatedOnLine
from tools.gateware_coverage import (
    LINES,
    PAGE,
    TOGGLES,
    Point,
    Unit,
    constants_of,
    coverage,
    decoded,
    points,
    table,
)


#: A chip that counts the delimiters it receives; ``stuck`` never rises, ``zero`` never can.
CHIP = """
module chip(clk, rst, rx, tx);
  input clk, rst, rx;
  output tx;
  reg [3:0] count = 0;
  reg stuck = 0;
  reg was = 1;
  wire [1:0] zero = {1'b0, was};
  assign tx = ~zero[1];
  always @(posedge clk) begin
    was <= rx;
    if (was & ~rx)
      count <= count + 1;
    if (count == 9)
      stuck <= 1;
    if (rst)
      count <= 0;
  end
endmodule
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return the coverage after three falls of the line."""
    path = tmp_path_factory.mktemp("coverage") / "counts.dat"
    with VerilatedOnLine(SMALL, verilog=CHIP, coverage=True) as chip:
        chip.feed(b"\xff\xff\xff")
        chip.write_coverage(path)
    counted = list(points(path.read_text().splitlines()))
    return coverage(counted, CHIP, {"chip": "Counter"}, constants_of(CHIP))["Counter"]


@pytest.mark.cosim
@pytest.mark.ci
def test_what_is_not_reached_is_reported(found):
    missing = found.missing()
    line = next(n for n, text in enumerate(CHIP.splitlines(), 1) if "count == 9" in text)
    assert f"chip, line {line}" in missing
    assert "chip.stuck:0->1" in missing
    assert {"chip.count[2]:0->1", "chip.count[3]:0->1"} <= set(missing)
    assert not any("count[0]" in each or "was" in each for each in missing)
    assert found.is_low


@pytest.mark.cosim
@pytest.mark.ci
def test_a_constant_bit_is_left_out(found):
    assert found.constants == 2 * len(["tx", "zero[1]"])
    assert ("chip", "zero[0]:0->1") in found.toggles
    assert ("chip", "zero[1]:0->1") not in found.toggles


def test_a_low_unit_needs_a_reason():
    low = Unit(toggles={("chip", "a:0->1"): False, ("chip", "a:1->0"): True})
    with pytest.raises(
        JobError, match=r"^No reason says why these units are below a bound: Low\.$"
    ):
        table({"Low": low}, {})
    assert "| Low | 100.0 % of 0 | 50.0 % of 2 | 0 | a is stuck |" in table(
        {"Low": low}, {"Low": "a is stuck"}
    )


def test_a_reason_that_is_obsolete_is_named():
    with pytest.raises(JobError, match=r"a reason above the bounds: High\.$"):
        table({"High": Unit()}, {"High": "none"})


def test_a_line_is_covered_if_all_of_its_branches_are():
    counted = [Point("v_line", "chip", 1, "if", 3), Point("v_branch", "chip", 1, "else", 0)]
    unit = coverage(counted, "a = b ? c : d;", {"chip": "Unit"}, {})["Unit"]
    assert unit.lines == {("chip", 1): False}


def test_the_page_has_both_chips():
    """Each chip has its sentence and its table, and no cell is empty."""
    text = PAGE.read_text(encoding="utf-8").partition("<!-- gateware coverage -->")[2]
    text = text.partition("<!-- end of gateware coverage -->")[0]
    assert re.findall(r"^(\w+ core): [\d.]+ % of", text, re.MULTILINE) == [
        "planner core",
        "paper core",
    ]
    rows = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("| ")]
    assert len(rows) > 100
    assert all(len(row) == 5 and all(map(str.strip, row)) for row in rows)
    assert low_on_page(rows) == {name for each in REASONS.values() for name in each}


def low_on_page(rows):
    """Return the units of the page that are below a bound."""
    return {
        name.strip()
        for name, lines, toggles, *_ in rows
        if "%" in lines and (share(lines) < LINES or share(toggles) < TOGGLES)
    }


def share(cell):
    """Return the percentage that a cell states."""
    return float(cell.partition("%")[0])


def test_names_are_decoded():
    assert decoded("counts___05Fpayload__02413__02enofly[4]") == "counts__payload$13.nofly[4]"
