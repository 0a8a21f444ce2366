"""Stored results, and the tables of pages."""

import json
from pathlib import Path

import pytest

from bench import store
from bench.store import Store, digest
from pathgene.host.errors import InputError


ROOT = Path(__file__).resolve().parents[3]


def test_results_outlive_the_run_until_their_sources_change(tmp_path, monkeypatch):
    file = tmp_path / "results.json"
    one = Store(file, "bench/report.py")
    assert one.get("row", "part") is None
    one.keep("row", "part", {"F": 1.5})
    one.keep("row", "another part", {"F": 1.25})
    one.keep("a row", "part", {"F": None})
    again = Store(file, "bench/report.py")
    assert again.get("row", "part") == {"F": 1.5}
    assert again.get("row", "third part") is None
    # One line per result, in order.
    assert list(json.loads(file.read_text())) == ["a row", "row"]
    assert len(file.read_text().splitlines()) == 3 + 2 * 2 + 2

    monkeypatch.setattr(store, "digest", lambda *_: "others")
    changed = Store(file, "bench/report.py")
    assert changed.get("row", "part") is None
    changed.keep("row", "part", {"F": 1.75})
    monkeypatch.undo()
    mixed = Store(file, "bench/report.py")
    assert mixed.get("row", "part") is None
    assert mixed.get("row", "another part") == {"F": 1.25}


def test_refuses_a_file_of_something_else(tmp_path):
    file = tmp_path / "results.json"
    file.write_text("# Results")
    with pytest.raises(InputError, match=r"results.json holds no results; remove it or restore it"):
        Store(file)


def test_a_result_may_have_a_digest_of_its_own(tmp_path):
    file = tmp_path / "results.json"
    one, other = Store(file), Store(file)
    one.keep("boards", "ulx3s", {"row": {"LUTs": 7}}, "abc")
    # Each store keeps the results that another has written meanwhile.
    other.keep("boards", "ecpix5", {"row": {"LUTs": 8}}, "def")
    one.keep("units", "line", {"row": {"LUTs": 9}}, "012")
    again = Store(file)
    assert [again.digest("boards", part) for part in ("ulx3s", "ecpix5", "none")] == [
        "abc",
        "def",
        None,
    ]
    assert again.parts("boards") == {"ulx3s": {"row": {"LUTs": 7}}, "ecpix5": {"row": {"LUTs": 8}}}
    assert again.get("units", "line") == {"row": {"LUTs": 9}}
    assert again.parts("none") == {}


@pytest.mark.parametrize(
    ("name", "key"), [("results", "digest"), ("safety", "sources"), ("flights", "sources")]
)
def test_reads_the_committed_files(name, key):
    file = ROOT / "docs" / f"{name}.json"
    store = Store(file) if key == "digest" else Store(file, "bench/report.py")
    content = json.loads(file.read_text())
    for row, parts in content.items():
        assert store.parts(row) == {
            part: {field: value for field, value in result.items() if field != key}
            for part, result in parts.items()
        }
        assert {part: store.digest(row, part) for part in parts} == {
            part: result[key] for part, result in parts.items()
        }


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with one folder, and digests that are not cached between tests."""
    monkeypatch.setattr(store, "_ROOT", tmp_path)
    digest.cache_clear()
    folder = tmp_path / "host" / "deep"
    folder.mkdir(parents=True)
    (folder / "a.py").write_text("1")
    yield tmp_path
    digest.cache_clear()


def anew(*names):
    """Return the digest of the files' current contents."""
    digest.cache_clear()
    return digest(*names)


def test_changes_with_names_and_contents_of_sources(root):
    found = [anew("host")]
    (root / "host" / "deep" / "a.py").write_text("2")
    found.append(anew("host"))
    (root / "host" / "deep" / "a.py").rename(root / "host" / "a.py")
    found.append(anew("host"))
    (root / "host" / "model.xml").write_text("2")
    found.append(anew("host"))
    assert len(set(found)) == 4
    assert all(len(value) == 16 for value in found)


def test_a_file_of_another_kind_or_place_changes_nothing(root):
    before = anew("host/deep")
    (root / "host" / "deep" / "a.pyc").write_text("2")
    (root / "host" / "b.py").write_text("2")
    assert anew("host/deep") == before


def test_of_python_the_code_alone_counts(root):
    file = root / "host" / "deep" / "a.py"
    file.write_text('''"""One."""

def half(x):
    """Return half of x."""
    # Halves are exact.
    return x / 2  # Always.
''')
    before = anew("host")
    file.write_text(
        'def half(x):\n    """Return x / 2.\n\n    Exact.\n    """\n\n    return x / 2\n'
    )
    assert anew("host") == before
    file.write_text('def half(x):\n    "Return x / 2."\n    return "# 2"\n')
    text = anew("host")
    file.write_text('def half(x):\n    "Return x / 2."\n    return "# 3"\n')
    assert len({before, text, anew("host")}) == 3


def test_takes_single_files(root):
    before = anew("host/deep/a.py")
    assert before == anew("host")
    (root / "host" / "deep" / "a.py").write_text("2")
    assert anew("host/deep/a.py") != before


def test_refuses_what_does_not_exist(root):
    with pytest.raises(FileNotFoundError):
        digest("host/gone")
