"""The rows of the requirements, their checks, and the tables that show them.

A file of this folder with the suffix ``.toml`` holds the rows of one page. ``page`` names the page
and ``source`` the text that it is made from, if it is generated. ``left_out`` names the sections
that state no requirements. Each ``[[rows]]`` has

``sentences``
    The requirement as the page states it; further sentences belong to the same requirement.
``unit``
    The file that satisfies it and the name there, as in ``host/problem/surface.py:Demand.of``.
``test``
    A test of pytest, or a proof of ``tests/formal``.
``fault``
    The planted fault in words. ``old`` is its place, a text that occurs once in the unit's file,
    and ``new`` replaces it.
``interpreted``
    Whether the test runs without compiled kernels, because compiling the altered ones takes longer.

``[explanations]`` has the sentences that require nothing, by the reason why.
"""

from __future__ import annotations

import ast
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tools.requirements.sentences import Sentence, sentences


ROOT = Path(__file__).resolve().parents[2]
#: Files of rows, in the order of the tables.
FILES = ("rules", "reliability", "protocol")
#: The page that shows the tables, between two marks.
PAGE = ROOT / "docs" / "reliability.md"
_BEGIN, _END = "<!-- tables of requirements -->\n", "<!-- end of requirements -->\n"

_HEAD = Path(__file__).with_name("head.md")


@dataclass(frozen=True)
class Row:
    """A requirement with its unit, its test and a planted fault; see the module."""

    name: str
    sentences: tuple[str, ...]
    unit: str
    test: str
    fault: str
    old: str
    new: str
    interpreted: bool = False

    @property
    def file(self) -> str:
        """The file of the unit."""
        return self.unit.partition(":")[0]

    @property
    def is_proof(self) -> bool:
        """True if the test is a proof."""
        return self.test.startswith("tests/formal/test_formal.py::test_proof[")

    def faulty(self, root: Path) -> bytes:
        """Return the text of the unit's file with the planted fault.

        Raises
        ------
        ValueError
            If the place of the fault does not occur exactly once in the file.
        """
        text = (root / self.file).read_text("utf-8")
        if (count := text.count(self.old)) != 1:
            raise ValueError(f"{self.name}: {self.old!r} occurs {count} times in {self.file}")
        return text.replace(self.old, self.new).encode()


@dataclass(frozen=True)
class Requirements:
    """The rows of a page, and its sentences that require nothing."""

    page: str
    source: str
    left_out: tuple[str, ...]
    rows: tuple[Row, ...]
    explanations: Mapping[str, Sequence[str]]

    def stated(self, text: str | None = None) -> list[Sentence]:
        """Return the sentences of the page, or of another text of it."""
        text = (ROOT / self.source).read_text("utf-8") if text is None else text
        return [one for one in sentences(text) if one.section not in self.left_out]


def load(name: str) -> Requirements:
    """Return the rows of a file of this folder."""
    table = tomllib.loads((Path(__file__).parent / f"{name}.toml").read_text("utf-8"))
    rows = [
        Row(f"{name}-{number}", tuple(row.pop("sentences")), **row)
        for number, row in enumerate(table["rows"], start=1)
    ]
    return Requirements(
        table["page"],
        table.get("source", table["page"]),
        tuple(table.get("left_out", ())),
        tuple(rows),
        table["explanations"],
    )


def all_rows() -> list[Row]:
    """Return the rows of all pages."""
    return [row for name in FILES for row in load(name).rows]


def mistakes(requirements: Requirements) -> Iterator[str]:
    """Yield a sentence for each mistake in the rows of a page."""
    yield from mistakes_of_page(requirements)
    for row in requirements.rows:
        yield from mistakes_of_row(row)


def mistakes_of_page(requirements: Requirements, text: str | None = None) -> Iterator[str]:
    """Yield each sentence of a page, or of another text of it, without exactly one entry."""
    stated = dict.fromkeys(one.text for one in requirements.stated(text))
    entries = Counter(one for row in requirements.rows for one in row.sentences)
    entries += Counter(one for group in requirements.explanations.values() for one in group)
    for sentence, count in entries.items():
        if sentence not in stated:
            yield f"{requirements.page} does not state: {sentence}"
        if count > 1:
            yield f"{count} entries have the sentence: {sentence}"
    for sentence in stated:
        if sentence not in entries:
            yield f"{requirements.page} states without a row: {sentence}"


