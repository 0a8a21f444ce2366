"""The tutorial's ten lines in a new environment, from another folder, after ``pip install``."""

import re
import subprocess
import sys
import venv

import pytest

from tests.docs.pages import ROOT, fences


def run(*command, **options):
    done = subprocess.run(
        [*map(str, command)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        **options,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


def ten_lines():
    """Return the tutorial's program that makes a terrain, and the ten lines that plan over it."""
    terrain, lines, *_ = (
        fence.text for fence in fences("docs/tutorial.md") if fence.language == "python"
    )
    return terrain, lines


def test_at_most_ten_lines():
    _, lines = ten_lines()
    assert len([line for line in lines.splitlines() if line]) <= 10


@pytest.mark.long
def test_pip_install_in_a_new_environment(tmp_path):
    wheels, folder = tmp_path / "wheels", tmp_path / "elsewhere"
    folder.mkdir()
    # A copy, because the build leaves files next to its sources.
    tree = tmp_path / "tree"
    archive = run("git", "-C", ROOT, "ls-files", "-z").split("\0")
    for name in archive:
        if name and (ROOT / name).is_file() and not name.startswith(("tests/", "docs/")):
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_bytes((ROOT / name).read_bytes())
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", wheels, tree)
    (wheel,) = wheels.glob("*.whl")
    venv.create(tmp_path / "new", with_pip=True)
    bin_path = tmp_path / "new" / "bin"
    run(bin_path / "pip", "install", "--disable-pip-version-check", "-q", wheel)
    printed = run(bin_path / "python", "-I", "-c", "\n".join(ten_lines()), cwd=folder)
    assert re.search(
        r"<Plan by ga-fpga: feasible, fitness 1\.\d+, \d+\.\d+ km, \d+ points>", printed
    )
    assert (folder / "out" / "tutorial" / "path.png").is_file()
    run(bin_path / "pathgene", "check", "--path", "out/tutorial/summary.json", cwd=folder)
