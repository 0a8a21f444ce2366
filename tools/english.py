"""Counter of the habits that make prose read as translated.

``python -m tools.english`` counts them in the docstrings, the comments and the pages of every room
of the project, ``python -m tools.english PATH...`` in single files and folders. A line per file
gives the words, and each habit that occurs; ``--lines`` prints each occurrence with its place, and
``--messages`` counts the strings of the Python files instead, which users read as messages.

Code in backticks and in fences is not prose. The text of a docstring, of a run of comments and of a
paragraph is joined before it is searched, so that line breaks hide nothing.
"""

from __future__ import annotations

import argparse
import ast
import collections
import io
import os
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path


ROOT = Path(__file__).resolve().parents[1]

#: The folders whose prose is counted; ``docs`` includes the pages at the root.
ROOMS = ("hdl", "host", "sim", "pathgene", "tools", "bench", "tests", "docs")

#: Goal of a room for the following habits together, in occurrences per 1,000 words. This counter
#: finds 0.18 in amaranth, 0.27 in httpx and 0 in cocotb.
GOAL = 0.4
#: Habits that hardly occur in prose that was written in English.
COUNTED = {
    "that of": r"\b(?:[Tt]hat|[Tt]hose) of\b",
    "behind": r"\b[Bb]ehind\b",
    "Of": r"\bOf\b",
    "What": r"\bWhat\b",
    "set free": r"\b[Ss]ets? free\b|\b[Ss]etting free\b",
    "go on": r"\b[Gg]o(?:es|ing|ne)? on\b|\b[Ww]ent on\b",
    "anew": r"\b[Aa]new\b",
}
#: Verbs that an indirect question follows; "the error says what is missing" is plain English.
_ASKING = "say says said tell tells told show shows see know knows ask asks explain explains decide"
_NO_ASKING = "".join(rf"(?<!\b{verb} )" for verb in _ASKING.split())
#: Habits that each have their own goal, in occurrences per 1,000 words: the rate of amaranth.
OTHERS = {
    "what": (rf"{_NO_ASKING}\bwhat\b(?![^.!?]*\?)", 0.15),
    "most X": (
        r"\b(?:Most|Least) (?!of\b)\w+s?\b"
        r"|(?<!\bat )(?<!\bthe )\b(?:most|least) (?!of\b)"
        r"(?=\w+ (?:of|that|which|per|for|in|from|on)\b)",
        0.2,
    ),
    "so many": (r"\b[Ss]o (?:many|much|long|far|few|often)\b", 0.1),
    "others": (r"\b(?:[Oo]thers|[Tt]he other)\b", 0.2),
}
#: Pattern of each habit.
HABITS = {name: re.compile(pattern) for name, pattern in COUNTED.items()} | {
    name: re.compile(pattern) for name, (pattern, _) in OTHERS.items()
}

_WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")
_CODE = re.compile(r"``.+?``|:\w+:`[^`]+`|`[^`]+`", re.DOTALL)
#: Targets of links, and addresses.
_TARGET = re.compile(r"\]\([^)]*\)|https?://\S+")
_FENCE = re.compile(r"^( *)(`{3,})[^\n]*\n.*?^ *\2 *$", re.MULTILINE | re.DOTALL)
_MARK = re.compile(r"<!--.*?-->", re.DOTALL)
#: Strings and comments of C, C++, JavaScript and CSS; strings are matched because they may contain
#: text that looks like a comment.
_C_TOKEN = re.compile(
    r"""(?P<string>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`)"""
    r"|(?P<block>/\*.*?\*/)|(?P<line>//[^\n]*)",
    re.DOTALL,
)
_C_SUFFIXES = {".c", ".h", ".cpp", ".hpp", ".js", ".css"}
_SUFFIXES = _C_SUFFIXES | {".py", ".md"}
#: A message has at least this many words; shorter strings are names.
_WORDS_OF_A_MESSAGE = 4
#: Folders of generated files.
_SKIPPED = {"build", "__pycache__", "node_modules", "vendor"}


