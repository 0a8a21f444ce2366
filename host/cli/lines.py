"""Lines on standard error: one sentence each, however long the values in it are."""

from __future__ import annotations

import sys


__all__ = ["LONGEST_LINE", "print_line"]

#: Maximum characters of a line on standard error.
LONGEST_LINE = 1000

_PREFIX = "pathgene: "
# Paths of files may have some hundreds of characters.
_LONGEST_WORD = 400


def print_line(sentence: str) -> None:
    """Print a sentence as one line, with the middle of long words cut out."""
    line = _PREFIX + " ".join(_cut(word, _LONGEST_WORD, 100, 50) for word in sentence.split())
    print(_cut(line, LONGEST_LINE, 600, LONGEST_LINE - 603), file=sys.stderr, flush=True)


def _cut(text: str, longest: int, first: int, last: int) -> str:
    """Return the first and the last characters of a text that is longer than ``longest``."""
    return text if len(text) <= longest else f"{text[:first]}...{text[-last:]}"
