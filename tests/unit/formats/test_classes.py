"""Classes of airspace, and the list of ``--forbid``."""

import re
from pathlib import Path

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import classes


def test_words_and_numbers_are_of_one_class_each():
    words = [word for row in classes.CLASSES for word in (row.name, *row.words)]
    assert len(words) == len(set(words))
    assert all(word == word.upper() for word in words)
    numbers = [row.openaip for row in classes.CLASSES if row.openaip is not None]
    assert sorted(numbers) == list(range(37))


@pytest.mark.parametrize(
    ("word", "name", "forbids"),
    [
        ("R", "RESTRICTED", True),
        ("q", "DANGER", True),
        (" P ", "PROHIBITED", True),
        ("ctr", "CTR", True),
        ("TMA", "TMA", True),
        ("REQ_AUTHORIZATION", "REQ_AUTHORISATION", True),
        ("CONDITIONAL", "CONDITIONAL", True),
        ("NO_RESTRICTION", "NO_RESTRICTION", False),
        ("FIR", "FIR", False),
        ("W", "WAVE", False),
        ("GSEC", "GLIDING", False),
        ("D", "D", True),
        ("E", "E", False),
        ("unheard of", "UNHEARD OF", True),
        ("", "", True),
    ],
)
def test_what_forbids(word, name, forbids):
    assert classes.of_word(word) == name
    assert classes.forbids(name) is forbids


def test_a_list_replaces_the_classes_that_forbid():
    chosen = classes.forbidding("restricted, q,E")
    assert chosen == {"RESTRICTED", "DANGER", "E"}
    assert classes.forbids("E", chosen)
    assert not classes.forbids("CTR", chosen)
    # Areas without a class, or of an unknown class, cannot be deselected.
    assert classes.forbids("", chosen)
    assert classes.forbids("UNHEARD OF", chosen)


def test_a_class_beside_a_type_forbids_too():
    assert classes.forbids("FIS", airspace_class="D")
    assert classes.forbids("CTR", airspace_class="E")
    assert not classes.forbids("FIS", airspace_class="E")
    assert classes.forbids("FIS", classes.forbidding("default,E"), airspace_class="E")
    assert not classes.forbids("FIS", classes.forbidding("CTR"), airspace_class="D")


def test_default_and_all_stand_for_several():
    default = {row.name for row in classes.CLASSES if row.forbids}
    assert classes.forbidding("default") == default
    assert classes.forbidding("default,FIR") == default | {"FIR"}
    assert classes.forbidding("all") == set(classes.BY_NAME)


def test_names_an_unknown_class():
    with pytest.raises(InputError) as caught:
        classes.forbidding("CTR,tower")
    assert str(caught.value).startswith(
        "There is no class of airspace 'tower'; give default, all or some of PROHIBITED, "
    )
    with pytest.raises(InputError):
        classes.forbidding("")


def test_the_page_has_each_class():
    page = Path(__file__).resolve().parents[3] / "docs" / "files.md"
    table = page.read_text().partition("| class | meaning | other words in files |")[2]
    rows = re.findall(r"^\| `(.*?)` \| (.*?) \| (.*?) \| (.*?) \| (.*?) \|$", table, re.MULTILINE)
    assert [tuple(row) for row in rows] == [
        (
            row.name,
            row.meaning,
            ", ".join(row.words) or "-",
            "-" if row.openaip is None else str(row.openaip),
            "yes" if row.forbids else "no",
        )
        for row in classes.CLASSES
    ]