@dataclass(frozen=True)
class Prose:
    """A piece of prose: a docstring, a run of comments or a paragraph."""

    line: int
    text: str


class Count:
    """Words and habits of some prose.

    Attributes
    ----------
    found : list[tuple[int, str, str]]
        Line, habit and surrounding words of each occurrence.
    """

    def __init__(self, pieces: Iterable[Prose] = ()) -> None:
        self.words = 0
        self.habits: collections.Counter[str] = collections.Counter()
        self.found: list[tuple[int, str, str]] = []
        for piece in pieces:
            self._add(piece)

    def _add(self, piece: Prose) -> None:
        # Each replacement keeps the length and the line breaks, so that places stay valid.
        text = piece.text
        for pattern in (_CODE, _TARGET):
            text = pattern.sub(lambda match: re.sub(r"[^\n]", "·", match[0]), text)
        self.words += len(_WORD.findall(text))
        flat = text.replace("\n", " ")
        flat = re.sub(r"(?<= ) +", lambda match: "\0" * len(match[0]), flat)
        searched = flat.replace("\0", "")
        # Places in `searched`, back in `flat`.
        kept = [at for at, character in enumerate(flat) if character != "\0"]
        for name, pattern in HABITS.items():
            for match in pattern.finditer(searched):
                self.habits[name] += 1
                line = piece.line + text.count("\n", 0, kept[match.start()])
                words = searched[max(0, match.start() - 30) : match.end() + 40].strip()
                self.found.append((line, name, words))

    def __iadd__(self, other: Count) -> Count:
        self.words += other.words
        self.habits += other.habits
        return self

    @property
    def counted(self) -> int:
        """Occurrences of the habits of :data:`COUNTED`, together."""
        return sum(self.habits[name] for name in COUNTED)

    def rate(self, *names: str) -> float:
        """Return the occurrences of habits per 1,000 words."""
        return 1000 * sum(self.habits[name] for name in names) / self.words if self.words else 0.0


def _docstrings(tree: ast.Module) -> Iterator[ast.Constant]:
    for node in ast.walk(tree):
        # A string after an assignment documents the name: each string that is a statement counts.
        match node:
            case ast.Expr(value=ast.Constant(value=str()) as string):
                yield string


def _python(text: str) -> Iterator[Prose]:
    for string in _docstrings(ast.parse(text)):
        yield Prose(string.lineno, str(string.value))
    yield from _runs(_python_comments(text))


def _python_comments(text: str) -> Iterator[tuple[int, str, bool]]:
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            line, column = token.start
            alone = not token.line[:column].strip()
            yield line, token.string.lstrip("#:! ").rstrip(), alone


def _runs(comments: Iterable[tuple[int, str, bool]]) -> Iterator[Prose]:
    """Join comments on lines that follow each other; a comment after code stays single."""
    run: list[str] = []
    begin = last = -1
    for line, words, alone in comments:
        if run and alone and line == last + 1:
            run.append(words)
        else:
            if run:
                yield Prose(begin, "\n".join(run))
            run, begin = [words], line
        last = line if alone else -1
    if run:
        yield Prose(begin, "\n".join(run))


def _python_messages(text: str) -> Iterator[Prose]:
    tree = ast.parse(text)
    docstrings = {id(string) for string in _docstrings(tree)}
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(value)) if id(node) not in docstrings:
                if len(_WORD.findall(value)) >= _WORDS_OF_A_MESSAGE:
                    yield Prose(node.lineno, value)


def _c(text: str) -> Iterator[Prose]:
    lines = []
    for match in _C_TOKEN.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        if match["block"]:
            yield Prose(line, re.sub(r"(?m)^ *\*+", "", match["block"][2:-2]))
        elif match["line"]:
            lines.append((line, match["line"].lstrip("/!< "), True))
    yield from _runs(lines)


