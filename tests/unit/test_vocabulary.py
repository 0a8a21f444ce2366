"""One word for one thing: old words in texts; ``test_structure.py`` has the old identifiers."""

import re
from pathlib import Path


ROOT = Path(__file__).resolve().parents[2]
#: Folders with code and documents.
FOLDERS = (
    "bench",
    "constraints",
    "docs",
    "examples",
    "hdl",
    "host",
    "pathgene",
    "sim",
    "tests",
    "tools",
)
KINDS = ("c", "cpp", "css", "h", "hpp", "html", "ipynb", "js", "lpf", "md", "pcf", "py", "svg")
KINDS += ("toml", "v", "xdc")

#: Words of texts that have been replaced, with their successors, as regular expressions.
OLD_WORDS = {
    r"\bgenetic=(none|parallel|streaming|\d)": "core=",
    r"(streaming|parallel)\s+(genetic\s+)?core": "planner core, paper core",
    r"streaming\s+chip": "chip with the planner core",
    r"planner\s+on\s+the\s+chip": "planner core",
    r"(planner|paper)'s\s+(chip|core)": "planner core, paper core",
    r"streaming_planner": "planner_chip",
    r"--top planner\b(?!_)": "--top chip",
    r"engine[= ]cores": "engine threads",
}

#: The files that read old words, and their tests; the history of releases.
READ_OLD_WORDS = {
    "CHANGELOG.md",
    "host/old_words.py",
    "tests/cli/test_commands.py",
    "tests/unit/planners/test_registry.py",
    "tests/unit/test_old_words.py",
    "tests/unit/test_vocabulary.py",
}


def texts() -> dict[str, str]:
    """Return every text of the project by its path."""
    files = [ROOT / "Makefile", *ROOT.glob("*.md")]
    files += [
        file for folder in FOLDERS for kind in KINDS for file in (ROOT / folder).rglob(f"*.{kind}")
    ]
    return {str(file.relative_to(ROOT)): file.read_text("utf-8") for file in files}


def old_words(text: str) -> list[str]:
    """Return the old words of a text."""
    return [found[0] for word in OLD_WORDS for found in re.finditer(word, text)]


def test_no_text_has_an_old_word():
    """Code, messages, help, documents and pictures are all searched."""
    found = {path: old_words(text) for path, text in texts().items() if path not in READ_OLD_WORDS}
    assert {"Makefile", "README.md", "docs/protocol.md", "hdl/top.py"} <= found.keys()
    assert {path: words for path, words in found.items() if words} == {}


def test_old_words_are_found():
    text = "A streaming\n    core; genetic=1, the planner on the chip: --top planner --engine cores"
    assert len(old_words(text)) == 5
    assert old_words("--top planner_core, the planner core; parallel checker, engine=threads") == []
