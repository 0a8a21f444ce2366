"""The table of requirements: complete, in step with pages, units and tests; rows that hold."""

import dataclasses
import shutil

import pytest

from tools.mutation.workshop import Workshop
from tools.requirements.__main__ import main
from tools.requirements.checking import sample, verdict, wrong
from tools.requirements.sentences import sentences
from tools.requirements.table import (
    FILES,
    PAGE,
    ROOT,
    all_rows,
    load,
    mistakes,
    mistakes_of_page,
    mistakes_of_row,
    tables,
    with_tables,
)


#: Folders without kernels.
QUICK = ("hdl/", "host/device/", "host/files/", "host/problem/")


@pytest.fixture(scope="module")
def shop(tmp_path_factory):
    """A copy of the project."""
    folder = tmp_path_factory.mktemp("requirements") / "copy"
    yield Workshop(ROOT, folder, compiled=True)
    shutil.rmtree(folder)


@pytest.mark.parametrize("name", FILES)
def test_every_sentence_has_a_row_and_every_row_its_sentence(name):
    """A row's unit and test exist, and its fault has a place in the unit."""
    assert list(mistakes(load(name))) == []


def test_the_page_has_the_tables():
    """`python -m tools.requirements` rewrites them."""
    page = PAGE.read_text("utf-8")
    assert page == with_tables(page)
    for line in tables().splitlines():
        if line.startswith("| "):
            assert "|  |" not in line, "an empty cell"


PLACES = """\
# Title

First. **Lead.** The `a.b` is [one](x.md#y)
line 2.5 of text (in brackets.) Next: {{layout:x}}

- An item. With two
  sentences?
1. Another.

| key | value |
|---|---|
| `a \\| b` | 1 |

```text
No sentence.
```

## A section: of `it`

![No sentence.](picture.png)

Said {{version}}.
"""


def test_sentences_of_a_page():
    found = [(one.anchor, one.text) for one in sentences(PLACES)]
    assert found == [
        ("title", "First."),
        ("title", "The `a.b` is one line 2.5 of text (in brackets.)"),
        ("title", "An item."),
        ("title", "With two sentences?"),
        ("title", "Another."),
        ("title", "`a \\| b` | 1"),
        ("a-section-of-it", "Said …."),
    ]


def test_a_change_of_a_page_is_told():
    rules = load("rules")
    page = (ROOT / rules.page).read_text("utf-8")
    added = f"{page}\nAircraft must be green.\n"
    assert list(mistakes_of_page(rules, added)) == [
        "docs/rules.md states without a row: Aircraft must be green."
    ]
    reliability = load("reliability")
    added = f"{(ROOT / reliability.page).read_text('utf-8')}\n## Promises\n\nA board is green.\n"
    assert list(mistakes_of_page(reliability, added)) == [
        "docs/reliability.md states without a row: A board is green."
    ]
    sentence = "The burned fuel must leave the reserve."
    told = list(mistakes_of_page(rules, page.replace(sentence, "The fuel must last.")))
    assert told == [
        f"docs/rules.md does not state: fuel | {sentence}",
        "docs/rules.md states without a row: fuel | The fuel must last.",
    ]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"sentences": ()}, "has no sentences"),
        ({"fault": ""}, "has no fault"),
        ({"fault": " "}, "has no fault"),
        ({"unit": "host/nothing.py:f"}, "no file host/nothing.py"),
        ({"unit": "host/problem/rules.py:to_dict"}, "the fault is not in host/problem/rules.py:"),
        ({"unit": "host/problem/limits.py:Limits"}, "occurs 0 times in host/problem/limits.py"),
        ({"new": "clearance_m: ("}, "the fault is a syntax error in line 52"),
        ({"test": "tests/unit/problem/test_rules.py::test_x"}, "no test tests/unit/problem/"),
        ({"test": "tests/unit/problem/test_rules.py"}, "no test tests/unit/problem/test_rules.py"),
        ({"test": "tests/x.py::test_defaults"}, "no test tests/x.py::test_defaults"),
    ],
)
def test_a_wrong_row_is_told(changes, told):
    row = next(row for row in load("rules").rows if row.old == "clearance_m: float = 30.0")
    assert list(mistakes_of_row(row)) == []
    (found,) = mistakes_of_row(dataclasses.replace(row, **changes))
    assert found.startswith(f"{row.name}")
    assert told in found


def test_an_unknown_row_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["--check", "rules-0"])
    assert "no row rules-0; the rows are rules-1, " in capsys.readouterr().err


@pytest.mark.ci
def test_a_test_that_notices_nothing_is_told(shop):
    rows = {row.test: row for row in all_rows()}
    row = rows["tests/unit/problem/test_rules.py::test_defaults"]
    harmless = dataclasses.replace(row, new="clearance_m: float = 30.00")
    assert "does not notice the fault: [('PASSED'" in verdict(shop, harmless)
    # A crash of the whole file proves nothing about the requirement.
    crash = dataclasses.replace(row, new="clearance_m: float = 1 / 0")
    assert "does not notice the fault: [('ERROR'" in verdict(shop, crash, unaltered=False)
    # Neither does a crash in the test.
    crash = dataclasses.replace(row, old="number = real(name, value)", new="number = real(names)")
    assert "does not notice the fault: [('ERROR'" in verdict(shop, crash, unaltered=False)
    hanging = dataclasses.replace(row, old="number = real(name, value)", new="while True: pass")
    shop.limit_s, usual = 1.0, shop.limit_s
    assert "does not notice the fault: [('ERROR'" in verdict(shop, hanging, unaltered=False)
    shop.limit_s = usual
    absent = dataclasses.replace(row, test=f"{row.test}_of_nothing")
    assert "does not pass without the fault" in verdict(shop, absent)

    stale = dataclasses.replace(row, old="no such text")
    assert "'no such text' occurs 0 times" in verdict(shop, stale)
    # The copy is whole again.
    assert (shop.folder / row.file).read_bytes() == (ROOT / row.file).read_bytes()
    assert verdict(shop, row) is None


@pytest.mark.ci
def test_faults_of_a_few_rows_are_noticed(shop):
    """Rows that compile no kernels and start no commands; `make test-long` checks all rows."""
    quick = [
        row
        for row in all_rows()
        if (row.interpreted or row.file.startswith(QUICK)) and "tests/cli/" not in row.test
    ]
    assert list(wrong(shop, sample(quick, seed=2026, count=5), unaltered=False)) == []


@pytest.mark.long
def test_the_fault_of_every_row_is_noticed(shop):
    assert list(wrong(shop, all_rows())) == []
