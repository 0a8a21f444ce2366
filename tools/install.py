"""Installs what setup.py finds missing; nothing but the standard library is imported here."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path


__all__ = ["SetupError", "set_up"]

# What pip adds to the project for each level.
EXTRAS = {
    "plan": "",
    "test": "[docs,test]",
    "synth": "[docs,test,synth]",
    "long": "[docs,test,synth]",
}


class SetupError(Exception):
    """Something is missing that cannot be installed here; the message is one sentence."""


def set_up(level: str, venv: Path, root: Path) -> None:
    """Install everything of a level.

    Parameters
    ----------
    level : {"plan", "test", "synth", "long"}
        What for.
    venv : Path
        Virtual environment, made if it is missing or not of this Python and place.
    root : Path
        The project, installed so that its sources stay where they are.

    Raises
    ------
    SetupError
        If something is missing that cannot be installed here.
    """
    start = time.monotonic()
    require(["g++", "make"], "to build the simulated board")
    python = venv / "bin" / "python"
    if not venv_works(venv):
        make_venv(venv)
    say(f"installing packages for `{level}` into .venv")
    pip(python, "install", "--editable", f"{root}{EXTRAS[level]}")
    if level != "plan":
        check_libpython(python)
        require_for_tests("iverilog", "for the tests on a second simulator")
    if level == "long":
        require_for_tests("dieharder", "for the battery of random tests")
    say(f"done in {time.monotonic() - start:.0f} s")


def venv_works(venv: Path) -> bool:
    """Return whether it holds a Python of this version that belongs to this place."""
    code = "import pip, sys; print(sys.prefix, *sys.version_info[:2])"
    try:
        found = subprocess.run(
            [venv / "bin" / "python", "-I", "-c", code],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        script = (venv / "bin" / "pip").read_text()
    except (OSError, subprocess.CalledProcessError):
        return False
    major, minor = sys.version_info[:2]
    return found == [str(venv), str(major), str(minor)] and str(venv) in script


def make_venv(venv: Path) -> None:
    """Make it anew, with the Debian package that its Python lacks if need be."""
    package = f"python{sys.version_info.major}.{sys.version_info.minor}-venv"
    if importlib.util.find_spec("ensurepip") is None:
        install([package], f"{sys.executable} cannot make virtual environments")
    say(f"making .venv with {sys.executable}")
    shutil.rmtree(venv, ignore_errors=True)
    # Of the interpreter behind a virtual environment's, which may be the one just removed.
    base = getattr(sys, "_base_executable", sys.executable)
    done = subprocess.run([base, "-m", "venv", venv], stdout=sys.stderr, check=False)
    if done.returncode != 0:
        shutil.rmtree(venv, ignore_errors=True)
        raise SetupError(f"{base} could not make .venv; install the Debian package {package}.")


def pip(python: Path, *arguments: str) -> None:
    """Run pip, its output kept for the case that it fails."""
    command: list[str | Path] = [python, "-m", "pip", "--disable-pip-version-check", *arguments]
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode != 0:
        print(done.stdout, file=sys.stderr)
        raise SetupError("pip failed, for the reason above; check the network and try again.")


def check_libpython(python: Path) -> None:
    """Make sure that a simulator can load Python, as cocotb wants."""
    code = "import find_libpython; print(find_libpython.find_libpython() or '')"
    found = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    if not found.stdout.strip():
        package = f"libpython{sys.version_info.major}.{sys.version_info.minor}"
        install([package], "cocotb needs Python as a shared library")


def require_for_tests(command: str, purpose: str) -> None:
    """As :func:`require`, if possible; else its tests are skipped, and the rest works."""
    try:
        require([command], purpose)
    except SetupError as error:
        say(f"{error} Until then the tests with it are skipped.")


def require(commands: Sequence[str], purpose: str) -> None:
    """Make sure that commands exist, installing the Debian packages, which have their names."""
    missing = [name for name in commands if shutil.which(name) is None]
    if missing:
        install(missing, f"{' and '.join(missing)} missing {purpose}")


def install(packages: Sequence[str], reason: str) -> None:
    """Install Debian packages.

    Raises
    ------
    SetupError
        If that is not possible here; the sentence names them.
    """
    names = " ".join(packages)
    error = SetupError(f"{reason}; install the Debian package {names}.")
    prefix = privilege()
    if prefix is None or shutil.which("apt-get") is None:
        raise error
    say(f"{reason}: apt-get install {names}")
    # The lists of a fresh container are empty: only then, or if they are stale, update them.
    for update in (False, True):
        if update:
            apt(prefix, "update")
        if apt(prefix, "install", "--no-install-recommends", *packages):
            return
    raise error


def privilege() -> list[str] | None:
    """Return the command prefix that gives root's rights without asking; None if none does."""
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") is None:
        return None
    allowed = subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False)
    return ["sudo", "-n"] if allowed.returncode == 0 else None


def apt(prefix: Sequence[str], action: str, *arguments: str) -> bool:
    """Run apt-get without questions; returns whether it worked."""
    command = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-y", action]
    done = subprocess.run([*command, *arguments], capture_output=True, check=False)
    return done.returncode == 0


def say(text: str) -> None:
    """Report progress."""
    print(f"setup: {text}", file=sys.stderr, flush=True)
