"""The benchmark of the desk runs, with few frames and loads."""

import os

import pytest

from bench import desk
from bench.report import Options


@pytest.mark.long
def test_what_is_measured_of_the_desk(monkeypatch):
    # NiceGUI behaves differently within pytest.
    for name in list(os.environ):
        if "PYTEST" in name:
            monkeypatch.delenv(name)
    monkeypatch.setattr(desk, "_LOADS", 1)
    monkeypatch.setattr(desk, "_SECONDS", 4.0)
    report = desk.run(Options())
    if not report.rows:
        # As in all tests of pages, Chromium may be missing, because it is not a Python package.
        pytest.skip(report.notes[-1])
    page, shown, all_shown, frames, generations = (value for _, value in report.rows)
    assert 0 < page < shown < all_shown < 120
    assert frames > 0
    assert generations > 0
