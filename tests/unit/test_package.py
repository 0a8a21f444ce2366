import configparser
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest


ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PACKAGES = ("hdl", "host", "pathgene", "sim")
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
def wheel(tmp_path_factory):
    """The wheel, built from a copy because the build leaves files beside its sources."""
    tree = tmp_path_factory.mktemp("tree")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", tree],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    (path,) = (tree / "dist").glob("*.whl")
    return zipfile.ZipFile(path)


def test_wheel_has_every_source_and_datum(wheel):
    expected = {
        str(path.relative_to(ROOT))
        for name in PACKAGES
        for path in (ROOT / name).rglob("*")
        if path.suffix in DATA | {".py"}
    }
    found = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert found == expected
    assert {"sim/board/bridge.cpp", "sim/board/icarus_top.v"} <= found


def test_wheel_has_command_and_licence(wheel):
    info = f"pathgene-{PROJECT['version']}.dist-info"
    points = configparser.ConfigParser()
    points.read_string(wheel.read(f"{info}/entry_points.txt").decode())
    assert dict(points["console_scripts"]) == {"pathgene": "pathgene.host.__main__:main"}
    assert dict(points["pathgene.boards"]) == PROJECT["entry-points"]["pathgene.boards"]
    assert wheel.read(f"{info}/licenses/LICENSE") == (ROOT / "LICENSE").read_bytes()