def mistakes_of_row(row: Row) -> Iterator[str]:
    """Yield a sentence for each part that a row lacks or names wrongly."""
    for name in ("sentences", "unit", "test", "fault", "old"):
        value = getattr(row, name)
        if not (value.strip() if isinstance(value, str) else value):
            yield f"{row.name} has no {name}"
    file, _, unit = row.unit.partition(":")
    if not (ROOT / file).is_file():
        yield f"{row.name}: no file {file}"
        return
    try:
        text = row.faulty(ROOT).decode()
    except ValueError as error:
        yield str(error)
        return
    if file.endswith(".py"):
        try:
            ast.parse(text)
        except SyntaxError as error:
            yield f"{row.name}: the fault is a syntax error in line {error.lineno}"
        if not any(row.old in part for part in _parts((ROOT / file).read_text("utf-8"), unit)):
            yield f"{row.name}: the fault is not in {row.unit}"
    path, *names = row.test.partition("[")[0].split("::")
    tests = (ROOT / path).read_text("utf-8") if (ROOT / path).is_file() else ""
    if not names or f"def {names[-1]}(" not in tests:
        yield f"{row.name}: no test {row.test}"


def _parts(text: str, unit: str) -> Iterator[str]:
    """Yield the texts of the classes, functions and values of a name, as in ``Class.method``."""
    lines = text.splitlines(keepends=True)
    nodes: list[ast.AST] = [_parsed(text)]
    for name in unit.split("."):
        nodes = [
            child
            for node in nodes
            for child in ast.walk(node)
            if child is not node and name in _names(child)
        ]
    for node in nodes:
        assert isinstance(node, ast.stmt)
        assert node.end_lineno is not None
        decorators = getattr(node, "decorator_list", [])
        first = min([node.lineno, *(one.lineno for one in decorators)])
        yield "".join(lines[first - 1 : node.end_lineno])


@cache
def _parsed(text: str) -> ast.Module:
    return ast.parse(text)


def _names(node: ast.AST) -> set[str]:
    match node:
        case ast.ClassDef(name=name) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
            return {name}
        case ast.Assign(targets=targets):
            return {one.id for one in targets if isinstance(one, ast.Name)}
        case ast.AnnAssign(target=ast.Name(id=name)):
            return {name}
    return set()


def with_tables(page: str) -> str:
    """Return the text of the page with its present tables."""
    before, _, rest = page.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    return f"{before}{_BEGIN}\n{tables()}\n{_END}{after}"


def tables() -> str:
    """Return the section of all tables."""
    parts = [_HEAD.read_text("utf-8")]
    for name in FILES:
        requirements = load(name)
        anchors = {one.text: one.anchor for one in requirements.stated()}
        page = Path(requirements.page).name
        own = "" if PAGE.name == page else page
        silent = sum(map(len, requirements.explanations.values()))
        parts.append(
            f"\n### Requirements of {page}\n\n{len(requirements.rows)} requirements of "
            f"[{page}]({page}); {silent} sentences there require nothing.\n\n"
            "| row | requirement | unit | test or proof | planted fault |\n|---|---|---|---|---|\n"
        )
        for row in requirements.rows:
            number = row.name.rpartition("-")[2]
            link = f"[{number}]({own}#{anchors.get(row.sentences[0], '')})"
            said = row.sentences[0].replace("|", "\\|")
            if more := len(row.sentences) - 1:
                said += f" (and {more} more sentence{'s' if more > 1 else ''} there)"
            file, _, unit = row.unit.partition(":")
            kind = "proof" if row.is_proof else "test"
            where = f"`{unit}`, {file}" if unit else file
            parts.append(f"| {link} | {said} | {where} | {kind} `{_short(row)}` | {row.fault} |\n")
    return "".join(parts)


def _short(row: Row) -> str:
    """Return a test without the folder of all tests; a bar would end the cell."""
    return row.test.removeprefix("tests/").replace("|", "\\|")
