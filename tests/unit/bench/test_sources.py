"""Digest of sources: it only changes with names and contents of sources."""

import pytest

from bench import sources
from bench.sources import digest


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with one folder, and digests that are not cached between tests."""
    monkeypatch.setattr(sources, "_ROOT", tmp_path)
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
