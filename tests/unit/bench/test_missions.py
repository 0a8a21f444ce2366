"""The benchmark of checks: only the missions through hills have faults."""

from bench import missions
from bench.report import Options


def test_checks_what_it_says(monkeypatch):
    monkeypatch.setattr(missions, "ITEMS", (10,))
    monkeypatch.setattr(missions, "_CHECKS", 1)
    report = missions.run(Options())
    (items, _, none, *_), (_, _, some, least, median) = report.rows
    assert (items, none) == (10, 0)
    assert some > 3
    assert 0 < least <= median
