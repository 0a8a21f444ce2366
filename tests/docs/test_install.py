"""The tutorial's ten lines in a new environment, from another folder, after ``pip install``."""

import re
import subprocess
import sys
import venv

import pytest

from tests.docs.pages import copy_sources, fences


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


@pytest.fixture(scope="module")
def new(tmp_path_factory):
    """Programs of a new environment that has the wheel."""
    folder = tmp_path_factory.mktemp("install")
    # A copy, because the build leaves files next to its sources.
    tree, wheels = folder / "tree", folder / "wheels"
    copy_sources(tree)
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", wheels, tree)
    (wheel,) = wheels.glob("*.whl")
    venv.create(folder / "new", with_pip=True)
    programs = folder / "new" / "bin"
    run(programs / "pip", "install", "--disable-pip-version-check", "-q", wheel)
    return programs


@pytest.mark.long
def test_the_tutorial_runs_from_another_folder(new, tmp_path):
    printed = run(new / "python", "-I", "-c", "\n".join(ten_lines()), cwd=tmp_path)
    assert re.search(
        r"<Plan by ga-fpga: feasible, fitness 1\.\d+, \d+\.\d+ km, \d+ points>", printed
    )
    assert (tmp_path / "out" / "tutorial" / "path.png").is_file()
    run(new / "pathgene", "check", "--path", "out/tutorial/summary.json", cwd=tmp_path)


@pytest.mark.long
def test_one_package_is_installed(new, tmp_path):
    """The folders of the repository are importable as parts of ``pathgene`` alone."""
    version = run(new / "pathgene", "--version", cwd=tmp_path)
    assert run(new / "python", "-m", "pathgene", "--version", cwd=tmp_path) == version
    for name in ("hdl", "host", "sim"):
        run(new / "python", "-c", f"import pathgene.{name}", cwd=tmp_path)
    for name in ("hdl", "host", "sim", "bench", "tools", "tests"):
        done = subprocess.run(
            [new / "python", "-c", f"import {name}"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert f"ModuleNotFoundError: No module named '{name}'" in done.stderr
