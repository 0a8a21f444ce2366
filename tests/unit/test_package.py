import configparser
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest


ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: Folders of the package; the last three are links inside the first.
FOLDERS = ("pathgene", "hdl", "host", "sim")
DATA = {
    ".cpp",
    ".css",
    ".hpp",
    ".html",
    ".js",
    ".json",
    ".npz",
    ".toml",
    ".typed",
    ".v",
    ".vlt",
    ".xml",
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the sources, because a build leaves files next to them."""
    folder = tmp_path_factory.mktemp("tree")
    ignore = shutil.ignore_patterns("__pycache__")
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, ignore=ignore, symlinks=True)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    return folder


def build(kind, sources):
    subprocess.run(
        [sys.executable, "-m", "build", f"--{kind}", "--no-isolation", sources],
        check=True,
        stdout=subprocess.DEVNULL,
    )


@pytest.fixture(scope="module")
def wheel(tree):
    build("wheel", tree)
    (path,) = (tree / "dist").glob("*.whl")
    return zipfile.ZipFile(path)


def test_wheel_has_every_source_and_datum(wheel):
    expected = {
        str(path.relative_to(ROOT) if name == "pathgene" else "pathgene" / path.relative_to(ROOT))
        for name in FOLDERS
        for path in (ROOT / name).rglob("*")
        if path.suffix in DATA | {".py"}
    }
    found = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert found == expected
    assert {"pathgene/sim/board/bridge.cpp", "pathgene/sim/board/icarus_top.v"} <= found


def test_wheel_has_one_top_level_name(wheel):
    folders = {name.partition("/")[0] for name in wheel.namelist()}
    assert {name for name in folders if not name.endswith(".dist-info")} == {"pathgene"}


def test_source_archive_builds_the_same_wheel(wheel, tree, tmp_path):
    build("sdist", tree)
    (path,) = (tree / "dist").glob("*.tar.gz")
    with tarfile.open(path) as archive:
        archive.extractall(tmp_path, filter="data")
    (sources,) = tmp_path.iterdir()
    build("wheel", sources)
    (again,) = (sources / "dist").glob("*.whl")
    with zipfile.ZipFile(again) as other:
        contents = {name: other.read(name) for name in other.namelist()}
    ours = {name: wheel.read(name) for name in wheel.namelist()}
    # The list of files, in the last of them, has the row for the licence in a different place.
    assert contents.keys() == ours.keys()
    assert [name for name in ours if contents[name] != ours[name] and "RECORD" not in name] == []


def test_wheel_has_command_and_licence(wheel):
    info = f"pathgene-{PROJECT['version']}.dist-info"
    points = configparser.ConfigParser()
    points.read_string(wheel.read(f"{info}/entry_points.txt").decode())
    assert dict(points["console_scripts"]) == {"pathgene": "pathgene.__main__:program"}
    assert dict(points["pathgene.boards"]) == PROJECT["entry-points"]["pathgene.boards"]
    assert wheel.read(f"{info}/licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()
