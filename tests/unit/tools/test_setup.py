import shutil
import subprocess
import sys
from pathlib import Path

import pytest


TOOLS = Path(__file__).resolve().parents[3] / "tools"


@pytest.fixture
def tree(tmp_path):
    """A project with only the files that the set-up reads."""
    shutil.copytree(TOOLS, tmp_path / "tools")
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "x"\n')
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    (tmp_path / ".venv" / "bin" / "python").write_text("")
    return tmp_path


def ask(tree, code, *, path=None):
    """Run code next to the set-up scripts of a tree, and return its output."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tree / "tools",
        env={"PATH": path or "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def stamp(tree, level):
    code = f"import setup; setup.STAMP.write_text(setup.stamp_of({level!r}))"
    ask(tree, code)


def is_done(tree, level):
    return ask(tree, f"import setup; print(setup.is_done({level!r}))") == "True"


def test_nothing_is_done_at_first(tree):
    assert not is_done(tree, "plan")


@pytest.mark.parametrize(
    ("done", "asked", "expected"),
    [
        ("plan", "plan", True),
        ("plan", "test", False),
        ("test", "plan", True),
        ("test", "test", True),
        ("test", "synth", False),
        ("synth", "test", True),
        ("test", "long", False),
        ("long", "test", True),
        ("long", "long", True),
    ],
)
def test_a_level_includes_those_before(tree, done, asked, expected):
    stamp(tree, done)
    assert is_done(tree, asked) is expected


@pytest.mark.parametrize("name", ["pyproject.toml", "tools/install.py", "tools/setup.py"])
def test_a_change_asks_for_a_new_set_up(tree, name):
    stamp(tree, "test")
    with (tree / name).open("a") as file:
        file.write("\n")
    assert not is_done(tree, "plan")


def test_a_moved_tree_asks_for_a_new_set_up(tree):
    stamp(tree, "test")
    moved = tree.rename(tree.with_name("moved"))
    assert not is_done(moved, "plan")


def test_a_missing_interpreter_asks_for_a_new_set_up(tree):
    stamp(tree, "test")
    (tree / ".venv" / "bin" / "python").unlink()
    assert not is_done(tree, "plan")


def test_second_call_does_no_work(tree):
    stamp(tree, "plan")
    done = subprocess.run(
        [sys.executable, "-ES", tree / "tools" / "setup.py", "plan"],
        env={"PATH": ""},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_wrong_level(tree):
    done = subprocess.run(
        [sys.executable, tree / "tools" / "setup.py", "all"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "Usage: python3 tools/setup.py [plan|test|synth|long]\n"


def test_a_missing_tool_is_named(tree, tmp_path):
    # Neither the tools nor a way to install them are on this path.
    empty = tmp_path / "empty"
    empty.mkdir()
    done = subprocess.run(
        [sys.executable, tree / "tools" / "setup.py", "plan"],
        env={"PATH": str(empty)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr == (
        "setup: g++ and make missing to build the simulated board; "
        "install the Debian package g++ make.\n"
    )


def test_a_tool_of_few_tests_may_be_missing(tree, tmp_path):
    code = "import install; install.require_for_tests('dieharder', 'for a battery')"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tree / "tools",
        env={"PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == (
        "setup: dieharder missing for a battery; install the Debian package dieharder. "
        "Until then the tests with it are skipped.\n"
    )


def test_a_foreign_environment_is_not_used(tree):
    code = "import install, setup; print(install.venv_works(setup.VENV))"
    assert ask(tree, code) == "False"
    (tree / ".venv" / "bin" / "python").unlink()
    (tree / ".venv" / "bin" / "python").symlink_to(sys.executable)
    assert ask(tree, code) == "False"


def test_makefile_reports_an_old_python(tree):
    shutil.copy(TOOLS.parent / "Makefile", tree)
    shutil.rmtree(tree / ".venv")
    bin_ = tree / "bin"
    bin_.mkdir()
    for name in ("bash", "make"):
        (bin_ / name).symlink_to(shutil.which(name))
    old = bin_ / "python3"
    old.write_text("#!/bin/bash\nexit 75\n")
    old.chmod(0o755)
    done = subprocess.run(
        [bin_ / "make", "setup", "SHELL=/bin/bash"],
        cwd=tree,
        env={"PATH": str(bin_)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith(
        "setup: Python 3.11 or newer is missing; install the Debian package python3.\n"
    )
