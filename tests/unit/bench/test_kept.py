"""Results that are kept, and the tables of pages."""

import json

import pytest

from bench import kept
from bench.kept import Kept
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
