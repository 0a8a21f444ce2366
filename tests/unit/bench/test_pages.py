"""The tables of the pages equal the stored results, and a stored report reaches its pages."""

import json
import re
import sys
from datetime import UTC, date, datetime

import pytest

from bench import __main__, pages
from bench.report import Options, Report
from bench.store import digest
from pathgene.host.errors import InputError


def test_further_tables_follow_in_text_and_json(tmp_path):
    below = Report("Seconds", ("planner", "s"), [("astar", 0.25)], ["All cores."])
    report = Report(
        "F", ("planner", "F"), [("astar", 1.5)], ["Means."], {"runs": [1]}, further=[below]
    )
    assert report.text() == (
        "## F\n\n| planner | F   |\n|---------|-----|\n| astar   | 1.5 |\n\nMeans.\n\n"
        "## Seconds\n\n| planner | s    |\n|---------|------|\n| astar   | 0.25 |\n\nAll cores."
    )
    content = json.loads(report.write(tmp_path / "f.json").read_text())
    assert list(content) == ["title", "rows", "notes", "measured", "further", "runs"]
    assert set(content["measured"]) == {"date", "sources", "processor", "cores", "python", "system"}
    assert date.fromisoformat(content["measured"]["date"]) <= datetime.now(UTC).date()
    assert content["measured"]["sources"] == digest("bench", "hdl", "host", "sim")
    assert content["rows"] == [{"planner": "astar", "F": 1.5}]
    assert content["further"] == [
        {"title": "Seconds", "rows": [{"planner": "astar", "s": 0.25}], "notes": ["All cores."]}
    ]


@pytest.mark.parametrize("page", pages.pages(), ids=lambda page: page.stem)
def test_tables_of_pages_are_the_kept_results(page):
    text = page.read_text("utf-8")
    assert pages.render(text, page.name) == text, "write them with python -m bench.pages"


def test_every_kept_report_is_shown():
    shown = {
        name
        for page in pages.pages()
        for name in re.findall(r"<!-- tables of BENCH=([\w-]+)", page.read_text("utf-8"))
    }
    assert shown == {path.stem for path in pages.FIGURES.glob("*.json")}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with one page and stored reports."""
    monkeypatch.setattr(pages, "PAGES", tmp_path)
    monkeypatch.setattr(pages, "FIGURES", tmp_path / "figures")
    return tmp_path


def report(speed):
    slow = Report("Slow paths", ("path", "ms"), [("long", speed * 10)])
    return Report("Fast paths", ("path", "ms"), [("short", speed)], ["A note."], further=[slow])


ALL = "<!-- tables of BENCH=speed -->\n<!-- end of BENCH=speed -->\n"
ONE = "<!-- tables of BENCH=speed: Slow -->\n\nold\n\n<!-- end of BENCH=speed -->\n"


def test_a_kept_report_is_written_into_its_pages(folder):
    page = folder / "page.md"
    page.write_text(f"# Title\n\n{ALL}\nText\n\n{ONE}\nEnd\n")
    assert pages.keep("speed", report(1)) == folder / "figures" / "speed.json"
    assert page.read_text() == (
        "# Title\n\n<!-- tables of BENCH=speed -->\n\n"
        "### Fast paths\n\n| path  | ms |\n|-------|----|\n| short | 1  |\n\nA note.\n\n"
        "### Slow paths\n\n| path | ms |\n|------|----|\n| long | 10 |\n\n"
        "<!-- end of BENCH=speed -->\n\nText\n\n"
        "<!-- tables of BENCH=speed: Slow -->\n\n"
        "| path | ms |\n|------|----|\n| long | 10 |\n\n"
        "<!-- end of BENCH=speed -->\n\nEnd\n"
    )
    before = page.read_text()
    assert pages.write() == []
    pages.keep("speed", report(2))
    assert page.read_text() == before.replace("| 1  |", "| 2  |").replace("| 10 |", "| 20 |")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ALL.replace("speed", "other"), r"shows BENCH=other, of which nothing is kept: run python"),
        (ONE.replace("Slow", "Old"), r"a table 'Old' of BENCH=speed; there are 'Fast paths', 'Sl"),
        (ALL.partition("\n")[0], r"^page.md has a line <!-- tables of BENCH=NAME --> without <!--"),
    ],
)
def test_a_page_that_cannot_be_written_stays(folder, text, message, capsys):
    pages.keep("speed", report(1))
    page = folder / "page.md"
    page.write_text(text)
    with pytest.raises(InputError, match=message):
        pages.write()
    assert page.read_text() == text
    assert pages.main() == 2
    assert capsys.readouterr().err.startswith("bench.pages: page.md ")


def test_keep_is_an_option_of_the_command(folder, monkeypatch, capsys):
    page = folder / "page.md"
    page.write_text("<!-- tables of BENCH=simulation -->\n<!-- end of BENCH=simulation -->\n")
    monkeypatch.setattr("bench.simulation.run", lambda options: report(options.seeds))
    out = str(folder / "out")
    for arguments in (["simulation"], ["simulation", "--keep", "--seeds", "7"]):
        assert not list(folder.glob("figures/*"))
        monkeypatch.setattr(sys, "argv", ["bench", *arguments, "--out", out])
        assert __main__.main() == 0
    assert "| short | 7  |" in page.read_text()
    kept = json.loads((folder / "figures" / "simulation.json").read_text())
    assert kept["rows"] == [{"path": "short", "ms": 7}]
    assert Options().seeds != 7


def test_a_table_is_kept_among_the_others(folder):
    first = Report("Fast", ("a", "b"), [("x", 1)], further=[Report("Slow", ("a", "b"), [("y", 2)])])
    pages.keep("speed", first)
    pages.keep_table("speed", Report("Guided", ("a", "b"), [("z", 3)], data={"breaks": 1}))
    pages.keep_table("speed", Report("Guided", ("a", "b"), [("z", 4)], data={"breaks": 2}))
    content = json.loads((folder / "figures" / "speed.json").read_text())
    assert (content["title"], content["breaks"]) == ("Fast", 2)
    assert [each["title"] for each in content["further"]] == ["Slow", "Guided"]
    assert content["further"][1]["rows"] == [{"a": "z", "b": 4}]
    assert "date" in content["further"][1]["measured"]
