"""Convert ``docs/tutorial.md`` to ``docs/tutorial.ipynb``: the same text and code, without outputs.

Python fences become code cells, and the text between them becomes text cells.
``python -m tools.notebook`` writes the file; a test fails if it is out of date.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


_DOCS = Path(__file__).resolve().parents[1] / "docs"
TUTORIAL = _DOCS / "tutorial.md"
NOTEBOOK = _DOCS / "tutorial.ipynb"

_FENCE = re.compile(r"^```python\n(.*?)^```\n", re.MULTILINE | re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)
_FIRST = "# Show the pictures of `plot()` in the notebook.\n%matplotlib inline"


def notebook(markdown: str) -> str:
    """Return the notebook of a page as JSON with a final newline."""
    cells = [_cell(number, *cell) for number, cell in enumerate(_cells(markdown))]
    document = {
        "cells": cells,
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _cells(markdown: str) -> Iterator[tuple[str, str]]:
    """Yield the kind and source of each cell."""
    text, *parts = _FENCE.split(markdown)
    yield "markdown", text
    yield "code", _FIRST
    for code, after in zip(parts[::2], parts[1::2], strict=True):
        yield "code", code
        if after.strip():
            yield "markdown", after


def _cell(number: int, kind: str, source: str) -> dict[str, Any]:
    text = _COMMENT.sub("", source).strip()
    cell: dict[str, Any] = {
        "cell_type": kind,
        "id": f"cell-{number}",
        "metadata": {},
        "source": text.splitlines(keepends=True),
    }
    if kind == "code":
        cell |= {"execution_count": None, "outputs": []}
    return cell


if __name__ == "__main__":
    NOTEBOOK.write_text(notebook(TUTORIAL.read_text("utf-8")), "utf-8")
    sys.stdout.write(f"{NOTEBOOK}\n")
