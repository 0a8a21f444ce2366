"""Sentences of a page, with the sections in which they stand.

A sentence is a sentence of a paragraph or of an item of a list, or a row of a table. Fences,
pictures, comments and the heads of tables have none. Neither does text that only introduces
generated tables, as in ``Request: {{layout:info_reply}}``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass


_FENCE = re.compile(r"^( *)```.*?^ *```[^\n]*$", re.MULTILINE | re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_PLACEHOLDER = re.compile(r"\{\{[^}]*\}\}")
_ITEM = re.compile(r" *(?:[-*]|\d+\.) +(?=\S)")
_HEADING = re.compile(r"#+ +(?P<title>.+)")
_RULE_OF_TABLE = re.compile(r"\|[-: |]+\|")
#: End of a sentence, then the beginning of another one.
_END = re.compile(r"(?:(?<=[.?!])|(?<=[.?!][)`])|(?<=[.?!]\*\*)) +(?=[\"(\[*`A-Z0-9])")
_LEAD = re.compile(r"\*\*[^*]+\.\*\*")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class Sentence:
    """A sentence of a page.

    Parameters
    ----------
    text : str
        On one line, with its marks. Links are replaced by their texts, and the cells of a row of a
        table are joined by vertical bars.
    section : str
        Title of the section.
    """

    text: str
    section: str

    @property
    def anchor(self) -> str:
        """The anchor of the section in the page."""
        words = re.sub(r"[^\w\- ]", "", _LINK.sub(r"\1", self.section).lower())
        return words.strip().replace(" ", "-")


def sentences(page: str) -> list[Sentence]:
    """Return the sentences of a page in Markdown, in their order."""
    text = _COMMENT.sub("", _FENCE.sub("", page))
    return [
        Sentence(sentence, section)
        for section, block in _blocks(text.splitlines())
        for sentence in _split(block)
    ]


def _blocks(lines: list[str]) -> Iterator[tuple[str, str]]:
    """Yield paragraphs, items of lists and rows of tables, each with its section."""
    section = ""
    block: list[str] = []
    is_head = True
    for line in [*lines, ""]:
        heading = _HEADING.fullmatch(line)
        is_row = line.startswith("|")
        if block and (not line.strip() or heading or is_row or _ITEM.match(line)):
            yield section, " ".join(block)
            block = []
        if heading:
            section = heading["title"]
        elif is_row:
            # The first row of a table is its head, the second one a rule.
            if not is_head and not _RULE_OF_TABLE.fullmatch(line):
                yield section, line
            is_head = False
        elif line.strip():
            mark = _ITEM.match(line)
            block.append(line[mark.end() if mark else 0 :].strip())
        if not is_row:
            is_head = True


def _split(block: str) -> Iterator[str]:
    """Yield the sentences of a block."""
    if block.startswith("!["):
        return
    block = _LINK.sub(r"\1", block)
    if block.startswith("|"):
        cells = re.split(r"(?<!\\)\|", block.strip().strip("|"))
        yield " | ".join(cell.strip() for cell in cells)
        return
    for sentence in _END.split(block):
        # A generated table follows, or stands for the sentence; bold words only open a paragraph.
        if re.search(r"(?:^|: )\{\{[^}]*\}\}$", sentence) or _LEAD.fullmatch(sentence):
            continue
        yield _PLACEHOLDER.sub("…", sentence)