def _page(text: str) -> Iterator[Prose]:
    for pattern in (_FENCE, _MARK):
        text = pattern.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    line = 1
    for paragraph in re.split(r"(\n[ \t]*(?=\n))", text):
        if paragraph.strip():
            yield Prose(line, paragraph)
        line += paragraph.count("\n")


def _unreleased(text: str) -> str:
    """Return the unreleased part of a change log: the past does not change."""
    sections = re.split(r"(?m)^(?=## )", text)
    return "".join(sections[:2])


def count(path: Path, *, messages: bool = False) -> Count:
    """Count the habits of a file; with ``messages``, of its strings instead of comments."""
    text = path.read_text("utf-8")
    if path.name == "CHANGELOG.md":
        text = _unreleased(text)
    if messages:
        return Count(_python_messages(text) if path.suffix == ".py" else ())
    reader = {".py": _python, ".md": _page}.get(path.suffix, _c)
    return Count(reader(text))


def files(folder: Path) -> Iterator[Path]:
    """Yield the files of a folder that contain prose, without following links to folders."""
    for place, folders, names in os.walk(folder):
        folders[:] = sorted(
            name for name in folders if name not in _SKIPPED and not name.startswith(".")
        )
        for name in sorted(names):
            path = Path(place, name)
            if path.suffix in _SUFFIXES and not path.is_symlink():
                yield path


def room_files(room: str) -> Iterator[Path]:
    """Yield the files of a room of :data:`ROOMS`."""
    yield from files(ROOT / room)
    if room == "docs":
        yield from sorted(ROOT.glob("*.md"))
        yield from files(ROOT / "examples")


def counts(room: str) -> dict[str, int]:
    """Return the habits of :data:`COUNTED` in a room, together, and each of :data:`OTHERS`."""
    found = Count()
    for path in room_files(room):
        found += count(path)
    return {", ".join(COUNTED): found.counted} | {habit: found.habits[habit] for habit in OTHERS}


def _row(name: str, total: Count) -> str:
    habits = ", ".join(f"{habit} {total.habits[habit]}" for habit in HABITS if total.habits[habit])
    return f"{total.rate(*COUNTED):6.2f}  {total.counted:5}  {total.words:7}  {name:40}  {habits}"


def main(arguments: list[str] | None = None) -> int:
    """Run the counter; see the module."""
    parser = argparse.ArgumentParser(prog="python -m tools.english", description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path, metavar="PATH", help="files and folders")
    parser.add_argument("--lines", action="store_true", help="print each occurrence")
    parser.add_argument("--messages", action="store_true", help="count strings of Python files")
    parser.add_argument(
        "--allowed", action="store_true", help="print the table of tests/unit/test_english.py"
    )
    options = parser.parse_args(arguments)
    if options.allowed:
        for room in ROOMS:
            print(f'    "{room}": {tuple(counts(room).values())},')
        return 0
    if options.paths:
        groups = {
            str(path): [path]
            for top in options.paths
            for path in (files(top) if top.is_dir() else [top])
        }
    else:
        groups = {room: [*room_files(room)] for room in ROOMS}
    if not options.lines:
        print("  rate  counted  words  (rate: the first seven habits, per 1,000 words)")
    whole = Count()
    for name, paths in groups.items():
        total = Count()
        for path in paths:
            one = count(path, messages=options.messages)
            total += one
            if options.lines:
                place = (
                    path.resolve().relative_to(ROOT)
                    if path.resolve().is_relative_to(ROOT)
                    else path
                )
                for line, habit, words in sorted(one.found):
                    print(f"{place}:{line}: [{habit}] {words}")
        whole += total
        if not options.lines and (total.habits or not options.paths):
            print(_row(name, total))
    if not options.lines:
        print(_row("together", whole))
        for habit, (_, limit) in OTHERS.items():
            print(f"{habit!r}: {whole.rate(habit):.2f} per 1,000 words, the goal is {limit}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
