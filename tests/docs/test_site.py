"""``make docs``: the site builds without warnings and can be read without a network."""

import re
import subprocess
import sys

import pytest

from tests.docs.pages import ROOT


pytestmark = pytest.mark.ci


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the site, built for the test."""
    folder = tmp_path_factory.mktemp("site")
    options = ["-W", "--keep-going", "-q", "-b", "html", "-d", folder / "doctrees"]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, ROOT / "docs", folder / "html"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


def test_every_page_is_there(site):
    pages = {path.stem for path in (ROOT / "docs").glob("*.md")}
    assert pages <= {path.stem for path in site.glob("*.html")}
    assert "Where to find it" in (site / "index.html").read_text("utf-8")


def test_loads_nothing_from_the_network(site):
    loads = re.compile(r'<(?:script|link|img|iframe)\b[^>]*(?:src|href)="(?:https?:)?//[^"]*"')
    styles = re.compile(r"@import\s+(?:url\()?[\"']?(?:https?:)?//|url\([\"']?(?:https?:)?//")
    pages, sheets = list(site.rglob("*.html")), list(site.rglob("*.css"))
    assert pages
    assert sheets
    for path in pages:
        assert not loads.findall(path.read_text("utf-8")), path
    for path in sheets:
        assert not styles.findall(path.read_text("utf-8")), path


def test_the_api_is_documented(site):
    page = (site / "api.html").read_text("utf-8")
    import pathgene

    for name in pathgene.__all__:
        assert f'id="pathgene.{name}"' in page, name


def test_drawings_are_links_to_their_full_size(site):
    page = (site / "architecture.html").read_text("utf-8")
    drawings = {path.name for path in (ROOT / "docs" / "pictures").glob("*.svg")}
    assert drawings
    assert set(re.findall(r'<a [^>]*href="_images/(\w+\.svg)"><img ', page)) == drawings
