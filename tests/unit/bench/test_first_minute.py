"""The benchmark of the first minute runs its commands."""

import pytest

from bench import first_minute
from bench.report import Options


@pytest.mark.ci
def test_measures_each_command(monkeypatch):
    measured = []
    own = first_minute._measured

    def noted(command, folder):
        measured.append((command[0], own(command, folder)))
        return measured[-1][1]

    monkeypatch.setattr(first_minute, "_measured", noted)
    monkeypatch.setattr(first_minute, "FIRST", 0)
    monkeypatch.setattr(first_minute, "RUNS", 1)
    report = first_minute.run(Options())
    assert [row[0] for row in report.rows] == list(first_minute._COMMANDS)
    assert [name for name, _ in measured] == [each[0] for each in first_minute._COMMANDS.values()]
    for _, (processor_s, first_s) in measured:
        assert processor_s > 0
        assert first_s > 0
