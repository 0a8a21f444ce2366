"""The habits of translated English: no room gets more of them, and the counter finds them.

``python -m tools.english`` prints the counts per room and, with a path, per file; ``--lines``
prints each place.
"""

from pathlib import Path

import pytest

from tools import english
from tools.english import HABITS, ROOMS, count, counts, main, room_files


#: Occurrences that each room may have: the habits of ``COUNTED`` together, and each of ``OTHERS``.
#: Whoever removes some lowers the numbers (``python -m tools.english --allowed`` prints the table);
#: nobody raises them.
ALLOWED: dict[str, tuple[int, ...]] = {
    "hdl": (2, 0, 0, 0, 0),
    "host": (0, 1, 0, 0, 1),
    "sim": (0, 1, 0, 0, 1),
    "pathgene": (0, 0, 0, 0, 0),
    "tools": (1, 1, 0, 0, 5),
    "bench": (0, 0, 0, 0, 1),
    "tests": (0, 0, 0, 0, 1),
    "docs": (3, 7, 0, 2, 13),
}


@pytest.mark.parametrize("room", ROOMS)
def test_no_room_gets_worse(room):
    worse = [
        f"{habit}: {now}, allowed {allowed}"
        for (habit, now), allowed in zip(counts(room).items(), ALLOWED[room], strict=True)
        if now > allowed
    ]
    assert not worse, (
        f"{room} has more habits of translated English ({'; '.join(worse)}); "
        f"python -m tools.english --lines {room} shows each place"
    )


def habits_of(path):
    return {habit: number for habit, number in count(path).habits.items() if number}


SENTENCES = {
    "that of": "Its width is that of a row, and its depth those of two.",
    "behind": "A byte behind the frame is refused.",
    "Of": "Of each slot a flag tells which one counts.",
    "What": "What lies outside is clamped.",
    "set free": "The slot is set free afterwards.",
    "go on": "The run goes on from there.",
    "anew": "The host plans anew.",
    "what": "The memory keeps what it reads.",
    "most X": "Most cells that a terrain has.",
    "so many": "After so many cycles it ends.",
    "others": "One lane reads, the others wait.",
}


@pytest.mark.parametrize("habit", SENTENCES)
def test_finds_each_habit(habit, tmp_path):
    assert SENTENCES.keys() == HABITS.keys()
    sentence = SENTENCES[habit]
    expected = {habit: len(HABITS[habit].findall(sentence))}
    space = sentence.rfind(" ", 0, len(sentence) // 2)
    # The line ends within the sentence.
    first, second = sentence[:space], sentence[space + 1 :]
    files = {
        "page.md": f"# Title\n\n{first}\n{second}\n\n```sh\n{sentence}\n```\n\n`{sentence}`\n",
        "module.py": f'"""Title.\n\n{first}\n    {second}\n"""\n\nTEXT = "{sentence}"\n',
        "comment.py": f"x = 1\n# {first}\n# {second}\n",
        "after.py": f"x = 1  # {sentence}\n",
        "script.js": f'const a = "// {sentence}";\n// {first}\n// {second}\n',
        "model.cpp": f"/* {first}\n * {second} */\nint a;\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        assert habits_of(tmp_path / name) == expected, name


def test_plain_english_has_none(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "The error says what is missing, at least once and at most twice. Most of it is sent to\n"
        "the chip. See [the page](that-of.md) and `that of`.\n"
    )
    assert habits_of(page) == {}
    assert count(page).words == 25


def test_only_the_unreleased_changes_count(tmp_path):
    log = tmp_path / "CHANGELOG.md"
    log.write_text("# Changelog\n\n## Unreleased\n\n- Anew.\n\n## 0.1.0\n\n- What goes on anew.\n")
    assert habits_of(log) == {"anew": 1}


def test_rooms_hold_their_files():
    assert Path("README.md") in {path.relative_to(english.ROOT) for path in room_files("docs")}
    assert not [path for path in room_files("pathgene") if "host" in path.parts]


def test_prints_counts_and_places(tmp_path, capsys):
    module = tmp_path / "module.py"
    module.write_text('"""Title."""\n\n\nERROR = "a message that goes on"\n\n# Written\n# anew.\n')
    assert main([str(tmp_path)]) == 0
    assert "module.py" in capsys.readouterr().out
    main([str(module), "--lines"])
    assert capsys.readouterr().out == f"{module}:7: [anew] Written anew.\n"
    main([str(module), "--lines", "--messages"])
    assert capsys.readouterr().out == f"{module}:4: [go on] a message that goes on\n"
