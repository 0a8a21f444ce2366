"""Results that are kept, and the tables of pages."""

import json

import pytest

from bench import kept
from bench.kept import Kept, paste
from pathgene.host.errors import InputError


def test_results_outlive_the_run_until_their_sources_change(tmp_path, monkeypatch):
    file = tmp_path / "results.json"
    one = Kept(file, "bench/report.py")
    assert one.get("row", "part") is None
    one.keep("row", "part", {"F": 1.5})
    one.keep("row", "another part", {"F": 1.25})
    one.keep("a row", "part", {"F": None})
    again = Kept(file, "bench/report.py")
    assert again.get("row", "part") == {"F": 1.5}
    assert again.get("row", "third part") is None
    # A line a result, in order.
    assert list(json.loads(file.read_text())) == ["a row", "row"]
    assert len(file.read_text().splitlines()) == 3 + 2 * 2 + 2

    monkeypatch.setattr(kept, "digest", lambda *_: "others")
    changed = Kept(file, "bench/report.py")
    assert changed.get("row", "part") is None
    changed.keep("row", "part", {"F": 1.75})
    monkeypatch.undo()
    mixed = Kept(file, "bench/report.py")
    assert mixed.get("row", "part") is None
    assert mixed.get("row", "another part") == {"F": 1.25}


def test_refuses_a_file_of_something_else(tmp_path):
    file = tmp_path / "results.json"
    file.write_text("# Results")
    with pytest.raises(InputError, match=r"results.json holds no results; remove it or restore it"):
        Kept(file)


def test_tables_are_pasted_between_their_lines(tmp_path):
    page = tmp_path / "page.md"
    begin, end = "<!-- tables of BENCH=speed -->", "<!-- end of BENCH=speed -->"
    page.write_text(f"# Title\n\n{begin}\n\nold\n\n{end}\n\nLimits\n")
    for tables in ("| a |", "| b |"):
        paste(page, "speed", tables)
        assert page.read_text() == f"# Title\n\n{begin}\n\n{tables}\n\n{end}\n\nLimits\n"
    page.write_text(f"{end}\n{begin}\n")
    with pytest.raises(InputError, match=r"^page.md has no place for the tables: the lines <!-- "):
        paste(page, "speed", "| a |")
    assert page.read_text() == f"{end}\n{begin}\n"
