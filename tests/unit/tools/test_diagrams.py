"""The pictures of docs/architecture.md match the code."""

import re
from pathlib import Path

import pytest

from tools.diagrams.__main__ import is_drawn, waveforms
from tools.diagrams.blocks import graphs


ROOT = Path(__file__).resolve().parents[3]
PAGES = ("architecture.md", "protocol.md")


def test_block_diagrams():
    """`python -m tools.diagrams` redraws them."""
    stale = [name for name, graph in graphs().items() if not is_drawn(name, graph)]
    assert stale == []


@pytest.mark.ci
def test_waveforms():
    """`python -m tools.diagrams` redraws them."""
    stale = [path.name for path, svg in waveforms().items() if path.read_text() != svg]
    assert stale == []


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files(page):
    text = (ROOT / "docs" / page).read_text()
    links = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    missing = [
        link
        for link in links
        if not link.startswith("http") and not (ROOT / "docs" / link).exists()
    ]
    assert missing == []
